//! Ways to the stations, and back along the same line.

mod ground;
mod lattice;

pub(super) use ground::OverGround;
pub(super) use lattice::AlongLattice;

use terrain::{MotionModel, Point};

/// Finds ways to stations.
pub(super) trait Homeward {
    /// The points of a way from a place to a station, both ends included; `None` where there is none.
    fn way(&mut self, place: Point, station: usize) -> Option<Vec<Point>>;
}

/// Seconds that stopping, turning in place by an angle and starting again add to a drive at full speed.
pub(crate) fn corner_s(motion: &MotionModel, angle_rad: f64) -> f64 {
    ramps_s(motion) + motion.turn_s(angle_rad)
}

/// Seconds that starting and stopping add to a run at full speed; no run takes longer for them.
pub(crate) fn ramps_s(motion: &MotionModel) -> f64 {
    let ramp_s = motion.speed_m_per_s / motion.acceleration_m_per_s2;
    if motion.brakes { ramp_s } else { ramp_s / 2.0 }
}
