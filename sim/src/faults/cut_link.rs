//! The radio link between a robot and the coordinator is cut, both ways.

use super::{FaultKind, any_robot, between, for_a_while, how_long, robot};
use crate::{body::Spell, scenario::Scenario, world::World};
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The link between a robot and the coordinator is cut, both ways.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CutLink {
    /// Whose.
    pub robot: String,
    /// How long, seconds; left out: for ever.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub for_s: Option<f64>,
}

impl FaultKind for CutLink {
    fn target(&self) -> String {
        self.robot.clone()
    }

    fn check(&self, scenario: &Scenario) -> Result<(), String> {
        robot(scenario, &self.robot)?;
        for_a_while(self.for_s)
    }

    fn inject(&self, world: &mut World) -> Option<String> {
        let until = world.after(self.for_s);
        world.body_of(&self.robot).ailments.cut = Some(Spell { factor: 0.0, until });
        Some(format!("its link is cut {}", how_long(self.for_s)))
    }

    fn random(rng: &mut ChaCha8Rng, scenario: &Scenario) -> Self {
        Self { robot: any_robot(rng, scenario), for_s: Some(between(rng, 0.1, 25.0)) }
    }
}
