//! Puts charges into routes: for any planner, where robots have a battery.
//!
//! ```text
//!   route of a planner ──▶ places along it, each with its ways to the stations and back ──▶ breaks (break_off)
//!                     ◀── up to a break, to the station, back to where it goes on, … ◀──────┘
//! ```
//!
//! A stretch of a route that sweeps nothing new is a transfer: after a charge within it, or at its begin, the robot
//! drives straight to its end. Routes along the lattice are broken off at cells, all others anywhere.

pub(crate) mod break_off;
mod homeward;
mod line;
mod work;

use crate::{Battery, Instance, Plan, PlanError, Route, configuration_space::ConfigurationSpace};
use homeward::{AlongLattice, Homeward, OverGround};
use line::Line;
use terrain::Point;
use work::Work;

/// Puts charges into those routes of a plan that have none and take longer than a battery lasts.
pub(crate) fn with_charges(instance: &Instance<'_>, plan: Plan) -> Result<Plan, PlanError> {
    let Some(battery) = &instance.battery else { return Ok(plan) };
    let work = Work::new(instance, &plan);
    if work.is_along_lattice() {
        charged(instance, battery, plan, work, &mut AlongLattice::new(instance))
    } else {
        let space = ConfigurationSpace::new(instance);
        charged(instance, battery, plan, work, &mut OverGround::new(&space))
    }
}

fn charged<'a>(
    instance: &'a Instance<'a>,
    battery: &Battery,
    mut plan: Plan,
    mut work: Work<'a>,
    homeward: &mut dyn Homeward,
) -> Result<Plan, PlanError> {
    for (robot, route) in plan.routes.iter_mut().enumerate() {
        if route.points.len() > 1 && route.charges.is_empty() {
            let points = std::mem::take(&mut route.points);
            *route = Line::new(instance, robot, &points, homeward, &mut work).charged(battery)?;
        }
    }
    Ok(plan)
}

/// Where a route is broken off for the first time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstBreakOff {
    /// Way of the route still ahead there, metres.
    pub ahead_m: f64,
    /// Number of the station to charge at.
    pub station: usize,
}

/// A robot's route, and its battery.
#[derive(Debug, Clone, PartialEq)]
pub struct Endurance {
    /// Number of the robot.
    pub robot: usize,
    /// What it can do between two charges.
    pub battery: Battery,
    /// Its route from its start on.
    pub points: Vec<Point>,
}

/// Where each battery's rule breaks off its route for the first time; `None` where a charge lasts for all of it, and where
/// none lasts to a place of it and on to a station. The instance's own battery is left out of account.
///
/// # Panics
///
/// When the instance is not sound ([`Instance::check`]), has no such robot, or a route leaves its floor.
pub fn first_break_offs(instance: &Instance<'_>, routes: &[Endurance]) -> Vec<Option<FirstBreakOff>> {
    let instance = &instance.with_open_starts();
    let mut plan = Plan { routes: vec![Route::default(); instance.starts.len()] };
    for route in routes {
        plan.routes[route.robot] = Route::new(route.points.clone());
    }
    let work = Work::new(instance, &plan);
    if work.is_along_lattice() {
        broken_off(instance, routes, work, &mut AlongLattice::new(instance))
    } else {
        let space = ConfigurationSpace::new(instance);
        broken_off(instance, routes, work, &mut OverGround::new(&space))
    }
}

fn broken_off<'a>(
    instance: &'a Instance<'a>,
    routes: &[Endurance],
    mut work: Work<'a>,
    homeward: &mut dyn Homeward,
) -> Vec<Option<FirstBreakOff>> {
    let mut first = |Endurance { robot, battery, points }: &Endurance| {
        let is_driven = points.len() > 1;
        let line = is_driven.then(|| Line::new(instance, *robot, points, homeward, &mut work))?;
        line.first_break_off(battery)
    };
    routes.iter().map(&mut first).collect()
}

#[cfg(test)]
mod tests {
    use crate::{Battery, BreakOff, Instance, Mode, Plan, Route, Start, Station, test_motion::MOTION};
    use terrain::{Cell, Floor, Lattice, MotionModel, Point};

