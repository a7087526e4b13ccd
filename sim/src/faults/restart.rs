//! The agent's process is killed and started anew: it remembers nothing, and has another boot id.

use super::{FaultKind, ProcessAction, any_robot, between, number, robot};
use crate::{scenario::Scenario, world::World};
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The agent's process is killed and started anew.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Restart {
    /// Whose.
    pub robot: String,
    /// How long it is gone, seconds.
    #[serde(default = "default_after_s")]
    pub after_s: f64,
}

fn default_after_s() -> f64 {
    1.0
}

impl FaultKind for Restart {
    fn target(&self) -> String {
        self.robot.clone()
    }

    fn check(&self, scenario: &Scenario) -> Result<(), String> {
        robot(scenario, &self.robot)?;
        number("after_s", self.after_s, 0.0, 1e6)
    }

    fn inject(&self, world: &mut World) -> Option<String> {
        world.ask(0.0, ProcessAction::Kill(self.robot.clone()));
        world.ask(self.after_s, ProcessAction::Restart(self.robot.clone()));
        Some(format!("its agent is killed, and started anew after {:.1} s", self.after_s))
    }

    fn random(rng: &mut ChaCha8Rng, scenario: &Scenario) -> Self {
        Self { robot: any_robot(rng, scenario), after_s: between(rng, 0.1, 30.0) }
    }
}
