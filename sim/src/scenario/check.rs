//! What a scenario must satisfy beyond its grammar: numbers that are numbers, ids that are ids, robots that stand
//! on free ground, and a tool that covers a cell from its centre.

use super::{ScenarioFile, error::Refused};
use protocol::valid_id;
use std::collections::BTreeSet;
use terrain::{Floor, GridMap, Point};

/// Pose and tracking error that a sweep may have and still count, metres; the coordinator's ledger reckons with
/// a tool that is smaller by this all around.
pub const SWEEP_TOLERANCE_M: f64 = 0.04;
/// Distance from a cell's centre to its farthest sample, as a share of its side: the samples lie on an 8 × 8
/// grid, half a step from the edges.
const FARTHEST_SAMPLE: f64 = 0.4375 * std::f64::consts::SQRT_2;

/// The side of a cell when the scenario does not say, metres.
pub(crate) fn default_cell_m(tool_width_m: f64) -> f64 {
    let largest = largest_cell_m(tool_width_m).min(tool_width_m / 1.5);
    (largest * 100.0 + 1e-6).floor() / 100.0
}

fn largest_cell_m(tool_width_m: f64) -> f64 {
    (tool_width_m / 2.0 - SWEEP_TOLERANCE_M) / FARTHEST_SAMPLE
}

/// Checks that need no map.
pub(crate) fn check_values(file: &ScenarioFile) -> Result<(), Refused> {
    check_mission(file)?;
    check_robot(file)?;
    check_sim(file)?;
    check_timing(file)?;
    check_cell(file)
}

fn check_mission(file: &ScenarioFile) -> Result<(), Refused> {
    let mission = &file.mission;
    id("mission.id", &mission.id)?;
    if let Some(metres) = mission.metres_per_character {
        within("mission.metres_per_character", metres, 1e-3, 1e4)?;
    }
    if planner::planners::by_name(&mission.planner).is_none() && !planner::PLANNERS.is_empty() {
        let what =
            format!("no planner is called `{}`; there are: {}", mission.planner, planner::planners::names());
        return Err(Refused::new("mission.planner", what));
    }
    Ok(())
}

fn check_robot(file: &ScenarioFile) -> Result<(), Refused> {
    let robot = &file.robot;
    within("robot.body_radius_m", robot.body_radius_m, 0.01, 100.0)?;
    within("robot.tool_width_m", robot.tool_width_m, 0.01, 100.0)?;
    within("robot.speed_m_per_s", robot.speed_m_per_s, 0.01, 10.0)?;
    within("robot.acceleration_m_per_s2", robot.acceleration_m_per_s2, 0.01, 100.0)?;
    within("robot.angular_speed_rad_per_s", robot.angular_speed_rad_per_s, 0.01, 50.0)?;
    within("robot.angular_acceleration_rad_per_s2", robot.angular_acceleration_rad_per_s2, 0.01, 1000.0)?;
    within("robot.state_interval_ms", f64::from(robot.state_interval_ms), 20.0, 10_000.0)?;
    within("robot.range_finder_m", robot.range_finder_m, 0.0, 100.0)?;
    within("robot.beams", f64::from(robot.beams), 0.0, 128.0)?;
    let battery = &robot.battery;
    within("robot.battery.capacity_wh", battery.capacity_wh, 1e-3, 1e6)?;
    within("robot.battery.initial_percent", battery.initial_percent, 0.0, 100.0)?;
    within("robot.battery.idle_w", battery.idle_w, 0.0, 1e6)?;
    within("robot.battery.drive_w_per_m_per_s", battery.drive_w_per_m_per_s, 0.0, 1e6)?;
    within("robot.battery.turn_w_per_rad_per_s", battery.turn_w_per_rad_per_s, 0.0, 1e6)?;
    within("robot.battery.tool_w", battery.tool_w, 0.0, 1e6)?;
    let charging = &robot.charging;
    within("robot.charging.critical_low_percent", charging.critical_low_percent, 0.0, 100.0)?;
    within("robot.charging.charge_w", charging.charge_w, 0.0, 1e6)?;
    rising("minimum_desired_percent", charging.critical_low_percent, charging.minimum_desired_percent)?;
    rising("sufficient_percent", charging.minimum_desired_percent, charging.sufficient_percent)?;
    rising("maximum_desired_percent", charging.sufficient_percent, charging.maximum_desired_percent)
}

