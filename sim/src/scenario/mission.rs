//! `[mission]`: what is to be covered, and how.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What is to be covered, and how.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MissionTable {
    /// Id of the mission, `[A-Za-z0-9_.-]{1,64}`.
    #[serde(default = "default_id")]
    pub id: String,
    /// The map: `.map` (`MovingAI`), `.yaml` (ROS `map_server`), `.geojson` or `.json`; relative to this file.
    pub map: String,
    /// Side of one character of a `.map`, or of the squares that polygons are turned into, metres.
    #[serde(default)]
    pub metres_per_character: Option<f64>,
    /// Side of a cell of the lattice, metres. Left out: the largest at which a tool that stands at a cell's
    /// centre sweeps the whole cell, in whole centimetres and at most two thirds of the tool's width.
    #[serde(default)]
    pub cell_m: Option<f64>,
    /// Name of the planner.
    #[serde(default = "default_planner")]
    pub planner: String,
    /// Whether the robots drive back to where they started when everything is covered.
    #[serde(default)]
    pub return_to_start: bool,
    /// Seed of everything that is drawn: noise, planners, people. Same seed, same run.
    #[serde(default)]
    pub seed: u64,
}

fn default_id() -> String {
    "mission".to_owned()
}

fn default_planner() -> String {
    "tmstc-star".to_owned()
}
