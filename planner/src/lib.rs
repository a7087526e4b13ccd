//! Pure coverage planning: an [`Instance`] in, a [`VerifiedPlan`] out.
//!
//! An instance is *any* state of a mission: cells still to be visited (ragged, in several pieces, with transit
//! through covered ground), robots anywhere, ground that is blocked for now. [`plan`] is the only way in: it
//! runs one planner of the table [`PLANNERS`] and then [`verify()`], which knows nothing of how a plan is made.
//! No clock, no files, no network, no global randomness: same instance and seed, same plan.

mod arc_routing;
mod battery;
mod block_trees;
mod bricks;
mod circumnavigation;
mod configuration_space;
mod disjoint_sets;
mod division;
mod edge_weights;
mod ground;
mod instance;
pub mod isograph;
mod lane_tour;
mod lower_bound;
mod matching;
mod maximum_flow;
pub mod mcfs;
mod minimum_lanes;
mod perfect_matching;
mod plan;
pub mod planners;
mod recharging;
mod repair;
mod repair_lines;
mod shortest_way;
mod spanning_graph;
mod spanning_trees;
#[cfg(test)]
mod test_motion;
mod transfers;
mod verify;

pub use battery::{Battery, BreakOff, Station};
pub use edge_weights::EdgeWeights;
pub use instance::{Instance, InstanceError, Mode, Start};
pub use lower_bound::{area_bound_s, lower_bound_s};
pub use plan::{Plan, Route, VerifiedPlan};
pub use planners::{PLANNERS, Planner};
pub use recharging::{Endurance, FirstBreakOff, first_break_offs};
pub use spanning_trees::{TREES, Tree, tree_turns};
pub use verify::{Figures, VerifyError, verify};

use terrain::{Cell, Point};
use thiserror::Error;

/// How to plan.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanOptions {
    /// Name of a row of [`PLANNERS`].
    pub planner: String,
    /// Bound on the work, as a number of improvement steps (0: first answer). Never a clock: same seed, same plan.
    pub effort: u32,
    /// Seed for planners that draw.
    pub seed: u64,
    /// Where lines are under way ([`Instance::incumbent_lines`]), answers with their repair when that holds, without
    /// planning afresh: an order at once rather than a better one later.
    pub warm: bool,
    /// What `mcfs` alone can be told.
    pub mcfs: mcfs::McfsOptions,
}

impl Default for PlanOptions {
    fn default() -> Self {
        Self {
            planner: "tmstc-star".to_owned(),
            effort: 1,
            seed: 0,
            warm: false,
            mcfs: mcfs::McfsOptions::default(),
        }
    }
}

/// Why there is no plan.
#[derive(Debug, Clone, Error, PartialEq)]
pub enum PlanError {
    /// No row of that name.
    #[error("no planner is called `{0}`; there are: {names}", names = planners::names())]
    UnknownPlanner(String),
    /// The instance itself is not sound.
    #[error(transparent)]
    Instance(#[from] InstanceError),
    /// No robot can get to this cell.
    #[error("cell {0} cannot be reached by any robot")]
    Unreachable(Cell),
    /// A place that the battery does not last for.
    #[error(
        "the battery does not last to cell {cell} at {place} and on to a station: it lasts {capacity_s:.0} s, \
         {needed_s:.0} s are needed; give a larger capacity or a nearer station"
    )]
    OutOfRange {
        /// The cell.
        cell: Cell,
        /// The place in it.
        place: Point,
        /// What a full battery gives.
        capacity_s: f64,
        /// What the trip takes, with the reserve.
        needed_s: f64,
    },
    /// The planner made a plan that does not stand the test: our bug.
    #[error("the plan of `{planner}` does not hold: {source}")]
    Refuted {
        /// Name of the planner.
        planner: &'static str,
        /// What verify found.
        source: VerifyError,
    },
    /// This planner cannot do what the instance asks, though another may.
    #[error("`{planner}` cannot plan this: {reason}")]
    Unsupported {
        /// Name of the planner.
        planner: &'static str,
        /// What it cannot do.
        reason: String,
    },
}

