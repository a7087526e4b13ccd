//! STC: spanning tree coverage.
//!
//! **Problem.** Cover all cells of a grid with as little driving as possible.
//! **Idea.** Join 2 × 2 cells to mega cells; grow a spanning tree over the mega cells that touch; drive around the
//! tree. The walk is closed and passes each cell once. For several robots the walk is divided by cost
//! (`division.rs`). The tree grows depth first along rows, or along columns: the one with fewer turns is taken.
//! **Guarantee.** Each cell of a whole mega cell is passed exactly once; where blocks are partly to be visited,
//! missing quarters are bridged by shortest ways.
//! **Complexity.** O(n) for the tree and the walk, O(k n) for the division.
//! **Paper.** Y. Gabriely, E. Rimon: Spanning-tree based coverage of continuous areas by a mobile robot. Annals of
//! Mathematics and Artificial Intelligence 31, 2001.
//! **Departures.** Partly visited mega cells and several pieces are allowed; the paper takes whole ones, connected.

use crate::{
    Instance, Plan, PlanError, PlanOptions,
    circumnavigation::{Forest, loops},
    division::divide,
    spanning_graph::SpanningGraph,
    spanning_trees::{ALONG_COLUMNS, ALONG_ROWS, depth_first},
};

/// Plans.
pub(super) fn plan(instance: &Instance<'_>, _options: &PlanOptions) -> Result<Plan, PlanError> {
    let graph = SpanningGraph::new(instance);
    let forest = depth_first_forest(&graph);
    divide(instance, loops(&graph, &forest))
}

/// The forest grown along rows or along columns, whichever has fewer turns.
fn depth_first_forest(graph: &SpanningGraph) -> Forest {
    let along_rows = depth_first(graph, ALONG_ROWS);
    let along_columns = depth_first(graph, ALONG_COLUMNS);
    if along_columns.turns() < along_rows.turns() { along_columns } else { along_rows }
}
