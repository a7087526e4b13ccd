//! Batteries ahead: where each robot's route is best broken off to charge, chosen when the route is planned.
//!
//! ```text
//!   plan ──▶ routes are driven at once
//!        └─▶ Output::BreakOffs ──▶ planner::first_break_offs, away from this thread ──▶ Input::BrokenOff ──▶ kept with the route
//! ```
//!
//! A charge on the way costs least where the route passes a station, not where the battery is empty: break points by the
//! dynamic programme of the planner. Only the first is kept: after the charge the remainder is planned anew. The rule of
//! `charging.rs` stays in force, so a choice that comes late, or was made for a battery that drains faster, strands nobody.
//! Where the chosen station is taken when the robot gets there, it goes on until that rule sends it.

use crate::{Coordinator, Output, ledger::RobotIndex, robot::Errand};
use planner::{Battery, BreakOff, Endurance, FirstBreakOff, Instance, Mode, Start, Station};
use std::sync::Arc;
use terrain::{Floor, MotionModel, Point};

/// Kept back beyond the reserve, percent: a choice made by the mean power of a route should be reached before the rule of
/// `charging.rs` breaks off.
const SPARE_PERCENT: f64 = 1.0;

/// Where the routes of a plan are to be broken off, owning its parts, so that it can go to another thread.
#[derive(Debug, Clone)]
pub struct BreakOffRequest {
    /// Number of the plan.
    pub revision: u64,
    floor: Arc<Floor>,
    blocked: Vec<bool>,
    motion: MotionModel,
    visit: Vec<bool>,
    swept: Vec<u64>,
    starts: Vec<Start>,
    stations: Vec<Station>,
    /// The coordinator's numbers of robots and stations, in the order of the above.
    robots: Vec<RobotIndex>,
    station_numbers: Vec<usize>,
    routes: Vec<Endurance>,
}

/// A robot's break: the coordinator's numbers of robot and station, and the way of its route still ahead there, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChosenBreak {
    pub(crate) robot: RobotIndex,
    pub(crate) station: usize,
    pub(crate) ahead_m: f64,
}

/// A break as it is kept with a route.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PlannedBreak {
    /// The plan it belongs to.
    revision: u64,
    /// Nodes of the route that are still ahead there.
    nodes_ahead: u64,
    pub(crate) station: usize,
}

impl BreakOffRequest {
    /// Chooses, here and now.
    pub fn run(&self) -> Vec<ChosenBreak> {
        let instance = Instance {
            visit: self.visit.clone(),
            blocked: self.blocked.clone(),
            swept: self.swept.clone(),
            stations: self.stations.clone(),
            ..Instance::whole_floor(&self.floor, self.starts.clone(), self.motion, Mode::Cover)
        };
        let chosen = planner::first_break_offs(&instance, &self.routes);
        let named = |(found, &robot): (Option<FirstBreakOff>, &RobotIndex)| {
            let FirstBreakOff { ahead_m, station } = found?;
            Some(ChosenBreak { robot, station: self.station_numbers[station], ahead_m })
        };
        chosen.into_iter().zip(&self.robots).filter_map(named).collect()
    }
}

impl Coordinator {
    /// Asks where those of these robots break off whose charge does not last for their new routes.
    pub(crate) fn choose_break_offs(&self, revision: u64, given: &[RobotIndex], out: &mut Vec<Output>) {
        let Some(motion) = self.slowest_motion(given) else { return };
        let station_numbers: Vec<usize> =
            (0..self.stations.len()).filter(|&station| self.station_place(station).is_some()).collect();
        let stations = station_numbers.iter().filter_map(|&station| self.station_place(station)).collect();
        let mut robots = Vec::new();
        let (mut starts, mut routes) = (Vec::new(), Vec::new());
        for &robot in given {
            let number = robots.len();
            if let Some((start, route)) = self.endurance(robot, number, &motion) {
                robots.push(robot);
                starts.push(start);
                routes.push(route);
            }
        }
        if robots.is_empty() || station_numbers.is_empty() {
            return;
        }
        let open = 0..self.floor.lattice().len();
        out.push(Output::BreakOffs(Box::new(BreakOffRequest {
            revision,
            floor: Arc::clone(&self.floor),
            blocked: self.blocked_for_plans(&[], 0.0),
            motion,
            visit: open.map(|cell| self.ledger.is_open(cell)).collect(),
            swept: self.swept_or_granted(given),
            starts,
            stations,
            robots,
            station_numbers,
            routes,
        })));
    }

    /// A station that works, for the planner.
    fn station_place(&self, station: usize) -> Option<Station> {
        let cell = self.station_cell(station).filter(|_| self.station_works(station))?;
        Some(Station { queue_s: self.wait_s(station), ..Station::at(cell) })
    }

    /// A robot's route and what its battery gives on it; `None` where its charge surely lasts to the end and to a station.
    ///
    /// The planner counts seconds: a percent of the battery is as many as it lasts at the mean power of this very route.
    fn endurance(
        &self,
        index: RobotIndex,
        number: usize,
        motion: &MotionModel,
    ) -> Option<(Start, Endurance)> {
        let robot = &self.robots[index];
        let (energy, levels) = (robot.energy?, robot.factsheet.as_ref()?.battery_charging?);
        let points = self.line_ahead(index);
        if points.len() < 2 {
            return None;
        }
        let base: Vec<Point> =
            robot.position().into_iter().chain(robot.route.base().skip(1).map(|node| node.point)).collect();
        let charge = robot.charge_percent() - energy.along_percent(&base, robot.heading_rad(), true);
        let needed = energy.along_percent(&points, None, true);
        let kept_back =
            self.config.timing.reserve_percent.max(levels.minimum_desired_charging_level) + SPARE_PERCENT;
        if self.surely_gets_home(&energy, *points.last()?, charge - needed - kept_back) {
            return None;
        }
        let s_per_percent = motion.path_s(&points, None) / needed;
        let start = self.start_off_lattice(index, motion);
        let battery = Battery {
            capacity_s: levels.sufficient_charging_level * s_per_percent,
            reserve_s: kept_back * s_per_percent,
            charge_s: self.usual_charge_s(levels.sufficient_charging_level - kept_back),
            break_off: BreakOff::Optimal,
        };
        let start = Start { charge_s: Some((charge * s_per_percent).max(0.0)), ..start };
        (battery.budget_s() > 0.0).then_some((start, Endurance { robot: number, battery, points }))
    }

    /// Keeps the breaks that were chosen with the routes they were chosen for.
    pub(crate) fn on_broken_off(&mut self, revision: u64, breaks: &[ChosenBreak]) {
        for &ChosenBreak { robot, station, ahead_m } in breaks {
            let route = &self.robots[robot].route;
            if route.revision() != revision {
                continue;
            }
            let nodes_ahead = route.nodes_in_last_m(ahead_m);
            self.robots[robot].break_off = Some(PlannedBreak { revision, nodes_ahead, station });
        }
    }

    /// The break that a robot has come to: all ground before it is granted.
    pub(crate) fn comes_to_break(&self, index: RobotIndex) -> Option<PlannedBreak> {
        let robot = &self.robots[index];
        let route = &robot.route;
        robot.break_off.filter(|planned| {
            robot.errand == Errand::Cover
                && planned.revision == route.revision()
                && (1..=planned.nodes_ahead).contains(&route.nodes_ahead())
                && self.is_vacant(planned.station)
        })
    }
}
