//! How the robots of tests drive.

use terrain::MotionModel;

pub(crate) const MOTION: MotionModel = MotionModel {
    speed_m_per_s: 0.5,
    acceleration_m_per_s2: 0.6,
    angular_speed_rad_per_s: 0.8,
    angular_acceleration_rad_per_s2: f64::INFINITY,
    brakes: true,
};
