//! A charging station gives nothing.

use super::{FaultKind, for_a_while, how_long, now_and_then};
use crate::{scenario::Scenario, station::Outage, world::World};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A charging station gives nothing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StationOutOfOrder {
    /// Which.
    pub station: String,
    /// How long, seconds; left out: for ever.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub for_s: Option<f64>,
}

impl FaultKind for StationOutOfOrder {
    fn target(&self) -> String {
        self.station.clone()
    }

    fn check(&self, scenario: &Scenario) -> Result<(), String> {
        for_a_while(self.for_s)?;
        let ids: Vec<&str> = scenario.file.stations.iter().map(|station| station.id.as_str()).collect();
        if ids.contains(&self.station.as_str()) {
            return Ok(());
        }
        Err(format!("`station` is `{}`; there are: {}", self.station, ids.join(", ")))
    }

    fn inject(&self, world: &mut World) -> Option<String> {
        let until = world.after(self.for_s);
        for charger in world.chargers.iter_mut().filter(|charger| charger.id == self.station) {
            charger.outage = Some(Outage { until });
        }
        Some(format!("it gives nothing {}", how_long(self.for_s)))
    }

    /// Only for scenarios with stations.
    fn random(rng: &mut ChaCha8Rng, scenario: &Scenario) -> Self {
        let stations = &scenario.file.stations;
        Self {
            station: stations[rng.random_range(0..stations.len())].id.clone(),
            for_s: now_and_then(rng, 10.0, 120.0),
        }
    }
}
