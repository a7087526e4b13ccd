//! A battery: what is in it, and what the load takes out.

use crate::scenario::{BatteryTable, RobotTable};

/// The battery of one robot.
#[derive(Debug, Clone)]
pub(crate) struct Battery {
    table: BatteryTable,
    charge_w: f64,
    left_wh: f64,
}

/// What a robot does that takes energy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Load {
    pub(crate) speed_m_per_s: f64,
    pub(crate) angular_speed_rad_per_s: f64,
    pub(crate) tool_active: bool,
}

impl Battery {
    pub(crate) fn new(robot: &RobotTable) -> Self {
        let table = robot.battery.clone();
        let left_wh = table.capacity_wh * table.initial_percent / 100.0;
        Self { table, charge_w: robot.charging.charge_w, left_wh }
    }

    /// Takes out what `load` needs in `step_s`, times `factor`.
    pub(crate) fn drain(&mut self, load: Load, factor: f64, step_s: f64) {
        let table = &self.table;
        let power_w = table.idle_w
            + table.drive_w_per_m_per_s * load.speed_m_per_s.abs()
            + table.turn_w_per_rad_per_s * load.angular_speed_rad_per_s.abs()
            + if load.tool_active { table.tool_w } else { 0.0 };
        self.left_wh = (self.left_wh - power_w * factor * step_s / 3600.0).max(0.0);
    }

    /// Puts in what a station gives in `step_s`.
    pub(crate) fn charge(&mut self, step_s: f64) {
        self.left_wh = (self.left_wh + self.charge_w * step_s / 3600.0).min(self.table.capacity_wh);
    }

    /// Falls to `percent` at once; never rises.
    pub(crate) fn drop_to(&mut self, percent: f64) {
        self.left_wh = self.left_wh.min(self.table.capacity_wh * percent / 100.0);
    }

    pub(crate) fn percent(&self) -> f64 {
        100.0 * self.left_wh / self.table.capacity_wh
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.left_wh <= 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STANDING: Load = Load { speed_m_per_s: 0.0, angular_speed_rad_per_s: 0.0, tool_active: false };

    #[test]
    fn an_hour_at_idle_takes_the_idle_power() {
        let mut battery = Battery::new(&RobotTable::default());
        battery.drain(STANDING, 1.0, 3600.0);
        assert!((battery.percent() - 100.0 * (120.0 - 15.0) / 120.0).abs() < 1e-9);
    }

    #[test]
    fn driving_turning_and_the_tool_cost_extra() {
        let mut battery = Battery::new(&RobotTable::default());
        battery.drain(
            Load { speed_m_per_s: -1.0, angular_speed_rad_per_s: 0.5, tool_active: true },
            1.0,
            36.0,
        );
        assert!((battery.percent() - 100.0 * (1.0 - (15.0 + 40.0 + 6.0 + 60.0) * 0.01 / 120.0)).abs() < 1e-9);
    }

    #[test]
    fn it_ends_at_nothing_and_fills_up_to_full() {
        let mut battery = Battery::new(&RobotTable::default());
        battery.drain(STANDING, 1e6, 3600.0);
        assert!(battery.is_empty());
        battery.charge(7200.0);
        assert!((battery.percent() - 100.0).abs() < 1e-9);
    }

    #[test]
    fn a_drop_never_fills() {
        let mut battery = Battery::new(&RobotTable::default());
        battery.drop_to(30.0);
        battery.drop_to(60.0);
        assert!((battery.percent() - 30.0).abs() < 1e-9);
    }
}
