//! From a spanning tree to the closed walk around it.
//!
//! Walking with the tree on the left hand passes each quarter of each node once:
//!
//! ```text
//!   NW ◀── NE      from SW: down along an edge to the south, else on to SE
//!    │     ▲       from SE: right along an edge to the east, else up to NE
//!    ▼     │       from NE: up along an edge to the north, else left to NW
//!   SW ──▶ SE      from NW: left along an edge to the west, else down to SW
//! ```

use crate::{
    bricks::Sided as _,
    spanning_graph::{Node, SpanningGraph},
};
use terrain::{Cell, Direction};

/// A spanning forest: per node, the directions in which it has a tree edge (one bit each).
#[derive(Debug, Clone)]
pub(crate) struct Forest {
    edges: Vec<u8>,
}

impl Forest {
    /// No edges yet.
    pub(crate) fn new(graph: &SpanningGraph) -> Self {
        Self { edges: vec![0; graph.len()] }
    }

    /// Adds the edge from a node in a direction, to `other`.
    pub(crate) fn join(&mut self, node: Node, direction: Direction, other: Node) {
        self.edges[node as usize] |= 1 << direction as u8;
        self.edges[other as usize] |= 1 << direction.opposite() as u8;
    }

    /// Whether a node has a tree edge in a direction.
    pub(crate) fn has(&self, node: Node, direction: Direction) -> bool {
        self.edges[node as usize] >> (direction as u8) & 1 == 1
    }

    /// Directions of a node's tree edges, one bit each.
    pub(crate) fn edges(&self, node: Node) -> u8 {
        self.edges[node as usize]
    }

    /// Quarter turns of the closed walks around all trees: 2 for an end, a corner or a T, 4 for a crossing or a
    /// lone node, 0 for a straight node (equation 5 of TMSTC*).
    pub(crate) fn turns(&self) -> u32 {
        self.edges.iter().map(|&edges| turns_around(edges)).sum()
    }
}

/// Quarter turns around a node with these tree edges.
pub(crate) const fn turns_around(edges: u8) -> u32 {
    match edges {
        0b0000 | 0b1111 => 4,
        0b0101 | 0b1010 => 0,
        _ => 2,
    }
}

/// The closed walks around the trees of a forest, as the cells to visit in the order of passing: one loop a tree.
pub(crate) fn loops(graph: &SpanningGraph, forest: &Forest) -> Vec<Vec<Cell>> {
    let mut walked = vec![false; graph.len()];
    let mut loops = Vec::new();
    for node in 0..graph.len() as Node {
        if walked[node as usize] {
            continue;
        }
        let mut cells = Vec::new();
        let (mut at, mut quarter) = (node, 0);
        loop {
            walked[at as usize] = true;
            cells.extend(graph.cell(at, quarter));
            (at, quarter) = next(graph, forest, at, quarter);
            if (at, quarter) == (node, 0) {
                break;
            }
        }
        loops.push(cells);
    }
    loops
}

fn next(graph: &SpanningGraph, forest: &Forest, node: Node, quarter: usize) -> (Node, usize) {
    const WAY_OUT: [(Direction, usize); 4] =
        [(Direction::South, 3), (Direction::East, 0), (Direction::North, 1), (Direction::West, 2)];
    let (direction, entered) = WAY_OUT[quarter];
    if forest.has(node, direction) {
        let other = graph.neighbour(node, direction).expect("a tree edge is an edge of the graph");
        (other, entered)
    } else {
        (node, (quarter + 1) % 4)
    }
}