fn rising(key: &str, before: f64, value: f64) -> Result<(), Refused> {
    let key = format!("robot.charging.{key}");
    within(&key, value, 0.0, 100.0)?;
    if value >= before {
        return Ok(());
    }
    let what = format!(
        "is {value}, below the threshold before it ({before}); order: critical_low, minimum_desired, sufficient, maximum_desired"
    );
    Err(Refused::new(key, what))
}

fn check_sim(file: &ScenarioFile) -> Result<(), Refused> {
    let sim = &file.sim;
    if sim.carry_off_after_s.seconds() < 0.0 || sim.carry_off_after_s.seconds().is_nan() {
        return Err(Refused::new("sim.carry_off_after_s", "must be a number of seconds, or \"never\""));
    }
    within("sim.fix_sigma_m", sim.fix_sigma_m, 0.0, 0.1)?;
    within("sim.fix_heading_sigma_rad", sim.fix_heading_sigma_rad, 0.0, 0.1)?;
    within("sim.odometry_error", sim.odometry_error, 0.0, 0.1)?;
    let network = &file.network;
    within("network.delay_ms", network.delay_ms, 0.0, 60_000.0)?;
    within("network.jitter_ms", network.jitter_ms, 0.0, 60_000.0)?;
    within("network.loss", network.loss, 0.0, 1.0)?;
    within("network.duplicate", network.duplicate, 0.0, 1.0)
}

fn check_timing(file: &ScenarioFile) -> Result<(), Refused> {
    let timing = &file.coordinator;
    let positive = [
        ("suspect_after_s", timing.suspect_after_s),
        ("lost_after_s", timing.lost_after_s),
        ("lease_s", timing.lease_s),
        ("base_length_m", timing.base_length_m),
        ("wait_threshold_s", timing.wait_threshold_s),
        ("stuck_after_s", timing.stuck_after_s),
        ("join_timeout_s", timing.join_timeout_s),
        ("muster_s", timing.muster_s),
        ("abandoned_after_s", timing.abandoned_after_s),
    ];
    positive
        .into_iter()
        .try_for_each(|(key, value)| within(&format!("coordinator.{key}"), value, 1e-3, 1e6))?;
    within("coordinator.reserve_percent", timing.reserve_percent, 0.0, 100.0)
}

/// A tool at the centre of a cell must sweep the whole cell: a disc leaves corners.
fn check_cell(file: &ScenarioFile) -> Result<(), Refused> {
    let tool_width_m = file.robot.tool_width_m;
    let cell_m = file.cell_m();
    let largest_m = largest_cell_m(tool_width_m);
    if largest_m <= 0.0 || cell_m <= 0.0 {
        let what = format!(
            "is {tool_width_m} m; below {:.2} m nothing is left after pose error",
            2.0 * SWEEP_TOLERANCE_M + 0.02
        );
        return Err(Refused::new("robot.tool_width_m", what));
    }
    if cell_m.is_nan() || cell_m > largest_m {
        let least = 2.0 * (cell_m * FARTHEST_SAMPLE + SWEEP_TOLERANCE_M);
        let what = format!(
            "is {cell_m} m, too coarse: a disc of {tool_width_m} m at a cell's centre leaves its corners. \
             Take at most {:.2} m, or a tool of at least {least:.2} m",
            (largest_m * 100.0).floor() / 100.0
        );
        return Err(Refused::new("mission.cell_m", what));
    }
    Ok(())
}

