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
//! equation 6 has it (the authors' program takes 0). Of the minimum tilings two are tried. The division is a bisection on the largest time with true
//! costs and any robot at any place of the walk, instead of sliding cuts between neighbours (equation 8 is the
//! `MotionModel`). In words for the paper's letters: the coverage graph G is the lattice, the spanning graph H is
//! `SpanningGraph`, the segment graph I is the graph of conflicts between joins.

use crate::{
    Instance, Plan, PlanError, PlanOptions,
    bricks::{Tiling, tile},
    circumnavigation::{Forest, loops, turns_around},
    disjoint_sets::DisjointSets,
    division::divide,
    spanning_graph::{Node, SpanningGraph},
};
use std::{cmp::Reverse, collections::BinaryHeap};
use terrain::Direction;

/// Plans.
pub(super) fn plan(instance: &Instance<'_>, _options: &PlanOptions) -> Result<Plan, PlanError> {
    let graph = SpanningGraph::new(instance);
    let forest = turn_minimising_forest(&graph);
    divide(instance, loops(&graph, &forest))
}

/// The better of the trees grown from two minimum tilings.
pub(crate) fn turn_minimising_forest(graph: &SpanningGraph) -> Forest {
    let [a, b] = tile(graph).map(|tiling| merge_bricks(graph, &tiling));
    if b.turns() < a.turns() { b } else { a }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Mode, Start,
        planners::{mstc_star, stc},
    };
    use terrain::{Floor, Lattice, MotionModel, Point, parse_movingai};

    /// Turns of the walk around a tree of a shared map; `None` when the map is not there.
    fn turns_on(name: &str, grow: fn(&SpanningGraph) -> Forest) -> Option<u32> {
        let path = format!("{}/../../shared/instances/tmstc/{name}.map", env!("CARGO_MANIFEST_DIR"));
        let Ok(text) = std::fs::read_to_string(&path) else {
            println!("skipped: {path} is not there");
            return None;
        };
        let map = parse_movingai(&text, 1.0).unwrap();
        let (columns, rows) = (2 * map.columns(), 2 * map.rows());
        let lattice = Lattice { origin: Point::origin(), cell_m: 0.5, columns, rows };
        let free: Vec<bool> =
            lattice.cells().map(|cell| map.is_free(i64::from(cell.x / 2), i64::from(cell.y / 2))).collect();
        let floor = Floor::from_cells(lattice, &free, 0.177, 0.5);
        let first = lattice.cell(free.iter().position(|&free| free).unwrap());
        let motion = MotionModel {
            speed_m_per_s: 0.5,
            acceleration_m_per_s2: 0.6,
            angular_speed_rad_per_s: 0.8,
            angular_acceleration_rad_per_s2: f64::INFINITY,
            brakes: false,
        };
        let instance = Instance::whole_floor(&floor, vec![Start::at(first)], motion, Mode::Cover);
        Some(grow(&SpanningGraph::new(&instance)).turns())
    }

    #[test]
    fn the_tree_has_no_more_turns_than_table_ii() {
        for (map, paper) in [("indoor", 206), ("random", 208), ("denver_2", 652), ("newyork_0", 780)] {
            if let Some(turns) = turns_on(map, turn_minimising_forest) {
                println!("{map}: {turns} turns, Table II {paper}");
                assert!(turns <= paper, "{map}: {turns} turns, Table II has {paper}");
            }
        }
    }

    #[test]
    fn the_tree_has_fewer_turns_than_those_of_the_other_planners() {
        for map in ["indoor", "random", "denver_2", "newyork_0"] {
            let Some(ours) = turns_on(map, turn_minimising_forest) else { continue };
            for (tree, grow) in [
                ("Kruskal", mstc_star::kruskal_forest as fn(&SpanningGraph) -> Forest),
                ("depth first", stc::depth_first_forest),
            ] {
                let turns = turns_on(map, grow).unwrap();
                println!("{map}: {ours} turns, {tree} {turns}");
                assert!(ours < turns, "{map}: {ours} turns, {tree} has {turns}");
            }
        }
    }
}
