//! TMSTC*: turn-minimising multi-robot spanning tree coverage.
//!
//! **Problem.** As `stc`, but robots stop to turn: fewer turns are less time.
//! **Idea.** Tile the spanning graph with the fewest straight bricks (`bricks.rs`); they are the branches of the
//! tree. Join them greedily by the edge that adds the fewest turns, with a heap whose costs are checked when they
//! come up. Drive around the tree; divide the walk among the robots by time, turns included (`division.rs`).
//! **Guarantee.** The tiling is minimum (a matching of the same size proves it); joining is greedy.
//! **Complexity.** O(n √n) for the matching, O(n log n) for the rest, O(k n) for the division.
//! **Paper.** J. Lu, B. Zeng, J. Tang, T. L. Lam, J. Wen: TMSTC*: a path planning algorithm for minimizing turns in
//! multi-robot coverage. IEEE Robotics and Automation Letters 8(8), 2023.
//! **Departures.** Mega cells may be visited in part. The change of turns at a node without edges is −2, as
//! equation 6 has it (the authors' program takes 0). Of the minimum tilings two are tried, to the end. The division is a bisection on the largest time with true
//! costs and any robot at any place of the walk, instead of sliding cuts between neighbours (equation 8 is the
//! `MotionModel`). In words for the paper's letters: the coverage graph G is the lattice, the spanning graph H is
//! `SpanningGraph`, the segment graph I is the graph of conflicts between joins.

use crate::{
    Instance, Plan, PlanError, PlanOptions,
    circumnavigation::loops,
    division::{divide, makespan_s},
    spanning_graph::SpanningGraph,
    spanning_trees::turn_minimising_pair,
};

/// Plans.
pub(super) fn plan(instance: &Instance<'_>, _options: &PlanOptions) -> Result<Plan, PlanError> {
    let graph = SpanningGraph::new(instance);
    let [a, b] = turn_minimising_pair(&graph).map(|forest| divide(instance, loops(&graph, &forest)));
    let (a, b) = (a?, b?);
    Ok(if makespan_s(instance, &b) < makespan_s(instance, &a) { b } else { a })
}
