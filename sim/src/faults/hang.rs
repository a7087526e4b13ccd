//! The agent's process is stopped (SIGSTOP) and goes on later, as if no time had passed for it.

use super::{FaultKind, ProcessAction, any_robot, between, for_a_while, how_long, robot};
use crate::{scenario::Scenario, world::World};
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The agent's process hangs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Hang {
    /// Whose.
    pub robot: String,
    /// How long, seconds; left out: until a `thaw`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub for_s: Option<f64>,
}

impl FaultKind for Hang {
    fn target(&self) -> String {
        self.robot.clone()
    }

    fn check(&self, scenario: &Scenario) -> Result<(), String> {
        robot(scenario, &self.robot)?;
        for_a_while(self.for_s)
    }

    fn inject(&self, world: &mut World) -> Option<String> {
        world.ask(0.0, ProcessAction::Hang(self.robot.clone()));
        if let Some(seconds) = self.for_s {
            world.ask(seconds, ProcessAction::Thaw(self.robot.clone()));
        }
        Some(format!("its agent hangs {}", how_long(self.for_s)))
    }

    fn random(rng: &mut ChaCha8Rng, scenario: &Scenario) -> Self {
        Self { robot: any_robot(rng, scenario), for_s: Some(between(rng, 0.1, 25.0)) }
    }
}
