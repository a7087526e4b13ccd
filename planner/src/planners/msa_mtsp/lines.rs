//! The fewest straight lines of cells that cover the floor.

use crate::{
    Instance,
    bricks::{Sided, tile},
    spanning_graph::Node,
};
use terrain::{Cell, Direction};

/// Cells in a row or column, each one move from the one before.
pub(super) type Line = Vec<Cell>;

/// Cells to visit, numbered.
struct Wanted<'a> {
    instance: &'a Instance<'a>,
    cells: Vec<Cell>,
    /// Row-major: number of a cell; `Node::MAX` for those not to visit.
    number_of: Vec<Node>,
}

impl Sided for Wanted<'_> {
    fn len(&self) -> usize {
        self.cells.len()
    }

    fn neighbour(&self, node: Node, side: Direction) -> Option<Node> {
        let cell = self.cells[node as usize];
        let next = self.instance.floor.lattice().index(cell.step(side))?;
        let number = self.number_of[next];
        (number != Node::MAX && self.instance.floor.can_move(cell, side)).then_some(number)
    }
}

/// Lines that hold each cell to visit once.
pub(super) fn lines(instance: &Instance<'_>) -> Vec<Line> {
    let lattice = instance.floor.lattice();
    let wanted = |cell: &Cell| lattice.index(*cell).is_some_and(|index| instance.visit[index]);
    let cells: Vec<Cell> = lattice.cells().filter(wanted).collect();
    let mut number_of = vec![Node::MAX; lattice.len()];
    for (number, &cell) in cells.iter().enumerate() {
        number_of[lattice.index(cell).expect("wanted cells are on the lattice")] = number as Node;
    }
    let graph = Wanted { instance, cells, number_of };
    let [tiling, _] = tile(&graph);
    let mut next: Vec<Option<Node>> = vec![None; graph.len()];
    let mut begins = vec![true; graph.len()];
    for (node, side) in tiling {
        let other = graph.neighbour(node, side).expect("a join is between neighbours");
        next[node as usize] = Some(other);
        begins[other as usize] = false;
    }
    let follow = |first: usize| {
        let numbers = std::iter::successors(Some(first as Node), |&node| next[node as usize]);
        numbers.map(|node| graph.cells[node as usize]).collect()
    };
    (0..graph.len()).filter(|&node| begins[node]).map(follow).collect()
}