/// A plan afresh replaces lines that are under way when it is better by this share: each change costs the fleet a stop.
const PUBLISHED_BETTER_BY: f64 = 0.02;

/// Plans with the planner named in `options`, and verifies what it made. Where routes are under way, the answer is
/// compared with a repair of them, and the one with the smaller makespan is given.
///
/// # Errors
///
/// [`PlanError`]; an instance in which a cell to visit cannot be reached is refused with that cell.
pub fn plan(instance: &Instance<'_>, options: &PlanOptions) -> Result<VerifiedPlan, PlanError> {
    let planner = planners::by_name(&options.planner)
        .ok_or_else(|| PlanError::UnknownPlanner(options.planner.clone()))?;
    instance.check()?;
    let instance = &instance.with_open_starts();
    let reachable = instance.reachable();
    let lost = (0..reachable.len()).find(|&index| instance.visit[index] && !reachable[index]);
    if let Some(index) = lost {
        return Err(PlanError::Unreachable(instance.floor.lattice().cell(index)));
    }
    // What a repair leaves unswept is told by its verification: then another plan is needed.
    let lines = repair_lines::repair(instance).and_then(|plan| checked(instance, plan, "repair").ok());
    if options.warm
        && let Some(lines) = lines
    {
        return Ok(lines);
    }
    let fresh = (planner.plan)(instance, options).and_then(|plan| completed(instance, plan, planner));
    if let Some(lines) = lines {
        let better = |fresh: &VerifiedPlan| {
            fresh.figures().makespan_s < (1.0 - PUBLISHED_BETTER_BY) * lines.figures().makespan_s
        };
        return Ok(fresh.ok().filter(better).unwrap_or(lines));
    }
    let fresh = fresh?;
    let Some(repaired) = repair::repair(instance)? else { return Ok(fresh) };
    let repaired = checked(instance, repaired, "repair")?;
    let better = repaired.figures().makespan_s <= fresh.figures().makespan_s;
    Ok(if better { repaired } else { fresh })
}

/// Takes in a plan of the caller's own making: it can be driven when it stands the test.
///
/// # Errors
///
/// [`VerifyError`]: the first thing found wrong.
pub fn accept(
    instance: &Instance<'_>,
    plan: Plan,
    planner: &'static str,
) -> Result<VerifiedPlan, VerifyError> {
    let figures = verify(instance, &plan)?;
    Ok(VerifiedPlan::new(plan, figures, planner))
}

/// Puts charges into a plan that was made without them, break-off by break-off along the very same tours, and verifies
/// what comes of it. Nothing happens to it where the instance has no battery.
///
/// # Errors
///
/// [`PlanError::OutOfRange`], naming the place that the battery does not last for; [`PlanError::Refuted`].
pub fn recharge(instance: &Instance<'_>, plan: &VerifiedPlan) -> Result<VerifiedPlan, PlanError> {
    instance.check()?;
    checked(&instance.with_open_starts(), Plan { routes: plan.routes().to_vec() }, plan.planner())
}

/// Checked; what a planner that leaves the lattice has left unswept by the measure of verify gets side trips.
fn completed(instance: &Instance<'_>, plan: Plan, planner: &Planner) -> Result<VerifiedPlan, PlanError> {
    if !planner.leaves_lattice() {
        return checked(instance, plan, planner.name);
    }
    match checked(instance, plan.clone(), planner.name) {
        Err(PlanError::Refuted { source: VerifyError::NotSwept { .. } | VerifyError::Gap(_), .. }) => {
            checked(instance, planners::completed(instance, plan), planner.name)
        }
        judged => judged,
    }
}

fn checked(
    instance: &Instance<'_>,
    mut plan: Plan,
    planner: &'static str,
) -> Result<VerifiedPlan, PlanError> {
    begin_where_robots_stand(instance, &mut plan);
    let plan = recharging::with_charges(instance, plan)?;
    let figures = verify(instance, &plan).map_err(|source| PlanError::Refuted { planner, source })?;
    Ok(VerifiedPlan::new(plan, figures, planner))
}

