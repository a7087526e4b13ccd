//! MSTC*: the baseline that does not know what a turn costs.
//!
//! **Problem.** As `stc`, for several robots, with the largest cost as small as possible.
//! **Idea.** Grow a minimum spanning tree over the mega cells by Kruskal's method; all edges weigh the same, so they
//! are taken in the order of the lattice. Drive around the tree. Divide the walk among the robots by length, ways to
//! and fro included (`division.rs` with turns and ramps that take no time).
//! **Guarantee.** As `stc`.
//! **Complexity.** O(n log n) for the tree, O(k n) for the division.
//! **Paper.** J. Tang, C. Sun, X. Zhang: MSTC*: multi-robot coverage path planning under physical constraints. IEEE
//! International Conference on Robotics and Automation (ICRA), 2021.
//! **Departures.** Partly visited mega cells and several pieces are allowed. The paper's capacity of a robot (battery
//! or load) is left out. The division is the one of `tmstc-star`, on length, so the two differ in tree and in
//! knowledge of turns only; it is no copy of the authors' cutter.

use crate::{
    Instance, Plan, PlanError, PlanOptions, circumnavigation::loops, division::divide,
    spanning_graph::SpanningGraph, spanning_trees::kruskal,
};
use terrain::MotionModel;

/// Plans.
pub(super) fn plan(instance: &Instance<'_>, _options: &PlanOptions) -> Result<Plan, PlanError> {
    let graph = SpanningGraph::new(instance);
    let forest = kruskal(&graph);
    divide(&blind_to_turns(instance), loops(&graph, &forest))
}

/// The same instance for robots that turn, speed up and brake in no time: cost is length.
fn blind_to_turns<'a>(instance: &Instance<'a>) -> Instance<'a> {
    let mut blind = instance.clone();
    blind.motion = MotionModel {
        acceleration_m_per_s2: f64::INFINITY,
        angular_speed_rad_per_s: f64::INFINITY,
        angular_acceleration_rad_per_s2: f64::INFINITY,
        ..instance.motion
    };
    blind
}
