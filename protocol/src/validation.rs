//! What a decoded message must satisfy before anybody acts on it: finite numbers inside the map, good ids,
//! lists no longer than stated.

use crate::v1;
use thiserror::Error;

/// The box in which positions make sense, metres: the map and 10 m around it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Left edge.
    pub x_min: f64,
    /// Lower edge.
    pub y_min: f64,
    /// Right edge.
    pub x_max: f64,
    /// Upper edge.
    pub y_max: f64,
}

impl Bounds {
    /// Anything finite.
    pub const ANYWHERE: Self = Self { x_min: -1e7, y_min: -1e7, x_max: 1e7, y_max: 1e7 };

    fn holds(&self, x: f64, y: f64) -> bool {
        x >= self.x_min && x <= self.x_max && y >= self.y_min && y <= self.y_max
    }
}

/// Why a message is refused.
#[derive(Debug, Error, PartialEq)]
pub enum Invalid {
    /// A number that is not finite, or outside what makes sense.
    #[error("`{field}` is {value}")]
    Number {
        /// Name of the field.
        field: &'static str,
        /// Its value.
        value: String,
    },
    /// A list longer than allowed.
    #[error("`{field}` has {found} entries; at most {max} are taken")]
    TooMany {
        /// Name of the field.
        field: &'static str,
        /// Its length.
        found: usize,
        /// The limit.
        max: usize,
    },
    /// An id that is not `[A-Za-z0-9_.-]{1,64}`.
    #[error("`{0}` is not an id: 1 to 64 of A-Z a-z 0-9 _ . -")]
    Id(String),
    /// A part that must be there and is not.
    #[error("`{0}` is missing")]
    Missing(&'static str),
}

/// A message that can be checked before anybody acts on it.
pub trait Validate {
    /// Refuses what must not be acted upon.
    ///
    /// # Errors
    ///
    /// [`Invalid`]: the first thing found wrong.
    fn validate(&self, bounds: &Bounds) -> Result<(), Invalid>;
}

/// Whether a text is an id: 1 to 64 of `A-Z a-z 0-9 _ . -`.
pub fn valid_id(id: &str) -> bool {
    (1..=64).contains(&id.len())
        && id.bytes().all(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'.' | b'-'))
}

impl Validate for v1::Header {
    fn validate(&self, _: &Bounds) -> Result<(), Invalid> {
        if valid_id(&self.serial_number) { Ok(()) } else { Err(Invalid::Id(self.serial_number.clone())) }
    }
}

impl Validate for v1::State {
    fn validate(&self, bounds: &Bounds) -> Result<(), Invalid> {
        self.header.as_ref().ok_or(Invalid::Missing("header"))?.validate(bounds)?;
        pose(self.pose.as_ref().ok_or(Invalid::Missing("pose"))?, bounds)?;
        within("deviation_m", self.deviation_m, 0.0, 100.0)?;
        within("speed_m_per_s", self.speed_m_per_s, -100.0, 100.0)?;
        within("angular_speed_rad_per_s", self.angular_speed_rad_per_s, -100.0, 100.0)?;
        within("state_of_charge_percent", self.state_of_charge_percent, 0.0, 100.0)?;
        within("swept_distance_m", self.swept_distance_m, 0.0, 1e9)?;
        if !self.station_id.is_empty() && !valid_id(&self.station_id) {
            return Err(Invalid::Id(self.station_id.clone()));
        }
        at_most("errors", self.errors.len(), 16)?;
        for error in &self.errors {
            at_most("errors.points", error.points.len(), 64)?;
            at_most("errors.error_description", error.error_description.len(), 512)?;
            at_most("errors.error_hint", error.error_hint.len(), 512)?;
            error.points.iter().try_for_each(|point| place("errors.points", point.x_m, point.y_m, bounds))?;
        }
        at_most("sweep", self.sweep.len(), 64)?;
        for vertex in &self.sweep {
            place("sweep", vertex.x_m, vertex.y_m, bounds)?;
            within("sweep.deviation_m", vertex.deviation_m, 0.0, 100.0)?;
        }
        self.scan.as_ref().map_or(Ok(()), |scan| scan.validate(bounds))
    }
}

impl Validate for v1::RangeScan {
    fn validate(&self, _: &Bounds) -> Result<(), Invalid> {
        at_most("scan.ranges_m", self.ranges_m.len(), 128)?;
        within("scan.range_max_m", self.range_max_m, 0.0, 1000.0)?;
        within("scan.angle_min_rad", self.angle_min_rad, -10.0, 10.0)?;
        within("scan.angle_increment_rad", self.angle_increment_rad, -10.0, 10.0)?;
        self.ranges_m.iter().try_for_each(|&range| within("scan.ranges_m", f64::from(range), 0.0, 1000.0))
    }
}

