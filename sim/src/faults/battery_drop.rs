//! The battery falls to a lower charge at once: a dead cell, or a meter that was wrong.

use super::{FaultKind, any_robot, between, number, robot};
use crate::{scenario::Scenario, world::World};
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The battery falls to a lower charge at once.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BatteryDrop {
    /// Whose.
    pub robot: String,
    /// What is left, percent of full.
    pub to_percent: f64,
}

impl FaultKind for BatteryDrop {
    fn target(&self) -> String {
        self.robot.clone()
    }

    fn check(&self, scenario: &Scenario) -> Result<(), String> {
        robot(scenario, &self.robot)?;
        number("to_percent", self.to_percent, 0.0, 100.0)
    }

    fn inject(&self, world: &mut World) -> Option<String> {
        world.body_of(&self.robot).battery.drop_to(self.to_percent);
        Some(format!("its battery falls to {:.0} %", self.to_percent))
    }

    fn random(rng: &mut ChaCha8Rng, scenario: &Scenario) -> Self {
        Self { robot: any_robot(rng, scenario), to_percent: between(rng, 5.0, 40.0) }
    }
}
