//! The wheels slip: the robot makes less way than its odometry says.

use super::{FaultKind, any_robot, between, for_a_while, how_long, number, robot};
use crate::{body::Spell, scenario::Scenario, world::World};
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The wheels slip: the robot makes less way than its odometry says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WheelSlip {
    /// Whose.
    pub robot: String,
    /// Share of the way that it makes, 0 to 1.
    pub factor: f64,
    /// How long, seconds; left out: for ever.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub for_s: Option<f64>,
}

impl FaultKind for WheelSlip {
    fn target(&self) -> String {
        self.robot.clone()
    }

    fn check(&self, scenario: &Scenario) -> Result<(), String> {
        robot(scenario, &self.robot)?;
        number("factor", self.factor, 0.0, 1.0)?;
        for_a_while(self.for_s)
    }

    fn inject(&self, world: &mut World) -> Option<String> {
        let until = world.after(self.for_s);
        world.body_of(&self.robot).ailments.slip = Some(Spell { factor: self.factor, until });
        Some(format!("its wheels slip, it makes {:.0} % of its way {}", 100.0 * self.factor, how_long(self.for_s)))
    }

    fn random(rng: &mut ChaCha8Rng, scenario: &Scenario) -> Self {
        Self { robot: any_robot(rng, scenario), factor: between(rng, 0.3, 0.9), for_s: Some(between(rng, 2.0, 40.0)) }
    }
}
