//! The battery drains faster than its load explains.

use super::{FaultKind, any_robot, between, for_a_while, how_long, now_and_then, number, robot};
use crate::{body::Spell, scenario::Scenario, world::World};
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The battery drains faster than its load explains.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BatteryDrain {
    /// Whose.
    pub robot: String,
    /// How many times faster.
    pub factor: f64,
    /// How long, seconds; left out: for ever.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub for_s: Option<f64>,
}

impl FaultKind for BatteryDrain {
    fn target(&self) -> String {
        self.robot.clone()
    }

    fn check(&self, scenario: &Scenario) -> Result<(), String> {
        robot(scenario, &self.robot)?;
        number("factor", self.factor, 0.0, 1000.0)?;
        for_a_while(self.for_s)
    }

    fn inject(&self, world: &mut World) -> Option<String> {
        let until = world.after(self.for_s);
        world.body_of(&self.robot).ailments.drain = Some(Spell { factor: self.factor, until });
        Some(format!("its battery drains {:.1} times as fast {}", self.factor, how_long(self.for_s)))
    }

    fn random(rng: &mut ChaCha8Rng, scenario: &Scenario) -> Self {
        Self { robot: any_robot(rng, scenario), factor: between(rng, 2.0, 20.0), for_s: now_and_then(rng, 10.0, 60.0) }
    }
}
