//! Lanes: straight lanes of the tool's width, as few as possible, and one tour over them.
//!
//! **Problem.** Cover free ground of any shape with a round tool in as little time as possible, turns included; the body must
//! not touch anything on the way.
//! **Idea.** Lay a lattice of tool-wide squares over the ground and choose for each square whether it is driven along or
//! across so that the lanes are as few as can be (a minimum cut). Put each lane where the body fits and sweeps most of what
//! its squares need for its time; it bends round small obstacles, and ends where going on sweeps too little. Join the
//! lanes to a tour, each driven either way, with shortest ways for the body priced by the time of their turns, and improve
//! it by local search. Then, in turns: leave out lanes that sweep too little that nothing else on the way sweeps, and bend
//! lanes, or add short ones, where that sweeps the most for its time, until the coverage asked for is reached.
//! **Guarantee.** The lanes are a minimum for the lattice (the code asserts that the cut is the number of runs). What is
//! missing by the measure of verify gets side trips, which get to whatever can be asked for. No way touches a wall.
//! None on the length of the tour.
//! **Complexity.** O(E √V) for the cut of V squares, O(n) bounded searches for the ways between the ends of n lanes.
//! **Paper.** H. Choset: Coverage of known spaces: the boustrophedon cellular decomposition. Autonomous Robots 9, 2000, is where the
//! motion comes from; lanes instead of cells and the cut are ours.
//! **Departures.** No cells: the tour may interleave them.

mod balancing;
mod placing;
mod profile;
mod ranked;
mod residue;
mod sharing;
mod splitting;

use crate::{
    Instance, Mode, Plan, PlanError, PlanOptions, Route,
    configuration_space::ConfigurationSpace,
    ground::Ground,
    lane_tour::{LaneTour, Stop},
    minimum_lanes::{Orientation, ToolLattice},
    transfers::{Transfers, Way},
};
use placing::{Lines, Worth};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use terrain::Point;

/// Shares of a square by which the lattice is moved, along and across.
const SHIFTS: [[f64; 2]; 3] = [[0.0, 0.0], [1.0 / 3.0, 1.0 / 3.0], [2.0 / 3.0, 2.0 / 3.0]];
/// More is swept than asked for by this share, so that rims do not decide.
const COVERAGE_MARGIN: f64 = 0.0005;
/// Steps of the local search for each lane and effort.
const STEPS: u64 = 60;
/// How often the order is improved, lanes that are not worth it are left out, and what is left is swept.
const ROUNDS: usize = 2;
/// A second is worth this share of what a tool at full work sweeps in it.
const WORTH: f64 = 0.1;
/// What is left is swept by lanes as short as this makes them.
const WORTH_OF_REST: f64 = 0.05;
/// A share of the ground that could not be swept counts as so many times that share of the time.
const MISSING: f64 = 10.0;
/// Without effort, so many times what is missing is looked at together.
const BREADTH: f64 = 4.0;
/// Lines for what is left lie this share of a tool apart.
const STEPS_ASIDE: f64 = 8.0;

/// Plans.
#[allow(clippy::unnecessary_wraps, reason = "the table of planners wants it")]
pub(super) fn plan(instance: &Instance<'_>, options: &PlanOptions) -> Result<Plan, PlanError> {
    let space = ConfigurationSpace::new(instance);
    let mut plan = Plan { routes: vec![Route::default(); instance.starts.len()] };
    for robots in splitting::groups(&space) {
        let own = (robots.len() < instance.starts.len()).then(|| space.only(&robots));
        let own = own.as_ref().unwrap_or(&space);
        let mut piece = Piece { space: own, ground: Ground::new(own), robots: &robots, options };
        if piece.ground.left_count() > 0 {
            piece.plan(&mut plan);
        }
    }
    Ok(plan)
}

/// Ground that some robots reach, and these.
struct Piece<'p, 'a> {
    space: &'p ConfigurationSpace<'a>,
    ground: Ground,
    robots: &'p [usize],
    options: &'p PlanOptions,
}

impl<'p, 'a> Piece<'p, 'a> {
    fn plan(&mut self, plan: &mut Plan) {
        let (orientation, mut tour) = self.best_tour();
        if self.options.effort > 0 {
            self.refine(&orientation, &mut tour);
        }
        let (stops, home) = tour.stops();
        match self.robots {
            [only] => plan.routes[*only] = Route::new(points(&stops, home)),
            // Where no lane is worth driving, side trips are left.
            _ if stops.is_empty() => {}
            _ => self.share(&stops, plan),
        }
    }

    /// The best of tours over lattices that are moved a little. Without effort there is but one, and it stays as it is.
    fn best_tour(&mut self) -> (Orientation, LaneTour<'p, 'a>) {
        let shifts = if self.options.effort == 0 { &SHIFTS[..1] } else { &SHIFTS };
        let mut best: Option<(f64, Orientation, LaneTour<'p, 'a>)> = None;
        for &shift in shifts {
            self.ground.clear();
            let orientation = Orientation::minimum(ToolLattice::new(self.space, &self.ground, shift));
            let mut tour = self.first_tour(&orientation);
            tour.improve(0, &mut ChaCha8Rng::seed_from_u64(self.options.seed));
            self.balance(&orientation, &mut tour, &mut self.worth());
            // What is missing still will cost something, too.
            let missing = (self.goal() - self.ground.coverage()).max(0.0);
            let time_s = tour.time_s() * (1.0 + MISSING * missing);
            if best.as_ref().is_none_or(|(least_s, ..)| time_s < *least_s) {
                best = Some((time_s, orientation, tour));
            }
        }
        let (_, orientation, tour) = best.expect("there is a lattice");
        (orientation, tour)
    }

