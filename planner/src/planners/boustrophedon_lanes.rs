//! Lanes: straight lanes of the tool's width, as few as possible, and one tour over them.
//!
//! **Problem.** Cover free ground of any shape with a round tool in as little time as possible, turns included; the body must
//! not touch anything on the way.
//! **Idea.** Lay a lattice of tool-wide squares over the ground and choose for each square whether it is driven along or
//! across so that the lanes are as few as can be (a minimum cut). Put each lane where the body fits and sweeps most of what
//! its squares need, no longer than that. Join the lanes to a tour, each driven either way, with shortest ways for the
//! body priced by the time of their turns, and improve it by local search. Look at what the whole way leaves unswept, add short
//! lanes for it where most is gained, until the coverage asked for is reached, and improve the tour again.
//! **Guarantee.** The lanes are a minimum for the lattice (the code asserts that the cut is the number of runs). The coverage
//! asked for is aimed at, not guaranteed: verify refuses plans that miss it, and on small ragged floors with more robots than
//! work some do. No way touches a wall. None on the length of the tour.
//! **Complexity.** O(E √V) for the cut of V squares, O(n) bounded searches for the ways between the ends of n lanes.
//! **Paper.** H. Choset: Coverage of known spaces: the boustrophedon cellular decomposition. Autonomous Robots 9, 2000, is where the
//! motion comes from; lanes instead of cells and the cut are ours.
//! **Departures.** No cells: the tour may interleave them.

mod cells;
mod placing;
mod residue;
mod sharing;
mod splitting;

use crate::{
    Instance, Mode, Plan, PlanError, PlanOptions, Route, VerifyError,
    configuration_space::ConfigurationSpace,
    ground::Ground,
    lane_tour::{Lane, LaneTour},
    minimum_lanes::{Orientation, ToolLattice},
    transfers::{Transfers, Way},
    verify,
};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use terrain::Point;

/// Shares of a square by which the lattice is moved, along and across.
const SHIFTS: [f64; 3] = [0.0, 1.0 / 3.0, 2.0 / 3.0];
/// More is swept than asked for by this share, so that rims do not decide.
const COVERAGE_MARGIN: f64 = 0.0005;
/// Steps of the local search for each lane.
const STEPS: u64 = 15;
/// How often what is left is looked for.
const ROUNDS: usize = 4;

/// Plans.
#[allow(clippy::unnecessary_wraps, reason = "the table of planners wants it")]
pub(super) fn plan(instance: &Instance<'_>, options: &PlanOptions) -> Result<Plan, PlanError> {
    let space = ConfigurationSpace::new(instance);
    let mut search = Search {
        instance,
        space: &space,
        transfers: Transfers::new(&space),
        ground: Ground::new(&space),
        random: ChaCha8Rng::seed_from_u64(options.seed),
        effort: options.effort,
    };
    let orientation = best_orientation(&space, &search.ground, options.effort);
    let lanes = placing::lanes(&space, &mut search.ground, &orientation);
    let mut tours = search.first_tours(lanes);
    let goal = instance.coverage_min + COVERAGE_MARGIN;
    for _ in 0..ROUNDS {
        sweep_all(&mut search.ground, &tours);
        if search.ground.coverage() >= goal.min(1.0) {
            break;
        }
        let added = residue::lanes(&space, &mut search.ground, &orientation.lattice, goal);
        if added.is_empty() {
            break;
        }
        search.add(&mut tours, added);
    }
    let plan = search.divided(&tours, &orientation.lattice, options)?;
    // Charges come later, or are there already: here it is what is swept that counts.
    let without_battery = Instance { battery: None, ..instance.clone() };
    match verify(&without_battery, &plan) {
        Err(VerifyError::NotSwept { .. }) => {
            let lanes: Vec<Lane> = tours.iter().flat_map(|tour| &tour.stops).map(|stop| stop.lane).collect();
            search.add(&mut tours, cells::left_out(&space, &lanes));
            search.divided(&tours, &orientation.lattice, options)
        }
        _ => Ok(plan),
    }
}

/// What all steps need.
struct Search<'s, 'a> {
    instance: &'a Instance<'a>,
    space: &'s ConfigurationSpace<'a>,
    transfers: Transfers<'s, 'a>,
    ground: Ground,
    random: ChaCha8Rng,
    effort: u32,
}

