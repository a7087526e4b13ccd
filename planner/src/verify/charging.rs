//! Charges of a plan: each at a station, no stretch between two of them longer than the battery lasts, and who waits
//! for whom.
//!
//! The heading after a charge is free: turning at the charger is part of charging.

use super::{TOLERANCE_M, VerifyError};
use crate::{Instance, Plan, Route};

/// When a robot is done, and what it spent at chargers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Shift {
    pub(super) cost_s: f64,
    pub(super) waiting_s: f64,
}

/// Refuses charges away from stations and stretches that take too long.
pub(super) fn check(instance: &Instance<'_>, robot: usize, route: &Route) -> Result<(), VerifyError> {
    let in_order = route.charges.windows(2).all(|pair| pair[0] <= pair[1]);
    let astray =
        route.charges.iter().find(|&&point| !in_order || station_at(instance, route, point).is_none());
    if let Some(&point) = astray {
        return Err(VerifyError::NoStation { robot, point });
    }
    if instance.battery.is_none() {
        return Ok(());
    }
    for (stretch, takes_s) in stretch_times_s(instance, robot, route).into_iter().enumerate() {
        let lasts_s = lasts_s(instance, robot, stretch);
        if takes_s > lasts_s + 1e-6 {
            return Err(VerifyError::BatteryEmpty { robot, stretch, takes_s, lasts_s });
        }
    }
    Ok(())
}

/// Seconds that the battery lasts in a stretch, the reserve left out.
fn lasts_s(instance: &Instance<'_>, robot: usize, stretch: usize) -> f64 {
    let Some(battery) = &instance.battery else { return f64::INFINITY };
    let left_s = instance.starts[robot].charge_s.filter(|_| stretch == 0).unwrap_or(f64::INFINITY);
    (left_s.min(battery.capacity_s) - battery.reserve_s).max(0.0)
}

fn stretch_times_s(instance: &Instance<'_>, robot: usize, route: &Route) -> Vec<f64> {
    let heading_rad = |stretch| instance.starts[robot].heading_rad.filter(|_| stretch == 0);
    let stretches = route.stretches().enumerate();
    stretches.map(|(stretch, points)| instance.path_s(points, heading_rad(stretch))).collect()
}

fn station_at(instance: &Instance<'_>, route: &Route, point: usize) -> Option<usize> {
    let place = route.points.get(point)?;
    instance.stations.iter().position(|station| (instance.dock(station) - place).norm() <= TOLERANCE_M)
}

/// Plays the plan: who comes to a charger first charges first.
pub(super) fn play(instance: &Instance<'_>, plan: &Plan) -> Vec<Shift> {
    let charge_s = instance.battery.map_or(0.0, |battery| battery.charge_s);
    let mut free_from_s = vec![0.0_f64; instance.stations.len()];
    let mut robots: Vec<Robot> =
        plan.routes.iter().enumerate().map(|(robot, route)| Robot::new(instance, robot, route)).collect();
    while let Some((robot, station)) = next_to_charge(&robots) {
        let robot = &mut robots[robot];
        let arrives_s = robot.arrives_s();
        let begins_s = arrives_s.max(free_from_s[station]) + instance.stations[station].queue_s;
        free_from_s[station] = begins_s + charge_s;
        robot.charge(begins_s - arrives_s, begins_s + charge_s);
    }
    robots.iter().map(Robot::shift).collect()
}

fn next_to_charge(robots: &[Robot]) -> Option<(usize, usize)> {
    let waiting = robots.iter().enumerate().filter_map(|(robot, state)| Some((robot, state.charges_at()?)));
    waiting.min_by(|a, b| robots[a.0].arrives_s().total_cmp(&robots[b.0].arrives_s()))
}

/// A robot on its way through its stretches.
struct Robot {
    stretches_s: Vec<f64>,
    stations: Vec<usize>,
    done: usize,
    now_s: f64,
    waiting_s: f64,
}

impl Robot {
    fn new(instance: &Instance<'_>, robot: usize, route: &Route) -> Self {
        let stays = route.points.len() <= 1;
        let charges = route.charges.iter().filter(|_| !stays);
        Self {
            stretches_s: if stays { vec![0.0] } else { stretch_times_s(instance, robot, route) },
            stations: charges.filter_map(|&point| station_at(instance, route, point)).collect(),
            done: 0,
            now_s: if stays { 0.0 } else { instance.starts[robot].available_in_s },
            waiting_s: 0.0,
        }
    }

    fn charges_at(&self) -> Option<usize> {
        self.stations.get(self.done).copied()
    }

    fn arrives_s(&self) -> f64 {
        self.now_s + self.stretches_s[self.done]
    }

    fn charge(&mut self, waits_s: f64, until_s: f64) {
        self.waiting_s += waits_s;
        self.now_s = until_s;
        self.done += 1;
    }

    fn shift(&self) -> Shift {
        Shift { cost_s: self.arrives_s(), waiting_s: self.waiting_s }
    }
}
