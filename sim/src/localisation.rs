//! Where a robot believes it is: wheels that count a little wrong, and fixes that are bounded.

use crate::{
    random_streams::{bounded_noise, stream},
    scenario::SimTable,
};
use protocol::v1;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use terrain::{Pose, Vector};

/// The localisation of one robot.
#[derive(Debug, Clone)]
pub(crate) struct Localisation {
    rng: ChaCha8Rng,
    sigma_m: f64,
    heading_sigma_rad: f64,
    way_scale: f64,
    turn_scale: f64,
    odometry: Pose,
    fix: v1::Pose,
    fix_sequence: u64,
}

impl Localisation {
    pub(crate) fn new(table: &SimTable, seed: u64, robot: &str, at: Pose) -> Self {
        let mut rng = stream(seed, "localisation", robot);
        let error = table.odometry_error;
        let way_scale = 1.0 + error * (2.0 * rng.random::<f64>() - 1.0);
        let turn_scale = 1.0 + error * (2.0 * rng.random::<f64>() - 1.0);
        let mut localisation = Self {
            rng,
            sigma_m: table.fix_sigma_m,
            heading_sigma_rad: table.fix_heading_sigma_rad,
            way_scale,
            turn_scale,
            odometry: at,
            fix: v1::Pose::default(),
            fix_sequence: 0,
        };
        localisation.take_fix(at);
        localisation
    }

    /// The wheels turned: by so much way, by so much heading.
    pub(crate) fn roll(&mut self, way_m: f64, turn_rad: f64) {
        self.odometry *= arc(way_m * self.way_scale, turn_rad * self.turn_scale);
    }

    /// A new fix of the true pose.
    pub(crate) fn take_fix(&mut self, truth: Pose) {
        let mut noise = |sigma| bounded_noise(&mut self.rng, sigma);
        self.fix = v1::Pose {
            x_m: truth.translation.x + noise(self.sigma_m),
            y_m: truth.translation.y + noise(self.sigma_m),
            theta_rad: truth.rotation.angle() + noise(self.heading_sigma_rad),
        };
        self.fix_sequence += 1;
    }

    pub(crate) fn odometry(&self) -> v1::Pose {
        pose_message(&self.odometry)
    }

    pub(crate) fn fix(&self) -> (u64, v1::Pose) {
        (self.fix_sequence, self.fix)
    }

    /// No fix is farther from the truth than this, metres.
    pub(crate) fn deviation_m(&self) -> f64 {
        2.3 * self.sigma_m * std::f64::consts::SQRT_2
    }
}

/// The motion of a differential drive that rolls `way_m` while it turns by `turn_rad`.
pub(crate) fn arc(way_m: f64, turn_rad: f64) -> Pose {
    if turn_rad.abs() < 1e-12 {
        return Pose::new(Vector::new(way_m, 0.0), 0.0);
    }
    let radius_m = way_m / turn_rad;
    Pose::new(Vector::new(radius_m * turn_rad.sin(), radius_m * (1.0 - turn_rad.cos())), turn_rad)
}

pub(crate) fn pose_message(pose: &Pose) -> v1::Pose {
    v1::Pose { x_m: pose.translation.x, y_m: pose.translation.y, theta_rad: pose.rotation.angle() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn a_quarter_circle_ends_beside_its_centre() {
        let end = arc(FRAC_PI_2, FRAC_PI_2);
        assert!((end.translation.vector - Vector::new(1.0, 1.0)).norm() < 1e-12);
        assert!((end.rotation.angle() - FRAC_PI_2).abs() < 1e-12);
    }

    #[test]
    fn fixes_stay_within_their_bound() {
        let truth = Pose::new(Vector::new(3.0, 4.0), 1.0);
        let mut localisation = Localisation::new(&SimTable::default(), 1, "r1", truth);
        for _ in 0..2000 {
            localisation.take_fix(truth);
            let (_, fix) = localisation.fix();
            let error_m = (fix.x_m - 3.0).hypot(fix.y_m - 4.0);
            assert!(error_m <= localisation.deviation_m(), "{error_m}");
        }
        assert!(localisation.deviation_m() < 0.01);
    }
}
