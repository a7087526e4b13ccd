//! The robot is slow: a share of its top speeds is left.

use super::{FaultKind, any_robot, between, for_a_while, how_long, now_and_then, number, robot};
use crate::{body::Spell, scenario::Scenario, world::World};
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The robot is slow.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Slow {
    /// Whose.
    pub robot: String,
    /// Share of the top speeds that is left, above 0 to 1.
    pub factor: f64,
    /// How long, seconds; left out: for ever.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub for_s: Option<f64>,
}

impl FaultKind for Slow {
    fn target(&self) -> String {
        self.robot.clone()
    }

    fn check(&self, scenario: &Scenario) -> Result<(), String> {
        robot(scenario, &self.robot)?;
        number("factor", self.factor, 0.01, 1.0)?;
        for_a_while(self.for_s)
    }

    fn inject(&self, world: &mut World) -> Option<String> {
        let until = world.after(self.for_s);
        world.body_of(&self.robot).ailments.slow = Some(Spell { factor: self.factor, until });
        Some(format!("it is slow, {:.0} % of its speed is left {}", 100.0 * self.factor, how_long(self.for_s)))
    }

    fn random(rng: &mut ChaCha8Rng, scenario: &Scenario) -> Self {
        Self { robot: any_robot(rng, scenario), factor: between(rng, 0.2, 0.8), for_s: now_and_then(rng, 5.0, 60.0) }
    }
}
