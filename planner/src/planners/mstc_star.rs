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
    Instance, Plan, PlanError, PlanOptions,
    circumnavigation::{Forest, loops},
    disjoint_sets::DisjointSets,
    division::divide,
    spanning_graph::{Node, SpanningGraph},
};
use terrain::{Direction, MotionModel};

/// Plans.
pub(super) fn plan(instance: &Instance<'_>, _options: &PlanOptions) -> Result<Plan, PlanError> {
    let graph = SpanningGraph::new(instance);
    let forest = kruskal_forest(&graph);
    divide(&blind_to_turns(instance), loops(&graph, &forest))
}

/// Kruskal's forest; edges in the order of their first node, east before north.
pub(super) fn kruskal_forest(graph: &SpanningGraph) -> Forest {
    let mut forest = Forest::new(graph);
    let mut sets = DisjointSets::new(graph.len());
    for node in 0..graph.len() as Node {
        for direction in [Direction::East, Direction::North] {
            let Some(other) = graph.neighbour(node, direction) else { continue };
            if sets.find(node) != sets.find(other) {
                forest.join(node, direction, other);
                sets.unite(node, other);
            }
        }
    }
    forest
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
