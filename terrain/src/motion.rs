//! How long a robot takes: the one time model that planners, the coordinator's estimates and the agent's
//! speed profile share, so that planned and driven times agree.

use crate::{Point, Stretch};

/// A differential drive: straight runs with a trapezoidal speed profile, gentle bends driven through (see
/// [`Stretch`]), turns in place at corners.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionModel {
    /// Top speed, m/s.
    pub speed_m_per_s: f64,
    /// Acceleration and braking, m/s².
    pub acceleration_m_per_s2: f64,
    /// Top turning speed in place, rad/s.
    pub angular_speed_rad_per_s: f64,
    /// Angular acceleration, rad/s²; infinite when turns start and stop at once (as in the papers).
    pub angular_acceleration_rad_per_s2: f64,
    /// Whether a run ends with braking (as driven), or only starts with a ramp (equation 8 of TMSTC*).
    pub brakes: bool,
}

impl MotionModel {
    /// Time for a straight run from standstill over `length_m` metres, seconds.
    pub fn run_s(&self, length_m: f64) -> f64 {
        if self.brakes {
            trapezoid_s(length_m, self.speed_m_per_s, self.acceleration_m_per_s2)
        } else {
            let ramp_m = self.speed_m_per_s * self.speed_m_per_s / (2.0 * self.acceleration_m_per_s2);
            if length_m <= ramp_m {
                (2.0 * length_m / self.acceleration_m_per_s2).sqrt()
            } else {
                length_m / self.speed_m_per_s + self.speed_m_per_s / (2.0 * self.acceleration_m_per_s2)
            }
        }
    }

    /// Time for a turn in place by `angle_rad` (its size counts), seconds.
    pub fn turn_s(&self, angle_rad: f64) -> f64 {
        let angle = angle_rad.abs();
        if self.angular_acceleration_rad_per_s2.is_finite() {
            trapezoid_s(angle, self.angular_speed_rad_per_s, self.angular_acceleration_rad_per_s2)
        } else {
            angle / self.angular_speed_rad_per_s
        }
    }

    /// Time to drive a line of points from standstill to standstill, turning in place at each corner, seconds.
    /// `heading_rad` is the heading before the start; `None` when the first heading is free. What bends by no more
    /// than [`CORNER_RAD`](crate::CORNER_RAD) at each point is driven through when the model brakes at all.
    pub fn path_s(&self, points: &[Point], heading_rad: Option<f64>) -> f64 {
        let mut total_s = 0.0;
        let mut heading = heading_rad;
        let mut rest = points;
        while let Some((stretch, used)) = Stretch::first(rest, self.brakes) {
            let turn = heading.map_or(0.0, |from| angle_between(from, stretch.heading_at_start_rad()));
            if turn.abs() > 1e-6 {
                total_s += self.turn_s(turn);
            }
            total_s += self.stretch_s(&stretch);
            heading = Some(stretch.heading_at_end_rad());
            rest = &rest[used - 1..];
        }
        total_s
    }

    fn stretch_s(&self, stretch: &Stretch) -> f64 {
        if stretch.is_straight() { self.run_s(stretch.length_m()) } else { stretch.speeds(self).total_s() }
    }

    /// Distance to stop from `speed_m_per_s`, metres.
    pub fn stopping_distance_m(&self, speed_m_per_s: f64) -> f64 {
        speed_m_per_s * speed_m_per_s / (2.0 * self.acceleration_m_per_s2)
    }
}

/// The turn from one heading to another, in (-π, π].
pub fn angle_between(from_rad: f64, to_rad: f64) -> f64 {
    let turn = (to_rad - from_rad).rem_euclid(std::f64::consts::TAU);
    if turn > std::f64::consts::PI { turn - std::f64::consts::TAU } else { turn }
}

fn trapezoid_s(distance: f64, speed: f64, acceleration: f64) -> f64 {
    if distance <= 0.0 {
        0.0
    } else if distance < speed * speed / acceleration {
        2.0 * (distance / acceleration).sqrt()
    } else {
        distance / speed + speed / acceleration
    }
}
