//! What driving costs a battery, and whether it lasts to a station.

use protocol::v1;
use terrain::{MotionModel, Point, angle_between};

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

    /// Share of a full battery that driving along points costs, percent. `heading_rad` is the heading before.
    pub(crate) fn along_percent(&self, points: &[Point], heading_rad: Option<f64>, tool: bool) -> f64 {
        let length_m: f64 = points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
        let turned_rad = turned_rad(points, heading_rad);
        self.percent(length_m, turned_rad, self.motion.path_s(points, heading_rad), tool)
    }

    /// Share of a full battery that standing still for so long costs, percent.
    pub(crate) fn standing_percent(&self, seconds: f64) -> f64 {
        self.percent(0.0, 0.0, seconds, false)
    }

    /// No way of so many metres over a lattice of `cell_m` costs more than this share of a full battery, tool off,
    /// percent: it turns and stops in every cell.
    pub(crate) fn at_most_percent(&self, length_m: f64, cell_m: f64) -> f64 {
        let turns = length_m / cell_m + 3.0;
        let quarter_s = self.motion.turn_s(std::f64::consts::FRAC_PI_2) + self.motion.run_s(cell_m)
            - cell_m / self.motion.speed_m_per_s;
        let turned_rad = turns * std::f64::consts::FRAC_PI_2;
        self.percent(length_m, turned_rad, self.motion.run_s(length_m) + turns * quarter_s, false)
    }

    fn percent(&self, length_m: f64, turned_rad: f64, seconds: f64, tool: bool) -> f64 {
        let tool_w = if tool { self.tool_w } else { 0.0 };
        let ws = (self.idle_w + tool_w) * seconds
            + self.drive_ws_per_m * length_m
            + self.turn_ws_per_rad * turned_rad;
        ws / 36.0 / self.capacity_wh
    }
}

/// All turns along points, radians.
fn turned_rad(points: &[Point], heading_rad: Option<f64>) -> f64 {
    let mut heading_rad = heading_rad;
    let mut turned_rad = 0.0;
    for pair in points.windows(2) {
        let step = pair[1] - pair[0];
        if step.norm() < 1e-9 {
            continue;
        }
        let towards_rad = step.y.atan2(step.x);
        turned_rad += heading_rad.map_or(0.0, |from_rad| angle_between(from_rad, towards_rad).abs());
        heading_rad = Some(towards_rad);
    }
    turned_rad
}
