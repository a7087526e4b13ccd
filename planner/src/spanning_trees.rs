//! The spanning trees that Table II of TMSTC* compares: how a tree is grown decides the turns of the walk around it.

mod ant_colony;
mod depth_first;
mod kruskal;
mod turn_minimising;

pub(crate) use depth_first::depth_first;
pub(crate) use kruskal::kruskal;
pub(crate) use turn_minimising::{turn_minimising, turn_minimising_pair};

use crate::{Instance, circumnavigation::Forest, spanning_graph::SpanningGraph};
use terrain::Direction;

/// A way to grow spanning trees.
#[derive(Debug, Clone, Copy)]
pub struct Tree {
    /// Its name.
    pub name: &'static str,
    /// Whether it draws random numbers.
    pub draws: bool,
    grow: fn(&SpanningGraph, seed: u64) -> Forest,
}

/// Every tree, in the order of Table II.
pub const TREES: &[Tree] = &[
    Tree { name: "dfs-horizontal", draws: false, grow: |graph, _| depth_first(graph, ALONG_ROWS) },
    Tree { name: "dfs-vertical", draws: false, grow: |graph, _| depth_first(graph, ALONG_COLUMNS) },
    Tree { name: "aco", draws: true, grow: ant_colony::ant_colony },
    Tree { name: "kruskal", draws: false, grow: |graph, _| kruskal(graph) },
    Tree { name: "turn-minimising", draws: false, grow: |graph, _| turn_minimising(graph) },
];

/// Directions tried by a depth first search that prefers rows.
pub(crate) const ALONG_ROWS: [Direction; 4] =
    [Direction::East, Direction::West, Direction::North, Direction::South];
/// Directions tried by a depth first search that prefers columns.
pub(crate) const ALONG_COLUMNS: [Direction; 4] =
    [Direction::North, Direction::South, Direction::East, Direction::West];

/// Quarter turns of the closed walks around the trees of an instance (equation 5 of TMSTC*).
pub fn tree_turns(instance: &Instance<'_>, tree: &Tree, seed: u64) -> u32 {
    (tree.grow)(&SpanningGraph::new(instance), seed).turns()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Mode, Start};
    use terrain::{Floor, Lattice, MotionModel, Point, parse_movingai};

    /// Turns of the walks around trees of a shared map, in the order of `TREES`; `None` when the map is not there.
    fn turns_on(name: &str) -> Option<Vec<u32>> {
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
        Some(TREES.iter().map(|tree| tree_turns(&instance, tree, 0)).collect())
    }

    #[test]
    fn the_turn_minimising_tree_has_no_more_turns_than_table_ii_and_fewer_than_any_other() {
        for (map, paper) in [("indoor", 206), ("random", 208), ("denver_2", 652), ("newyork_0", 780)] {
            let Some(turns) = turns_on(map) else { continue };
            println!("{map}: {turns:?}, Table II {paper}");
            let (ours, others) = turns.split_last().unwrap();
            assert!(*ours <= paper, "{map}: {ours} turns, Table II has {paper}");
            assert!(others.iter().all(|other| ours < other), "{map}: {turns:?}");
        }
    }
}
