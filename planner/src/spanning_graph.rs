//! The spanning graph: mega cells, and which of them touch.
//!
//! A mega cell is a 2 × 2 block of the lattice, aligned to its origin. Where only part of a block is to be
//! visited, each connected part of it is a node of its own:
//!
//! ```text
//!   a a . b      a whole block, and a block of which one cell is to be visited:
//!   a a . .      two nodes; an edge where a move crosses from one to the other
//! ```

use crate::{Instance, bricks::Sided};
use terrain::{Cell, Direction};

/// Number of a node.
pub(crate) type Node = u32;

const NONE: Node = Node::MAX;

/// Nodes and edges. A node has at most one neighbour in each direction: the first that a crossing move finds.
#[derive(Debug)]
pub(crate) struct SpanningGraph {
    /// Per node: the cells to visit, by quarter (south-west, south-east, north-east, north-west).
    quarters: Vec<[Option<Cell>; 4]>,
    /// Per node: the neighbour in each direction.
    neighbours: Vec<[Node; 4]>,
}

/// The quarter of its block that a cell lies in: 0 south-west, then anticlockwise.
const fn quarter(cell: Cell) -> usize {
    match (cell.x & 1, cell.y & 1) {
        (0, 0) => 0,
        (1, 0) => 1,
        (1, 1) => 2,
        _ => 3,
    }
}

impl SpanningGraph {
    /// The graph of the cells to visit.
    pub(crate) fn new(instance: &Instance<'_>) -> Self {
        let lattice = *instance.floor.lattice();
        let mut node_of = vec![NONE; lattice.len()];
        let mut quarters: Vec<[Option<Cell>; 4]> = Vec::new();
        let visited = |cell: Cell| lattice.index(cell).filter(|&index| instance.visit[index]);
        for cell in lattice.cells() {
            let Some(index) = visited(cell) else { continue };
            if node_of[index] != NONE {
                continue;
            }
            let node = quarters.len() as Node;
            let mut own = [None; 4];
            let mut stack = vec![cell];
            node_of[index] = node;
            while let Some(at) = stack.pop() {
                own[quarter(at)] = Some(at);
                for next in instance.floor.neighbours(at).filter(|next| block(*next) == block(cell)) {
                    let Some(next_index) = visited(next).filter(|&next| node_of[next] == NONE) else {
                        continue;
                    };
                    node_of[next_index] = node;
                    stack.push(next);
                }
            }
            quarters.push(own);
        }
        let neighbours = neighbours(instance, &quarters, &node_of);
        Self { quarters, neighbours }
    }

    /// The cell to visit in a quarter of a node.
    pub(crate) fn cell(&self, node: Node, quarter: usize) -> Option<Cell> {
        self.quarters[node as usize][quarter]
    }
}

impl Sided for SpanningGraph {
    fn len(&self) -> usize {
        self.quarters.len()
    }

    fn neighbour(&self, node: Node, side: Direction) -> Option<Node> {
        let neighbour = self.neighbours[node as usize][side as usize];
        (neighbour != NONE).then_some(neighbour)
    }
}

const fn block(cell: Cell) -> (i32, i32) {
    (cell.x >> 1, cell.y >> 1)
}

/// An edge must be the only one of both its ends in its direction, so that the walk around a tree is a loop.
fn neighbours(instance: &Instance<'_>, quarters: &[[Option<Cell>; 4]], node_of: &[Node]) -> Vec<[Node; 4]> {
    let lattice = *instance.floor.lattice();
    let mut neighbours = vec![[NONE; 4]; quarters.len()];
    for (node, own) in quarters.iter().enumerate() {
        for &cell in own.iter().flatten() {
            for direction in [Direction::East, Direction::North] {
                let next = cell.step(direction);
                if block(next) == block(cell) || !instance.floor.can_move(cell, direction) {
                    continue;
                }
                let other = lattice.index(next).map_or(NONE, |index| node_of[index]);
                if other == NONE {
                    continue;
                }
                let back = direction.opposite() as usize;
                let free =
                    neighbours[node][direction as usize] == NONE && neighbours[other as usize][back] == NONE;
                if free {
                    neighbours[node][direction as usize] = other;
                    neighbours[other as usize][back] = node as Node;
                }
            }
        }
    }
    neighbours
}