    fn first_tour(&mut self, orientation: &Orientation) -> LaneTour<'p, 'a> {
        let (space, worth) = (self.space, self.worth());
        let instance = space.instance();
        let mut transfers = Transfers::new(space);
        let lanes = placing::lanes(space, &mut transfers, &mut self.ground, orientation, worth);
        let start = instance.place(&instance.starts[self.robots[0]]);
        LaneTour::new(transfers, start, lanes, instance.mode == Mode::CoverAndReturn)
    }

    /// Improves the order, and balances again what that changes.
    fn refine(&mut self, orientation: &Orientation, tour: &mut LaneTour<'p, 'a>) {
        let mut random = ChaCha8Rng::seed_from_u64(self.options.seed);
        let steps = |tour: &LaneTour<'_, '_>| u64::from(self.options.effort) * STEPS * tour.len() as u64;
        let mut worth = self.worth();
        for _ in 0..ROUNDS {
            tour.improve(steps(tour), &mut random);
            self.balance(orientation, tour, &mut worth);
        }
        tour.improve(steps(tour), &mut random);
        sweep_tour(&mut self.ground, tour);
        let (lines, goal, breadth) = (self.lines(orientation), self.goal(), self.breadth());
        residue::sweep(tour, &mut self.ground, &lines, goal, breadth);
    }

    /// Leaves out what is not worth it, and sweeps what is missing then.
    fn balance(&mut self, orientation: &Orientation, tour: &mut LaneTour<'p, 'a>, worth: &mut Worth) {
        sweep_tour(&mut self.ground, tour);
        let (lines, goal, breadth) = (self.lines(orientation), self.goal(), self.breadth());
        balancing::leave_out(tour, &mut self.ground, *worth, goal);
        if let Some(per_s) = residue::sweep(tour, &mut self.ground, &lines, goal, breadth) {
            worth.per_s *= (per_s / worth.per_s).sqrt().clamp(0.7, 1.3);
        }
    }

    fn goal(&self) -> f64 {
        (self.space.instance().coverage_min + COVERAGE_MARGIN).min(1.0)
    }

    /// How many patches are looked at, as a multiple of what is missing.
    fn breadth(&self) -> f64 {
        if self.options.effort == 0 { BREADTH } else { f64::INFINITY }
    }

    fn worth(&self) -> Worth {
        Worth::new(self.space.instance(), self.ground.samples().cell_m, WORTH)
    }

    /// Lines along and across, for what is left.
    fn lines<'l>(&self, orientation: &'l Orientation) -> [Lines<'l, 'a>; 2]
    where
        'p: 'l,
    {
        let instance = self.space.instance();
        let worth = Worth::new(instance, self.ground.samples().cell_m, WORTH_OF_REST).without_turns();
        [true, false].map(|is_along| Lines {
            space: self.space,
            lattice: &orientation.lattice,
            is_along,
            radius_m: self.ground.radius_m(),
            step_m: instance.floor.tool_width_m() / STEPS_ASIDE,
            worth,
        })
    }

    fn share(&self, stops: &[Stop], plan: &mut Plan) {
        let mut transfers = Transfers::new(self.space);
        let shared = sharing::share(&mut transfers, self.robots, stops, self.options, plan);
        // Where sharing finds no way between two lanes, the tour still has one.
        if shared.is_err() {
            splitting::divide(&mut transfers, self.space.instance(), self.robots, stops, plan);
        }
    }
}

fn points(stops: &[Stop], home: Option<Way>) -> Vec<Point> {
    let of_stop = |stop: &Stop| [stop.way.points.clone(), stop.lane.points.clone()].concat();
    let mut points: Vec<Point> = stops.iter().flat_map(of_stop).collect();
    points.extend(home.into_iter().flat_map(|way| way.points));
    points.dedup_by(|a, b| (*a - *b).norm() < 1e-7);
    points
}

/// What a tour sweeps, and nothing else.
fn sweep_tour(ground: &mut Ground, tour: &mut LaneTour<'_, '_>) {
    ground.clear();
    let (stops, home) = tour.stops();
    for stop in &stops {
        ground.sweep(&stop.way.points);
        ground.sweep(&stop.lane.points);
    }
    if let Some(home) = home {
        ground.sweep(&home.points);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Start;
    use crate::test_motion::MOTION;
    use terrain::{Cell, Floor, Lattice};

    /// Four robots on six cells: some sweep what is asked for where they stand, and one cell is blocked.
    #[test]
    fn more_robots_than_work_still_sweep_all() {
        let lattice = Lattice { origin: Point::origin(), cell_m: 0.5, columns: 3, rows: 2 };
        let floor = Floor::from_cells(lattice, &[true; 6], 0.177, 0.75);
        let options = PlanOptions { planner: "boustrophedon-lanes".to_owned(), ..PlanOptions::default() };
        for wanted in 1..64_u32 {
            for blocked in [None, Some(4)] {
                let starts = [(0, 0), (2, 0), (0, 1), (2, 1)].map(|(x, y)| Start::at(Cell::new(x, y)));
                let mut instance = Instance::whole_floor(&floor, starts.to_vec(), MOTION, Mode::Cover);
                if let Some(cell) = blocked {
                    instance.blocked[cell] = true;
                }
                instance.visit =
                    (0..6).map(|cell| wanted >> cell & 1 == 1 && Some(cell) != blocked).collect();
                if instance.visit.contains(&true) {
                    let planned = crate::plan(&instance, &options);
                    assert!(planned.is_ok(), "{wanted:06b} {blocked:?}: {planned:?}");
                }
            }
        }
    }
}
