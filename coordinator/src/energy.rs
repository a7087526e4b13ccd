//! What driving costs a battery, and whether it lasts to a station.

use protocol::v1;
use terrain::{MotionModel, Point};

/// The energy model of a robot's factsheet, with its motion.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Energy {
    capacity_wh: f64,
    idle_w: f64,
    drive_ws_per_m: f64,
    turn_ws_per_rad: f64,
    tool_w: f64,
    motion: MotionModel,
}

impl Energy {
    pub(crate) fn new(model: &v1::EnergyModel, motion: MotionModel) -> Self {
        Self {
            capacity_wh: model.capacity_wh,
            idle_w: model.idle_w,
            drive_ws_per_m: model.drive_w_per_m_per_s,
            turn_ws_per_rad: model.turn_w_per_rad_per_s,
            tool_w: model.tool_w,
            motion,
        }
    }

    /// Share of a full battery that driving along points costs with the tool on, percent.
    pub(crate) fn along_percent(&self, points: &[Point]) -> f64 {
        let length_m: f64 = points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
        let turns = points.windows(3).map(quarters).sum();
        self.percent(length_m, turns, self.motion.path_s(points, None), true)
    }

    /// Share of a full battery that a way of so many metres costs, when every second cell turns (the worst way
    /// on a lattice of `cell_m`), tool off, percent.
    pub(crate) fn home_percent(&self, length_m: f64, cell_m: f64) -> f64 {
        let turns = length_m / (4.0 * cell_m) + 2.0;
        let quarter_s = self.motion.turn_s(std::f64::consts::FRAC_PI_2) + self.motion.run_s(cell_m)
            - cell_m / self.motion.speed_m_per_s;
        self.percent(length_m, turns, self.motion.run_s(length_m) + turns * quarter_s, false)
    }

    fn percent(&self, length_m: f64, quarter_turns: f64, seconds: f64, tool: bool) -> f64 {
        let tool_w = if tool { self.tool_w } else { 0.0 };
        let ws = (self.idle_w + tool_w) * seconds
            + self.drive_ws_per_m * length_m
            + self.turn_ws_per_rad * quarter_turns * std::f64::consts::FRAC_PI_2;
        ws / 36.0 / self.capacity_wh
    }
}

/// The turn from one line to the next, in quarters of a full one.
fn quarters(three: &[Point]) -> f64 {
    let (before, after) = (three[1] - three[0], three[2] - three[1]);
    before.perp(&after).atan2(before.dot(&after)).abs() / std::f64::consts::FRAC_PI_2
}