    /// Knows no way from places near one of the lattice.
    struct Blind<'a> {
        ways: super::AlongLattice<'a>,
        nook: Point,
    }

    impl super::Homeward for Blind<'_> {
        fn way(&mut self, place: Point, station: usize) -> Option<Vec<Point>> {
            let is_seen = (place - self.nook).norm() > 0.6;
            is_seen.then(|| self.ways.way(place, station)).flatten()
        }
    }

    #[test]
    fn a_nook_without_a_way_is_left_along_the_line() {
        let lattice = Lattice { origin: Point::origin(), cell_m: 0.5, columns: 12, rows: 1 };
        let floor = Floor::from_cells(lattice, &[true; 12], 0.177, 0.75);
        let place = |column: i32| lattice.center(Cell::new(column, 0));
        let start = Start::at(Cell::new(0, 0));
        let mut instance = Instance::whole_floor(&floor, vec![start], MOTION, Mode::CoverAndReturn);
        instance.stations = vec![Station::at(Cell::new(0, 0))];
        let there: Vec<Point> = (0..11).map(place).collect();
        let back: Vec<Point> = (1..12).rev().map(place).collect();
        let once = [there, back].concat();
        let there_and_back_s = instance.path_s(&once, None);
        let points = [&once[..], &once, &[place(0)]].concat();
        for break_off in [BreakOff::Latest, BreakOff::Optimal] {
            let battery = Battery { break_off, ..Battery::lasting_s(1.3 * there_and_back_s) };
            instance.battery = Some(battery);
            for nook in [0, 6, 11] {
                let plan = Plan { routes: vec![Route::new(points.clone())] };
                let work = super::Work::new(&instance, &plan);
                let mut ways = Blind { ways: super::AlongLattice::new(&instance), nook: place(nook) };
                let charged = super::charged(&instance, &battery, plan, work, &mut ways).unwrap();
                assert!(!charged.routes[0].charges.is_empty(), "{break_off:?} {nook}");
                assert!(crate::verify(&instance, &charged).is_ok(), "{break_off:?} {nook}: {charged:?}");
            }
        }
    }

    /// A wavy line: at full acceleration, driving through bends takes longer than stopping to turn.
    #[test]
    fn charges_hold_on_lines_of_many_bends() {
        let lattice = Lattice { origin: Point::origin(), cell_m: 0.5, columns: 40, rows: 8 };
        let floor = Floor::from_cells(lattice, &[true; 320], 0.177, 0.75);
        let motion = MotionModel {
            acceleration_m_per_s2: f64::INFINITY,
            angular_acceleration_rad_per_s2: f64::INFINITY,
            ..MOTION
        };
        let start = Start::at(Cell::new(0, 4));
        let mut instance = Instance::whole_floor(&floor, vec![start], motion, Mode::CoverAndReturn);
        instance.visit.fill(false);
        instance.visit[39 * 4] = true;
        instance.stations = vec![Station::at(Cell::new(0, 4))];
        let wave = |number: u32| {
            let aside_m = if number.is_multiple_of(2) { 0.06 } else { -0.06 };
            Point::new(0.25 + 0.4 * f64::from(number), 2.25 + aside_m)
        };
        let place = instance.center(Cell::new(0, 4));
        let out: Vec<Point> = std::iter::once(place).chain((1..48).map(wave)).collect();
        let points = [&out[..], &out.iter().rev().skip(1).copied().collect::<Vec<_>>()].concat();
        let there_and_back = instance.path_s(&points, None);
        let points = points.repeat(3);
        for share in 0..12 {
            let lasts_s = there_and_back * (1.02 + 0.03 * f64::from(share));
            instance.battery = Some(Battery { break_off: BreakOff::Latest, ..Battery::lasting_s(lasts_s) });
            let plan = Plan { routes: vec![Route::new(points.clone())] };
            let charged = super::with_charges(&instance, plan).unwrap();
            for stretch in charged.routes[0].stretches() {
                let takes_s = instance.path_s(stretch, None);
                assert!(takes_s <= lasts_s + 1e-6, "{takes_s} {lasts_s}");
            }
            assert!(!charged.routes[0].charges.is_empty());
        }
    }
}
