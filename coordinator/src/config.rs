//! What the coordinator is told at its start.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use terrain::{GridMap, Point};

/// Time constants and thresholds; seconds of mission time. The `[coordinator]` table of a scenario.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Timing {
    /// Silence after which a robot is SUSPECT: no new ground, its horizon goes to others.
    pub suspect_after_s: f64,
    /// Silence after which a robot is LOST.
    pub lost_after_s: f64,
    /// How long a grant lasts, from the robot's own request.
    pub lease_s: f64,
    /// How far ahead of a robot ground is granted, metres.
    pub base_length_m: f64,
    /// How long a robot may stand before an obstacle until the place counts as blocked.
    pub wait_threshold_s: f64,
    /// How long a robot with granted ground may make no progress until it counts as stuck.
    pub stuck_after_s: f64,
    /// How often a blocked place is looked at again before it is given up.
    pub looks_max: u32,
    /// How long to wait for the first agent.
    pub join_timeout_s: f64,
    /// How long to wait for the rest of the expected fleet after the first agent joined.
    pub muster_s: f64,
    /// How long a mission without a living robot waits for one before it ends as FAILED.
    pub abandoned_after_s: f64,
    /// Energy kept for the way to a station, as a share of a full battery, percent.
    pub reserve_percent: f64,
}

impl Default for Timing {
    fn default() -> Self {
        Self {
            suspect_after_s: 0.5,
            lost_after_s: 1.5,
            lease_s: 3.0,
            base_length_m: 2.5,
            wait_threshold_s: 4.0,
            stuck_after_s: 8.0,
            looks_max: 3,
            join_timeout_s: 10.0,
            muster_s: 5.0,
            abandoned_after_s: 45.0,
            reserve_percent: 10.0,
        }
    }
}

/// A charging station.
#[derive(Debug, Clone, PartialEq)]
pub struct Station {
    /// Its id.
    pub id: String,
    /// Where a robot docks, metres.
    pub position: Point,
}

/// What is to be covered, and by which kind of robot.
#[derive(Debug, Clone)]
pub struct Mission {
    /// Id of the mission, `[A-Za-z0-9_.-]{1,64}`.
    pub id: String,
    /// The map.
    pub map: Arc<GridMap>,
    /// Side of a cell, metres.
    pub cell_m: f64,
    /// Radius of the robots' bodies, metres.
    pub body_radius_m: f64,
    /// Diameter of the tool's disc, metres.
    pub tool_width_m: f64,
    /// The chargers.
    pub stations: Vec<Station>,
    /// Name of the planner.
    pub planner: String,
    /// Whether the robots return to their starts at the end.
    pub return_to_start: bool,
    /// The robots that are expected (planning waits for them up to `muster_s`).
    pub robots: Vec<String>,
}

/// Everything the coordinator is told at its start.
#[derive(Debug, Clone)]
pub struct Config {
    /// What is to be done.
    pub mission: Mission,
    /// When to decide what.
    pub timing: Timing,
    /// Number of this coordinator's start; rises with each (from the journal, once there is one).
    pub term: u64,
    /// Seed for what is drawn.
    pub seed: u64,
}