/// Checks of robots and stations on their floor.
pub(crate) fn check_places(file: &ScenarioFile, map: &GridMap, floor: &Floor) -> Result<(), Refused> {
    let mut ids = BTreeSet::new();
    let radius_m = file.robot.body_radius_m;
    for (number, robot) in file.robots.iter().enumerate() {
        let key = |name: &str| format!("robots[{number}].{name}");
        unique(&mut ids, key("id"), &robot.id)?;
        within(&key("theta_deg"), robot.theta_deg, -360.0, 360.0)?;
        let at = place(&key("x_m"), &key("y_m"), robot.x_m, robot.y_m)?;
        if !map.disc_is_free(at, radius_m) {
            let what = format!(
                "robot `{}` would start in a wall at ({}, {}) m; {}",
                robot.id,
                at.x,
                at.y,
                nearest_free(floor, at)
            );
            return Err(Refused::new(key("x_m"), what));
        }
        if floor.nearest_drivable(map, at).is_none() {
            let what = format!(
                "robot `{}` cannot drive from ({}, {}) m to any cell; {}",
                robot.id,
                at.x,
                at.y,
                nearest_free(floor, at)
            );
            return Err(Refused::new(key("x_m"), what));
        }
        for other in &file.robots[..number] {
            if (at - Point::new(other.x_m, other.y_m)).norm() < 2.0 * radius_m {
                let what = format!(
                    "robots `{}` and `{}` start in one another; set them {:.2} m apart or more",
                    other.id,
                    robot.id,
                    2.0 * radius_m
                );
                return Err(Refused::new(key("x_m"), what));
            }
        }
    }
    let mut ids = BTreeSet::new();
    for (number, station) in file.stations.iter().enumerate() {
        let key = |name: &str| format!("stations[{number}].{name}");
        unique(&mut ids, key("id"), &station.id)?;
        let at = place(&key("x_m"), &key("y_m"), station.x_m, station.y_m)?;
        if !map.disc_is_free(at, radius_m) || floor.nearest_drivable(map, at).is_none() {
            let what = format!(
                "no robot can dock at station `{}` at ({}, {}) m: it is in or at a wall; {}",
                station.id,
                at.x,
                at.y,
                nearest_free(floor, at)
            );
            return Err(Refused::new(key("x_m"), what));
        }
    }
    Ok(())
}

fn nearest_free(floor: &Floor, at: Point) -> String {
    let lattice = floor.lattice();
    let distance = |cell: &terrain::Cell| (lattice.center(*cell) - at).norm();
    let best = lattice
        .cells()
        .filter(|&cell| floor.cell_is_drivable(cell))
        .min_by(|a, b| distance(a).total_cmp(&distance(b)));
    best.map_or_else(String::new, |cell| {
        let center = lattice.center(cell);
        format!("the nearest free place is ({:.2}, {:.2}) m", center.x, center.y)
    })
}

fn unique<'a>(ids: &mut BTreeSet<&'a str>, key: String, value: &'a str) -> Result<(), Refused> {
    id(&key, value)?;
    if ids.insert(value) {
        Ok(())
    } else {
        Err(Refused::new(key, format!("`{value}` is there twice; give each its own id")))
    }
}

fn id(key: &str, value: &str) -> Result<(), Refused> {
    if valid_id(value) {
        Ok(())
    } else {
        Err(Refused::new(key, format!("`{value}` is no id: use 1 to 64 of A-Z a-z 0-9 _ . -")))
    }
}

fn place(x_key: &str, y_key: &str, x: f64, y: f64) -> Result<Point, Refused> {
    within(x_key, x, -1e6, 1e6)?;
    within(y_key, y, -1e6, 1e6)?;
    Ok(Point::new(x, y))
}

pub(crate) fn within(key: &str, value: f64, min: f64, max: f64) -> Result<(), Refused> {
    if value >= min && value <= max {
        Ok(())
    } else {
        Err(Refused::new(key, format!("is {value}; expected a number from {min} to {max}")))
    }
}
