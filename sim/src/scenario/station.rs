//! `[[stations]]`: where robots charge.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A charging station.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StationEntry {
    /// Its id, `[A-Za-z0-9_.-]{1,64}`.
    pub id: String,
    /// Where a robot docks, metres.
    pub x_m: f64,
    /// Where a robot docks, metres.
    pub y_m: f64,
}