/// The lanes of a connected piece of ground, in the order of driving, and the robots on it.
struct Tour {
    robots: Vec<usize>,
    stops: Vec<Stop>,
}

impl Search<'_, '_> {
    fn first_tours(&mut self, lanes: Vec<Lane>) -> Vec<Tour> {
        let pieces = splitting::pieces(self.space, lanes);
        let tours = pieces.into_iter().map(|(robots, lanes)| {
            let stops = self.tour(robots[0], &lanes, false);
            Tour { robots, stops }
        });
        tours.collect()
    }

    /// Adds lanes to the tours, and improves these.
    fn add(&mut self, tours: &mut [Tour], added: Vec<Lane>) {
        let pieces = splitting::pieces(self.space, added);
        for tour in tours {
            let own = pieces.iter().find(|(robots, _)| *robots == tour.robots);
            if let Some((_, added)) = own.filter(|(_, added)| !added.is_empty()) {
                let mut lanes: Vec<Lane> = tour.stops.iter().map(|stop| stop.lane).collect();
                lanes.extend(added);
                tour.stops = self.tour(tour.robots[0], &lanes, true);
            }
        }
    }

    fn tour(&mut self, robot: usize, lanes: &[Lane], in_order: bool) -> Vec<Stop> {
        let start: Point = self.instance.place(&self.instance.starts[robot]);
        let returns = self.instance.mode == Mode::CoverAndReturn;
        let mut tour = LaneTour::new(&mut self.transfers, start, lanes, in_order, returns);
        tour.improve(u64::from(self.effort) * STEPS * lanes.len() as u64, &mut self.random);
        let entries = tour.entries();
        let mut stops = Vec::with_capacity(entries.len());
        for pair in entries.windows(2) {
            let (from, entered) = (pair[0] ^ 1, pair[1]);
            let Some(way) = tour.way(from, entered) else { continue };
            let Lane { from, to } = lanes[entered / 2 - 1];
            let is_first_end = entered.is_multiple_of(2);
            let lane = if is_first_end { Lane { from, to } } else { Lane { from: to, to: from } };
            stops.push(Stop { lane, way });
        }
        stops
    }

    /// Routes for all robots; several on one piece of ground share its tour.
    #[allow(clippy::unnecessary_wraps, reason = "as the planner's own answer")]
    fn divided(
        &mut self,
        tours: &[Tour],
        lattice: &ToolLattice,
        options: &PlanOptions,
    ) -> Result<Plan, PlanError> {
        let mut plan = Plan { routes: vec![Route::default(); self.instance.starts.len()] };
        sweep_all(&mut self.ground, tours);
        for tour in tours {
            let mut sweeping = sharing::Sweeping { space: self.space, ground: &mut self.ground, lattice };
            let is_shared = tour.robots.len() > 1
                && sharing::share(
                    &mut sweeping,
                    &mut self.transfers,
                    &tour.robots,
                    &tour.stops,
                    options,
                    &mut plan,
                )
                .is_ok();
            // Where sharing finds no way between two lanes, the tour still has one.
            if !is_shared {
                splitting::divide(&mut self.transfers, self.instance, &tour.robots, &tour.stops, &mut plan);
            }
        }
        Ok(plan)
    }
}

/// A lane in the order of driving, and the way to it from the one before (or from where the tour begins).
#[derive(Debug, Clone)]
struct Stop {
    lane: Lane,
    way: Way,
}

fn sweep_all(ground: &mut Ground, tours: &[Tour]) {
    ground.clear();
    for stop in tours.iter().flat_map(|tour| &tour.stops) {
        ground.sweep(&stop.way.points);
        ground.sweep(&[stop.lane.from, stop.lane.to]);
    }
}

/// The lattice with the fewest lanes, of several that are moved a little.
fn best_orientation(space: &ConfigurationSpace<'_>, ground: &Ground, effort: u32) -> Orientation {
    let shifts: &[f64] = if effort == 0 { &SHIFTS[..1] } else { &SHIFTS };
    let all = shifts.iter().flat_map(|&x| shifts.iter().map(move |&y| [x, y]));
    all.map(|shift| Orientation::minimum(ToolLattice::new(space, ground, 0.0, shift)))
        .min_by_key(|orientation| orientation.lanes)
        .expect("there is a shift")
}
