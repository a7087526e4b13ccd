//! `[network]`: the link between robots and coordinator, in rehearsals only. Real processes have a real one.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What happens to each message on its way, both directions alike.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct NetworkTable {
    /// Time on the way, milliseconds.
    pub delay_ms: f64,
    /// Up to this much more, drawn for each message, milliseconds; messages may overtake each other.
    pub jitter_ms: f64,
    /// Share of messages that are lost, 0 to 1.
    pub loss: f64,
    /// Share of messages that come twice, 0 to 1.
    pub duplicate: f64,
}

impl Default for NetworkTable {
    fn default() -> Self {
        Self { delay_ms: 2.0, jitter_ms: 1.0, loss: 0.0, duplicate: 0.0 }
    }
}
