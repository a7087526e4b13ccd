//! STC: spanning tree coverage by one robot.
//!
//! **Problem.** Cover all cells of a grid with as little driving as possible.
//! **Idea.** Join 2 × 2 cells to mega cells; grow a spanning tree over the mega cells that touch; drive around the
//! tree. The walk is closed and passes each cell once. The tree grows depth first along rows, or along columns: the one
//! with fewer turns is taken. On each connected piece of ground the robot that is ready first does it all; the others stay:
//! this is the time that several robots have to beat.
//! **Guarantee.** Each cell of a whole mega cell is passed exactly once; where blocks are partly to be visited,
//! missing quarters are bridged by shortest ways.
//! **Complexity.** O(n).
//! **Paper.** Y. Gabriely, E. Rimon: Spanning-tree based coverage of continuous areas by a mobile robot. Annals of
//! Mathematics and Artificial Intelligence 31, 2001.
//! **Departures.** Partly visited mega cells and several pieces are allowed; the paper takes whole ones, connected.

use crate::{
    Instance, Plan, PlanError, PlanOptions,
    circumnavigation::{Forest, loops},
    division::divide_among,
    spanning_graph::SpanningGraph,
    spanning_trees::{ALONG_COLUMNS, ALONG_ROWS, depth_first},
};
use std::collections::BTreeMap;

/// Plans.
pub(super) fn plan(instance: &Instance<'_>, _options: &PlanOptions) -> Result<Plan, PlanError> {
    let graph = SpanningGraph::new(instance);
    let forest = depth_first_forest(&graph);
    divide_among(instance, loops(&graph, &forest), &first_of_each_piece(instance))
}

/// Per robot: whether it is the first that is ready on its connected piece of ground.
fn first_of_each_piece(instance: &Instance<'_>) -> Vec<bool> {
    let component = instance.components();
    let piece = |robot: usize| {
        instance.floor.lattice().index(instance.starts[robot].cell).map_or(u32::MAX, |index| component[index])
    };
    let mut first: BTreeMap<u32, usize> = BTreeMap::new();
    for (robot, start) in instance.starts.iter().enumerate() {
        let known = first.entry(piece(robot)).or_insert(robot);
        if start.available_in_s < instance.starts[*known].available_in_s {
            *known = robot;
        }
    }
    (0..instance.starts.len()).map(|robot| first[&piece(robot)] == robot).collect()
}

/// The forest grown along rows or along columns, whichever has fewer turns.
pub(super) fn depth_first_forest(graph: &SpanningGraph) -> Forest {
    let along_rows = depth_first(graph, ALONG_ROWS);
    let along_columns = depth_first(graph, ALONG_COLUMNS);
    if along_columns.turns() < along_rows.turns() { along_columns } else { along_rows }
}
