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
//! asked for is reached wherever the body gets; no way touches a wall. None on the length of the tour.
//! **Complexity.** O(E √V) for the cut of V squares, O(n) bounded searches for the ways between the ends of n lanes.
//! **Paper.** H. Choset: Coverage of known spaces: the boustrophedon cellular decomposition. Autonomous Robots 9, 2000, is where the
//! motion comes from; lanes instead of cells and the cut are ours.
//! **Departures.** No cells: the tour may interleave them.

mod placing;
mod residue;
mod splitting;

use crate::{
    Instance, Mode, Plan, PlanError, PlanOptions, Route,
    configuration_space::ConfigurationSpace,
    ground::Ground,
    lane_tour::{Lane, LaneTour},
    minimum_lanes::{Orientation, ToolLattice},
    transfers::{Transfers, Way},
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
const ROUNDS: usize = 8;

/// Plans.
pub(super) fn plan(instance: &Instance<'_>, options: &PlanOptions) -> Result<Plan, PlanError> {
    let space = ConfigurationSpace::new(instance);
    let mut transfers = Transfers::new(&space);
    let mut ground = Ground::new(&space);
    let mut random = ChaCha8Rng::seed_from_u64(options.seed);
    let orientation = best_orientation(&space, &ground, options.effort);
    let lanes = placing::lanes(&space, &mut ground, &orientation);
    let pieces = splitting::pieces(&space, lanes);
    let mut plan = Plan { routes: vec![Route::default(); instance.starts.len()] };
    let mut tours: Vec<(Vec<usize>, Vec<Stop>)> = pieces
        .into_iter()
        .map(|(robots, lanes)| {
            let stops = tour(&mut transfers, instance, robots[0], &lanes, options.effort, &mut random);
            (robots, stops)
        })
        .collect();
    for _ in 0..ROUNDS {
        sweep_all(&mut ground, &tours);
        if ground.coverage() >= (instance.coverage_min + COVERAGE_MARGIN).min(1.0) {
            break;
        }
        let goal = instance.coverage_min + COVERAGE_MARGIN;
        let added = residue::lanes(&space, &mut ground, &orientation.lattice, goal);
        if added.is_empty() {
            break;
        }
        let with_added = splitting::pieces(&space, added);
        for (robots, stops) in &mut tours {
            let Some((_, added)) = with_added.iter().find(|(owners, _)| owners == robots) else { continue };
            let mut lanes: Vec<Lane> = stops.iter().map(|stop| stop.lane).collect();
            lanes.extend(added);
            *stops = tour(&mut transfers, instance, robots[0], &lanes, options.effort, &mut random);
        }
    }
    for (robots, stops) in &tours {
        splitting::divide(&mut transfers, instance, robots, stops, &mut plan);
    }
    Ok(plan)
}

/// A lane in the order of driving, and the way to it from the one before (or from where the tour begins).
#[derive(Debug, Clone)]
struct Stop {
    lane: Lane,
    way: Way,
}

fn sweep_all(ground: &mut Ground, tours: &[(Vec<usize>, Vec<Stop>)]) {
    ground.clear();
    for stop in tours.iter().flat_map(|(_, stops)| stops) {
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

fn tour(
    transfers: &mut Transfers<'_, '_>,
    instance: &Instance<'_>,
    robot: usize,
    lanes: &[Lane],
    effort: u32,
    random: &mut ChaCha8Rng,
) -> Vec<Stop> {
    let start: Point = instance.place(&instance.starts[robot]);
    let returns = instance.mode == Mode::CoverAndReturn;
    let mut tour = LaneTour::new(transfers, start, lanes, returns);
    tour.improve(u64::from(effort) * STEPS * lanes.len() as u64, random);
    let entries = tour.entries();
    let mut stops = Vec::with_capacity(entries.len());
    for pair in entries.windows(2) {
        let (from, entered) = (pair[0] ^ 1, pair[1]);
        let Some(way) = tour.way(from, entered) else { continue };
        let lane = lanes[entered / 2 - 1];
        let lane = if entered.is_multiple_of(2) { lane } else { Lane { from: lane.to, to: lane.from } };
        stops.push(Stop { lane, way });
    }
    stops
}
