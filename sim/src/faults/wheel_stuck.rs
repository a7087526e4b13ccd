//! The wheels turn and the robot does not move: something holds it.

use super::{FaultKind, any_robot, for_a_while, how_long, now_and_then, robot};
use crate::{body::Spell, scenario::Scenario, world::World};
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The wheels turn and the robot does not move.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WheelStuck {
    /// Whose.
    pub robot: String,
    /// How long, seconds; left out: for ever.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub for_s: Option<f64>,
}

impl FaultKind for WheelStuck {
    fn target(&self) -> String {
        self.robot.clone()
    }

    fn check(&self, scenario: &Scenario) -> Result<(), String> {
        robot(scenario, &self.robot)?;
        for_a_while(self.for_s)
    }

    fn inject(&self, world: &mut World) -> Option<String> {
        let until = world.after(self.for_s);
        world.body_of(&self.robot).ailments.slip = Some(Spell { factor: 0.0, until });
        Some(format!("its wheels turn, it does not move {}", how_long(self.for_s)))
    }

    fn random(rng: &mut ChaCha8Rng, scenario: &Scenario) -> Self {
        Self { robot: any_robot(rng, scenario), for_s: now_and_then(rng, 2.0, 40.0) }
    }
}