impl Validate for v1::Factsheet {
    fn validate(&self, bounds: &Bounds) -> Result<(), Invalid> {
        self.header.as_ref().ok_or(Invalid::Missing("header"))?.validate(bounds)?;
        at_most("series_name", self.series_name.len(), 64)?;
        within("body_radius_m", self.body_radius_m, 1e-3, 100.0)?;
        within("tool_width_m", self.tool_width_m, 1e-3, 100.0)?;
        within("speed_max_m_per_s", self.speed_max_m_per_s, 1e-3, 100.0)?;
        within("acceleration_max_m_per_s2", self.acceleration_max_m_per_s2, 1e-3, 1000.0)?;
        within("angular_speed_max_rad_per_s", self.angular_speed_max_rad_per_s, 1e-3, 100.0)?;
        within(
            "angular_acceleration_max_rad_per_s2",
            self.angular_acceleration_max_rad_per_s2,
            1e-3,
            1000.0,
        )?;
        within("range_finder_m", self.range_finder_m, 0.0, 1000.0)?;
        let charging = self.battery_charging.as_ref().ok_or(Invalid::Missing("battery_charging"))?;
        within("critical_low_charging_level", charging.critical_low_charging_level, 0.0, 100.0)?;
        within("minimum_desired_charging_level", charging.minimum_desired_charging_level, 0.0, 100.0)?;
        within("sufficient_charging_level", charging.sufficient_charging_level, 0.0, 100.0)?;
        within("maximum_desired_charging_level", charging.maximum_desired_charging_level, 0.0, 100.0)?;
        let energy = self.energy_model.as_ref().ok_or(Invalid::Missing("energy_model"))?;
        within("capacity_wh", energy.capacity_wh, 1e-6, 1e9)?;
        within("idle_w", energy.idle_w, 0.0, 1e9)?;
        within("drive_w_per_m_per_s", energy.drive_w_per_m_per_s, 0.0, 1e9)?;
        within("turn_w_per_rad_per_s", energy.turn_w_per_rad_per_s, 0.0, 1e9)?;
        within("tool_w", energy.tool_w, 0.0, 1e9)
    }
}

impl Validate for v1::Connection {
    fn validate(&self, bounds: &Bounds) -> Result<(), Invalid> {
        self.header.as_ref().ok_or(Invalid::Missing("header"))?.validate(bounds)
    }
}

impl Validate for v1::Order {
    fn validate(&self, bounds: &Bounds) -> Result<(), Invalid> {
        at_most("nodes", self.nodes.len(), 4096)?;
        if !self.station_id.is_empty() && !valid_id(&self.station_id) {
            return Err(Invalid::Id(self.station_id.clone()));
        }
        for pair in self.nodes.windows(2) {
            if pair[1].sequence_id <= pair[0].sequence_id {
                return Err(Invalid::Number {
                    field: "nodes.sequence_id",
                    value: format!("{} after {}", pair[1].sequence_id, pair[0].sequence_id),
                });
            }
        }
        self.nodes.iter().try_for_each(|node| place("nodes", node.x_m, node.y_m, bounds))
    }
}

impl Validate for v1::Grant {
    fn validate(&self, _: &Bounds) -> Result<(), Invalid> {
        within("lease_ms", f64::from(self.lease_ms), 0.0, 3_600_000.0)
    }
}

impl Validate for v1::InstantActions {
    fn validate(&self, _: &Bounds) -> Result<(), Invalid> {
        at_most("actions", self.actions.len(), 16)
    }
}

impl Validate for v1::BaseState {
    fn validate(&self, bounds: &Bounds) -> Result<(), Invalid> {
        pose(self.odometry.as_ref().ok_or(Invalid::Missing("odometry"))?, &Bounds::ANYWHERE)?;
        pose(self.fix.as_ref().ok_or(Invalid::Missing("fix"))?, bounds)?;
        within("fix_deviation_m", self.fix_deviation_m, 0.0, 100.0)?;
        within("speed_m_per_s", self.speed_m_per_s, -100.0, 100.0)?;
        within("angular_speed_rad_per_s", self.angular_speed_rad_per_s, -100.0, 100.0)?;
        within("state_of_charge_percent", self.state_of_charge_percent, 0.0, 100.0)?;
        self.scan.as_ref().map_or(Ok(()), |scan| scan.validate(bounds))
    }
}

impl Validate for v1::Setpoint {
    fn validate(&self, _: &Bounds) -> Result<(), Invalid> {
        within("speed_m_per_s", self.speed_m_per_s, -100.0, 100.0)?;
        within("angular_speed_rad_per_s", self.angular_speed_rad_per_s, -100.0, 100.0)
    }
}

impl Validate for v1::OperatorCommand {
    fn validate(&self, _: &Bounds) -> Result<(), Invalid> {
        at_most("who", self.who.len(), 64)?;
        if self.serial_number.is_empty() || valid_id(&self.serial_number) {
            Ok(())
        } else {
            Err(Invalid::Id(self.serial_number.clone()))
        }
    }
}

impl Validate for v1::FaultCommand {
    fn validate(&self, _: &Bounds) -> Result<(), Invalid> {
        at_most("toml", self.toml.len(), 4096)
    }
}

fn pose(pose: &v1::Pose, bounds: &Bounds) -> Result<(), Invalid> {
    place("pose", pose.x_m, pose.y_m, bounds)?;
    within("pose.theta_rad", pose.theta_rad, -1e4, 1e4)
}

fn place(field: &'static str, x: f64, y: f64, bounds: &Bounds) -> Result<(), Invalid> {
    if bounds.holds(x, y) { Ok(()) } else { Err(Invalid::Number { field, value: format!("({x}, {y})") }) }
}

fn within(field: &'static str, value: f64, min: f64, max: f64) -> Result<(), Invalid> {
    if value >= min && value <= max {
        Ok(())
    } else {
        Err(Invalid::Number { field, value: value.to_string() })
    }
}

fn at_most(field: &'static str, found: usize, max: usize) -> Result<(), Invalid> {
    if found <= max { Ok(()) } else { Err(Invalid::TooMany { field, found, max }) }
}
