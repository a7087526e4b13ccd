//! The agent's process is killed; the robot stops by its watchdog and stays where it is.

use super::{FaultKind, ProcessAction, any_robot, number, robot};
use crate::{scenario::{CarryOff, Scenario}, world::World};
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The agent's process is killed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Kill {
    /// Whose.
    pub robot: String,
    /// How long the machine stays on the floor, seconds, or `"never"` taken off; left out: as `[sim]` says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub carried_off_after_s: Option<CarryOff>,
}

impl FaultKind for Kill {
    fn target(&self) -> String {
        self.robot.clone()
    }

    fn check(&self, scenario: &Scenario) -> Result<(), String> {
        robot(scenario, &self.robot)?;
        match self.carried_off_after_s {
            Some(CarryOff::After(seconds)) => number("carried_off_after_s", seconds, 0.0, 1e6),
            _ => Ok(()),
        }
    }

    fn inject(&self, world: &mut World) -> Option<String> {
        if let Some(carry_off) = self.carried_off_after_s {
            world.body_of(&self.robot).carry_off_after_s = carry_off.seconds();
        }
        world.ask(0.0, ProcessAction::Kill(self.robot.clone()));
        Some("its agent is killed".to_owned())
    }

    fn random(rng: &mut ChaCha8Rng, scenario: &Scenario) -> Self {
        Self { robot: any_robot(rng, scenario), carried_off_after_s: None }
    }
}
