//! The tree of TMSTC*: bricks joined by the edges that add the fewest turns.

use crate::{
    bricks::{Sided as _, Tiling, tile},
    circumnavigation::{Forest, turns_around},
    disjoint_sets::DisjointSets,
    spanning_graph::{Node, SpanningGraph},
};
use std::{cmp::Reverse, collections::BinaryHeap};
use terrain::Direction;

/// The better of the trees grown from two minimum tilings.
pub(crate) fn turn_minimising(graph: &SpanningGraph) -> Forest {
    let [a, b] = turn_minimising_pair(graph);
    if b.turns() < a.turns() { b } else { a }
}

/// The trees grown from two minimum tilings, which differ where joins across and along do equally well.
pub(crate) fn turn_minimising_pair(graph: &SpanningGraph) -> [Forest; 2] {
    tile(graph).map(|tiling| merge_bricks(graph, &tiling))
}

/// Algorithm 1 of the paper: bricks joined to trees, each time by the edge that adds the fewest turns.
fn merge_bricks(graph: &SpanningGraph, tiling: &Tiling) -> Forest {
    let mut forest = Forest::new(graph);
    let mut sets = DisjointSets::new(graph.len());
    for &(node, direction) in tiling {
        let other = graph.neighbour(node, direction).expect("a join is an edge");
        forest.join(node, direction, other);
        sets.unite(node, other);
    }
    let mut heap: BinaryHeap<Reverse<(i32, Node, Direction)>> = BinaryHeap::new();
    for node in 0..graph.len() as Node {
        for direction in [Direction::East, Direction::North] {
            if let Some(other) = graph.neighbour(node, direction).filter(|_| !forest.has(node, direction)) {
                heap.push(Reverse((added_turns(&forest, node, direction, other), node, direction)));
            }
        }
    }
    while let Some(Reverse((cost, node, direction))) = heap.pop() {
        let other = graph.neighbour(node, direction).expect("only edges are in the heap");
        if sets.find(node) == sets.find(other) {
            continue;
        }
        let now = added_turns(&forest, node, direction, other);
        if now == cost {
            forest.join(node, direction, other);
            sets.unite(node, other);
        } else {
            heap.push(Reverse((now, node, direction)));
        }
    }
    forest
}

/// Equation 6: how many turns an edge adds.
fn added_turns(forest: &Forest, node: Node, direction: Direction, other: Node) -> i32 {
    let added = |edges: u8, towards: Direction| {
        turns_around(edges | 1 << towards as u8) as i32 - turns_around(edges) as i32
    };
    added(forest.edges(node), direction) + added(forest.edges(other), direction.opposite())
}
