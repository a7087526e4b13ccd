//! Kruskal's minimum spanning tree. All edges weigh the same, so they are taken in the order of the lattice.

use crate::{
    bricks::Sided as _,
    circumnavigation::Forest,
    disjoint_sets::DisjointSets,
    spanning_graph::{Node, SpanningGraph},
};
use terrain::Direction;

/// Kruskal's forest; edges in the order of their first node, east before north.
pub(crate) fn kruskal(graph: &SpanningGraph) -> Forest {
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