/// Planners on the lattice begin at cell centres; a robot that stands beside one drives there first, and back in the
/// end.
fn begin_where_robots_stand(instance: &Instance<'_>, plan: &mut Plan) {
    for (route, start) in plan.routes.iter_mut().zip(&instance.starts) {
        let place = instance.place(start);
        let apart = |point: Option<&Point>| point.is_some_and(|point| (point - place).norm() > 1e-6);
        if apart(route.points.first()) {
            route.points.insert(0, place);
        }
        if instance.mode == Mode::CoverAndReturn && apart(route.points.last()) {
            route.points.push(place);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_motion::MOTION;
    use proptest::prelude::*;
    use terrain::{Direction, Floor, Lattice, MotionModel, Point};

    fn floor(columns: u32, rows: u32, free: &[bool]) -> Floor {
        let lattice = Lattice { origin: Point::origin(), cell_m: 0.5, columns, rows };
        Floor::from_cells(lattice, free, 0.177, 0.75)
    }

    prop_compose! {
        /// A ragged floor, some of it to be visited, some blocked, and robots on it.
        fn mission()(columns in 2_u32..14, rows in 2_u32..14, robots in 1_usize..6)(
            free in prop::collection::vec(prop::bool::weighted(0.8), (columns * rows) as usize),
            wanted in prop::collection::vec(prop::bool::weighted(0.7), (columns * rows) as usize),
            blocked in prop::collection::vec(prop::bool::weighted(0.1), (columns * rows) as usize),
            starts in prop::collection::vec(0..(columns * rows) as usize, robots),
            comes_back in any::<bool>(),
            repairs in any::<bool>(),
            weighted in any::<bool>(),
            delayed in any::<bool>(),
            walls in prop::collection::vec(prop::bool::weighted(0.04), (columns * rows) as usize),
            columns in Just(columns),
            rows in Just(rows),
        ) -> (Floor, Vec<bool>, Vec<bool>, Vec<usize>, [bool; 4]) {
            let mut floor = floor(columns, rows, &free);
            let lattice = *floor.lattice();
            for cell in lattice.cells().zip(&walls).filter(|&(_, &wall)| wall).map(|(cell, _)| cell) {
                floor.close_move(cell, Direction::East);
                floor.close_move(cell.step(Direction::West), Direction::North);
            }
            (floor, wanted, blocked, starts, [comes_back, repairs, weighted, delayed])
        }
    }

    /// `RANDOM_INSTANCES=10000 cargo test -p planner leaves_no_gap` for a long run.
    fn random_instances() -> ProptestConfig {
        let asked = std::env::var("RANDOM_INSTANCES").ok().and_then(|count| count.parse().ok());
        // Shrinking plans with all planners again and again: a small instance soon is better than the smallest late.
        ProptestConfig { cases: asked.unwrap_or(60), max_shrink_iters: 500, ..ProptestConfig::default() }
    }

    #[test]
    fn charges_put_in_later_are_those_of_planning_with_a_battery() {
        let floor = floor(12, 8, &[true; 96]);
        let mut instance =
            Instance::whole_floor(&floor, vec![Start::at(Cell::new(0, 0))], MOTION, Mode::CoverAndReturn);
        let without = plan(&instance, &PlanOptions::default()).unwrap();
        assert_eq!(recharge(&instance, &without).unwrap(), without);
        instance.stations = vec![Station::at(Cell::new(0, 0))];
        instance.battery = Some(Battery::lasting_s(90.0));
        let with = recharge(&instance, &without).unwrap();
        assert!(with.figures().charges[0] > 0, "{:?}", with.figures());
        assert_first_break_off(&instance, &without.routes()[0].points, &with);
        assert_eq!(with, plan(&instance, &PlanOptions::default()).unwrap());
    }

    /// Told alone, the first break is where the plan with charges leaves the line for the station.
    fn assert_first_break_off(instance: &Instance<'_>, line: &[Point], with: &VerifiedPlan) {
        let length_m =
            |points: &[Point]| points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum::<f64>();
        let battery = instance.battery.expect("it was just given");
        let routes = [Endurance { robot: 0, battery, points: line.to_vec() }];
        let first = first_break_offs(instance, &routes)[0].expect("the battery does not last for all of it");
        let at = (0..line.len()).find(|&at| (length_m(&line[at..]) - first.ahead_m).abs() < 1e-9).unwrap();
        let stretch = with.routes()[0].stretches().next().unwrap();
        assert_eq!(stretch[..=at], line[..=at]);
        let home = instance.center(instance.stations[first.station].cell) - line[at];
        assert!((length_m(&stretch[at..]) - home.x.abs() - home.y.abs()).abs() < 1e-9);
    }

    proptest! {
        #![proptest_config(random_instances())]
        #[test]
        fn every_planner_leaves_no_gap(
            (floor, wanted, blocked, starts, [comes_back, repairs, weighted, delayed]) in mission()
        ) {
            let drivable: Vec<usize> = (0..floor.lattice().len()).filter(|&i| floor.is_drivable(i)).collect();
            prop_assume!(!drivable.is_empty());
            let starts: Vec<Start> = starts
                .iter()
                .take(drivable.len())
                .map(|start| Start::at(floor.lattice().cell(drivable[start % drivable.len()])))
                .collect();
            let mode = if comes_back { Mode::CoverAndReturn } else { Mode::Cover };
            let mut instance = Instance::whole_floor(&floor, starts, MOTION, mode);
            instance.blocked = blocked;
            let open = instance.with_open_starts().reachable();
            instance.visit = (0..open.len()).map(|i| open[i] && wanted[i]).collect();
            prop_assume!(instance.visit.contains(&true));
            if repairs {
                let order: Vec<Cell> = floor.lattice().cells().collect();
                let share = order.len() / instance.starts.len() + 1;
                let mut parts: Vec<Vec<Cell>> = order.chunks(share).map(<[Cell]>::to_vec).collect();
                parts.resize(instance.starts.len(), Vec::new());
                instance.orphans = vec![std::mem::take(&mut parts[0])];
                instance.incumbent = parts;
            }
            if weighted {
                let factor = |index: usize| 0.5 + (index * 7 % 11) as f64 / 4.0;
                let right: Vec<f64> = (0..open.len()).map(factor).collect();
                instance.weights = Some(EdgeWeights { up: right.iter().rev().copied().collect(), right });
            }
            if delayed {
                for (robot, start) in instance.starts.iter_mut().enumerate() {
                    start.available_in_s = [30.0, 0.0, 7.0][robot % 3];
                }
            }
            let bound_s = lower_bound_s(&instance);
            let mut makespans_s = std::collections::BTreeMap::new();
            for planner in PLANNERS {
                let options = PlanOptions { planner: planner.name.to_owned(), ..PlanOptions::default() };
                let planned = plan(&instance, &options);
                if ["darp", "mcfs"].contains(&planner.name) && matches!(planned, Err(PlanError::Unsupported { .. })) {
                    continue;
                }
                prop_assert!(planned.is_ok(), "{}: {:?}", planner.name, planned);
                let makespan_s = planned.as_ref().map_or(0.0, |plan| plan.figures().makespan_s);
                makespans_s.insert(planner.name, makespan_s);
                let is_bounded = planner.leaves_lattice() || makespan_s >= bound_s - 1e-6;
                prop_assert!(is_bounded, "{}: {makespan_s} < {bound_s}", planner.name);
                prop_assert_eq!(&planned, &plan(&instance, &options), "{} is deterministic", planner.name);
            }
            // With turns, weights, delays and ground that need not be visited.
            prop_assert!(makespans_s["mfc"] <= makespans_s["stc"] + 1e-6, "{makespans_s:?}");
        }

        /// Theorems 2 and 3 of the MFC paper, in moves alone and for robots that all cover: not worse than one
        /// robot, and at most eight times the best (here: the bound) plus a constant.
        #[test]
        fn mfc_keeps_its_guarantees(
            (floor, _, _, starts, [comes_back, ..]) in mission()
        ) {
            let drivable: Vec<usize> = (0..floor.lattice().len()).filter(|&i| floor.is_drivable(i)).collect();
            prop_assume!(!drivable.is_empty());
            let places = starts.iter().take(drivable.len()).map(|start| drivable[start % drivable.len()]);
            let starts = places.map(|index| Start::at(floor.lattice().cell(index))).collect();
            let moves_only = MotionModel {
                speed_m_per_s: 0.5,
                acceleration_m_per_s2: f64::INFINITY,
                angular_speed_rad_per_s: f64::INFINITY,
                ..MOTION
            };
            let mode = if comes_back { Mode::CoverAndReturn } else { Mode::Cover };
            let instance = Instance::whole_floor(&floor, starts, moves_only, mode);
            let by = |name: &str| {
                let options = PlanOptions { planner: name.to_owned(), ..PlanOptions::default() };
                plan(&instance, &options).unwrap().figures().makespan_s
            };
            let (mfc_moves, stc_moves) = (by("mfc"), by("stc"));
            prop_assert!(mfc_moves <= stc_moves + 1e-6, "mfc {mfc_moves}, stc {stc_moves}");
            let bound = lower_bound_s(&instance);
            prop_assert!(mfc_moves <= 8.0 * bound + 16.0, "mfc {mfc_moves}, bound {bound}");
        }

        /// `verify` never finds a stretch that outlasts the battery, and the optimal breaks are never worse than the
        /// latest ones.
        #[test]
        fn no_stretch_outlasts_the_battery(
            (floor, _, blocked, starts, [comes_back, ..]) in mission(),
            capacity_s in 20.0_f64..200.0,
            charge_s in prop::option::of(1.0_f64..40.0),
            left in prop::option::of(0.2_f64..1.0),
            queues in any::<bool>(),
            stations in 1_usize..4,
        ) {
            let drivable: Vec<usize> = (0..floor.lattice().len()).filter(|&i| floor.is_drivable(i)).collect();
            prop_assume!(!drivable.is_empty());
            let places = starts.iter().map(|start| floor.lattice().cell(drivable[start % drivable.len()]));
            let places: Vec<Cell> = places.take(drivable.len()).collect();
            let motion = MotionModel { acceleration_m_per_s2: f64::INFINITY, ..MOTION };
            let mode = if comes_back { Mode::CoverAndReturn } else { Mode::Cover };
            let starts = places.iter().map(|&cell| Start::at(cell)).collect();
            let mut instance = Instance::whole_floor(&floor, starts, motion, mode);
            instance.blocked = blocked;
            let instance = instance.with_open_starts();
            let mut instance = Instance { visit: instance.reachable(), ..instance };
            instance.starts.iter_mut().for_each(|start| start.charge_s = left.map(|left| left * capacity_s));
            let queue_s = if queues { 7.0 } else { 0.0 };
            let station = |&cell: &Cell| Station { queue_s, ..Station::at(cell) };
            instance.stations = places.iter().take(stations).map(station).collect();
            let mut costs_s: Vec<Vec<f64>> = Vec::new();
            for break_off in [BreakOff::Optimal, BreakOff::Latest] {
                let charge_s = charge_s.unwrap_or(0.0);
                instance.battery = Some(Battery { charge_s, reserve_s: 3.0, break_off, capacity_s });
                let options = PlanOptions { effort: 0, ..PlanOptions::default() };
                match plan(&instance, &options) {
                    Ok(plan) => {
                        let figures = plan.figures();
                        let own_s = figures.cost_s.iter().zip(&figures.waiting_s);
                        let queued_s = |robot: usize| queue_s * figures.charges[robot] as f64;
                        costs_s.push(own_s.enumerate().map(|(robot, (cost, wait))| cost - wait + queued_s(robot)).collect());
                    }
                    Err(PlanError::OutOfRange { needed_s, .. }) => {
                        prop_assert!(needed_s > capacity_s - 1e-6, "{needed_s} {capacity_s}");
                    }
                    Err(other) => prop_assert!(false, "{other}"),
                }
            }
            if let [optimal, latest] = &costs_s[..] {
                for (optimal_s, latest_s) in optimal.iter().zip(latest) {
                    prop_assert!(optimal_s <= &(latest_s + 1e-6), "{optimal_s} > {latest_s}");
                }
            }
        }
    }
}
