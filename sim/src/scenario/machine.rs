//! `[robot]`: what every robot of the fleet is and can do. Its factsheet says the same to the coordinator.

use protocol::v1;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use terrain::MotionModel;

/// What every robot of the fleet is and can do.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RobotTable {
    /// Name of the type.
    pub series_name: String,
    /// Radius of the body (a disc), metres.
    pub body_radius_m: f64,
    /// Diameter of the tool (a disc under the middle of the robot), metres.
    pub tool_width_m: f64,
    /// Top speed, m/s.
    pub speed_m_per_s: f64,
    /// Acceleration and braking, m/s².
    pub acceleration_m_per_s2: f64,
    /// Top turning speed, rad/s.
    pub angular_speed_rad_per_s: f64,
    /// Angular acceleration, rad/s².
    pub angular_acceleration_rad_per_s2: f64,
    /// How often it reports its state, milliseconds.
    pub state_interval_ms: u32,
    /// Reach of the range finder, metres.
    pub range_finder_m: f64,
    /// Beams of the range finder, all around; at most 128.
    pub beams: u32,
    /// What its battery holds.
    pub battery: BatteryTable,
    /// When it charges.
    pub charging: ChargingTable,
}

/// What a battery holds, and what takes it away.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BatteryTable {
    /// Full, watt hours.
    pub capacity_wh: f64,
    /// At the start, percent of full.
    pub initial_percent: f64,
    /// Always, watts.
    pub idle_w: f64,
    /// Driving, watts per m/s.
    pub drive_w_per_m_per_s: f64,
    /// Turning, watts per rad/s.
    pub turn_w_per_rad_per_s: f64,
    /// Tool on, watts.
    pub tool_w: f64,
}

/// Charging: thresholds in percent of full (the words are VDA 5050's), and the charger's power.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ChargingTable {
    /// Below this the robot should stand at a charger.
    pub critical_low_percent: f64,
    /// Below this it is sent to a charger.
    pub minimum_desired_percent: f64,
    /// From here on it may be called away.
    pub sufficient_percent: f64,
    /// Here charging ends.
    pub maximum_desired_percent: f64,
    /// What a station gives, watts.
    pub charge_w: f64,
}

impl Default for RobotTable {
    fn default() -> Self {
        Self {
            series_name: "oxplow-disc".to_owned(),
            body_radius_m: 0.177,
            tool_width_m: 0.75,
            speed_m_per_s: 1.0,
            acceleration_m_per_s2: 0.8,
            angular_speed_rad_per_s: 1.5,
            angular_acceleration_rad_per_s2: 3.0,
            state_interval_ms: 100,
            range_finder_m: 3.0,
            beams: 120,
            battery: BatteryTable::default(),
            charging: ChargingTable::default(),
        }
    }
}

impl Default for BatteryTable {
    fn default() -> Self {
        Self {
            capacity_wh: 120.0,
            initial_percent: 100.0,
            idle_w: 15.0,
            drive_w_per_m_per_s: 40.0,
            turn_w_per_rad_per_s: 12.0,
            tool_w: 60.0,
        }
    }
}

impl Default for ChargingTable {
    fn default() -> Self {
        Self {
            critical_low_percent: 10.0,
            minimum_desired_percent: 25.0,
            sufficient_percent: 80.0,
            maximum_desired_percent: 95.0,
            charge_w: 600.0,
        }
    }
}

impl RobotTable {
    /// What such a robot says of itself; header and process id are the agent's to fill in.
    pub fn factsheet(&self) -> v1::Factsheet {
        v1::Factsheet {
            header: None,
            series_name: self.series_name.clone(),
            body_radius_m: self.body_radius_m,
            tool_width_m: self.tool_width_m,
            speed_max_m_per_s: self.speed_m_per_s,
            acceleration_max_m_per_s2: self.acceleration_m_per_s2,
            angular_speed_max_rad_per_s: self.angular_speed_rad_per_s,
            angular_acceleration_max_rad_per_s2: self.angular_acceleration_rad_per_s2,
            state_interval_ms: self.state_interval_ms,
            battery_charging: Some(v1::BatteryCharging {
                critical_low_charging_level: self.charging.critical_low_percent,
                minimum_desired_charging_level: self.charging.minimum_desired_percent,
                sufficient_charging_level: self.charging.sufficient_percent,
                maximum_desired_charging_level: self.charging.maximum_desired_percent,
            }),
            energy_model: Some(v1::EnergyModel {
                capacity_wh: self.battery.capacity_wh,
                idle_w: self.battery.idle_w,
                drive_w_per_m_per_s: self.battery.drive_w_per_m_per_s,
                turn_w_per_rad_per_s: self.battery.turn_w_per_rad_per_s,
                tool_w: self.battery.tool_w,
            }),
            range_finder_m: self.range_finder_m,
            pid: 0,
        }
    }

    /// How fast such a robot is, for planners.
    pub fn motion(&self) -> MotionModel {
        MotionModel {
            speed_m_per_s: self.speed_m_per_s,
            acceleration_m_per_s2: self.acceleration_m_per_s2,
            angular_speed_rad_per_s: self.angular_speed_rad_per_s,
            angular_acceleration_rad_per_s2: self.angular_acceleration_rad_per_s2,
            brakes: true,
        }
    }
}
