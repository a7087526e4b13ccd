//! A hanging agent goes on.

use super::{FaultKind, ProcessAction, any_robot, robot};
use crate::{scenario::Scenario, world::World};
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A hanging agent goes on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Thaw {
    /// Whose.
    pub robot: String,
}

impl FaultKind for Thaw {
    fn target(&self) -> String {
        self.robot.clone()
    }

    fn check(&self, scenario: &Scenario) -> Result<(), String> {
        robot(scenario, &self.robot)
    }

    fn inject(&self, world: &mut World) -> Option<String> {
        world.ask(0.0, ProcessAction::Thaw(self.robot.clone()));
        Some("its agent goes on".to_owned())
    }

    fn random(rng: &mut ChaCha8Rng, scenario: &Scenario) -> Self {
        Self { robot: any_robot(rng, scenario) }
    }
}
