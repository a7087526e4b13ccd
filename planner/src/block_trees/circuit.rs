//! From a tree to the closed walk around it.
//!
//! The moves of a tree are connected, and each cell has an even number of them: there is a closed walk that makes each
//! once. At every cell the moves are paired as cheaply as can be, which leaves one or more circuits; two circuits
//! that meet in a cell become one when they swap partners there, the cheapest swaps first.

use super::{
    blocks::{Block, Blocks},
    forest::{Forest, Member, Tree},
    pricing::{Corners, Ways, stubs},
};
use crate::{Instance, disjoint_sets::DisjointSets};
use terrain::{Cell, Direction};

/// End of a move at a cell: number of the cell × 8 + direction × 2 + copy.
type Stub = u32;

const NONE: Stub = Stub::MAX;

/// Finds walks one after another; keeps a table by cell between them.
pub(crate) struct Walker<'a> {
    instance: &'a Instance<'a>,
    blocks: &'a Blocks,
    corners: Corners,
    /// Row-major: number of a cell within the tree at hand.
    number_of: Vec<u32>,
}

/// The moves of one tree.
struct Moves {
    cells: Vec<Cell>,
    ways: Vec<Ways>,
    /// Per stub: the stub at the other end of its move.
    across: Vec<Stub>,
    /// Per stub: the stub at the same cell by which the walk goes on.
    partner: Vec<Stub>,
}

impl<'a> Walker<'a> {
    pub(crate) fn new(instance: &'a Instance<'a>, blocks: &'a Blocks) -> Self {
        let number_of = vec![u32::MAX; instance.floor.lattice().len()];
        Self { instance, blocks, corners: Corners::new(instance), number_of }
    }

    /// The cells of the closed walk around a tree, from `start` to `start`; `start` alone when there is no move.
    pub(crate) fn walk(&mut self, forest: &Forest, tree: Tree, root: Block, start: Cell) -> Vec<Cell> {
        let mut members: Vec<(Block, Member)> = Vec::new();
        forest.subtree(self.blocks, tree, root, usize::MAX, &mut members);
        let mut moves = self.moves(&members);
        moves.pair(self.corners);
        moves.merge(self.corners);
        let lattice = self.instance.floor.lattice();
        let first = self.number_of[lattice.index(start).expect("a start is on the lattice")];
        moves.follow(first, self.corners)
    }

    fn moves(&mut self, members: &[(Block, Member)]) -> Moves {
        let lattice = *self.instance.floor.lattice();
        let (mut cells, mut ways) = (Vec::new(), Vec::new());
        for &(block, member) in members {
            for (cell, of_cell) in stubs(self.blocks, block, member.used) {
                let index = lattice.index(cell).expect("cells of blocks are on the lattice");
                self.number_of[index] = cells.len() as u32;
                cells.push(cell);
                ways.push(of_cell);
            }
        }
        let mut across = vec![NONE; 8 * cells.len()];
        for (number, &cell) in cells.iter().enumerate() {
            for way in Direction::ALL {
                for copy in 0..u32::from(ways[number][way as usize]) {
                    let index = lattice.index(cell.step(way)).expect("moves stay on the lattice");
                    let other = self.number_of[index];
                    across[(stub(number as u32, way, copy)) as usize] = stub(other, way.opposite(), copy);
                }
            }
        }
        let partner = vec![NONE; across.len()];
        Moves { cells, ways, across, partner }
    }
}

const fn stub(cell: u32, way: Direction, copy: u32) -> Stub {
    cell * 8 + way as u32 * 2 + copy
}

const fn way_of(stub: Stub) -> Direction {
    Direction::ALL[(stub % 8 / 2) as usize]
}

impl Moves {
    /// The stubs at a cell.
    fn stubs(&self, cell: u32) -> impl Iterator<Item = Stub> + '_ {
        (cell * 8..cell * 8 + 8).filter(|&stub| self.across[stub as usize] != NONE)
    }

    fn pair(&mut self, corners: Corners) {
        for cell in 0..self.cells.len() as u32 {
            let stubs: Vec<Stub> = self.stubs(cell).collect();
            let (_, pairs) = cheapest_pairs(corners, &stubs);
            for (one, other) in pairs {
                self.join(one, other);
            }
        }
    }

    fn join(&mut self, one: Stub, other: Stub) {
        self.partner[one as usize] = other;
        self.partner[other as usize] = one;
    }

    /// Makes one circuit of all.
    fn merge(&mut self, corners: Corners) {
        let mut circuits = DisjointSets::new(self.across.len());
        for stub in 0..self.across.len() as Stub {
            if self.across[stub as usize] != NONE {
                circuits.unite(stub, self.across[stub as usize]);
                circuits.unite(stub, self.partner[stub as usize]);
            }
        }
        let mut places: Vec<(f64, u32)> = Vec::new();
        for cell in 0..self.cells.len() as u32 {
            let pairs = self.ways[cell as usize].iter().sum::<u8>() / 2;
            if pairs > 1
                && let Some((added_s, ..)) = self.best_swap(cell, corners, &mut circuits)
            {
                places.extend((1..pairs).map(|_| (added_s, cell)));
            }
        }
        places.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (_, cell) in places {
            if let Some((_, [a, b], [c, d])) = self.best_swap(cell, corners, &mut circuits) {
                self.join(a, b);
                self.join(c, d);
                circuits.unite(a, b);
            }
        }
    }

    /// The swap at a cell that joins two circuits at the least cost: added seconds, and the new pairs.
    fn best_swap(
        &self,
        cell: u32,
        corners: Corners,
        circuits: &mut DisjointSets,
    ) -> Option<(f64, [Stub; 2], [Stub; 2])> {
        let stubs: Vec<Stub> = self.stubs(cell).collect();
        let price_s = |one: Stub, other: Stub| corners.between_s(way_of(one), way_of(other));
        let mut best: Option<(f64, [Stub; 2], [Stub; 2])> = None;
        for &a in &stubs {
            let b = self.partner[a as usize];
            for &c in stubs.iter().filter(|&&c| c > a) {
                let d = self.partner[c as usize];
                if circuits.find(a) == circuits.find(c) {
                    continue;
                }
                let added_s = price_s(a, c) + price_s(b, d) - price_s(a, b) - price_s(c, d);
                if best.as_ref().is_none_or(|&(best_s, ..)| added_s < best_s - 1e-12) {
                    best = Some((added_s, [a, c], [b, d]));
                }
            }
        }
        best
    }

    /// Goes round from a cell, beginning and ending where the dearest corner is saved.
    fn follow(&self, first: u32, corners: Corners) -> Vec<Cell> {
        let corner_s = |stub: Stub| corners.between_s(way_of(stub), way_of(self.partner[stub as usize]));
        let begin = self.stubs(first).max_by(|&a, &b| corner_s(a).total_cmp(&corner_s(b)).then(b.cmp(&a)));
        let mut walk = vec![self.cells[first as usize]];
        let Some(begin) = begin else { return walk };
        let mut leaving = begin;
        loop {
            let arrived = self.across[leaving as usize];
            walk.push(self.cells[(arrived / 8) as usize]);
            leaving = self.partner[arrived as usize];
            if leaving == begin {
                return walk;
            }
        }
    }
}

/// The cheapest pairs of stubs at a cell.
fn cheapest_pairs(corners: Corners, stubs: &[Stub]) -> (f64, Vec<(Stub, Stub)>) {
    let Some((&first, rest)) = stubs.split_first() else { return (0.0, Vec::new()) };
    let mut best = (f64::INFINITY, Vec::new());
    for (place, &second) in rest.iter().enumerate() {
        let mut others = rest.to_vec();
        others.remove(place);
        let (rest_s, mut pairs) = cheapest_pairs(corners, &others);
        let all_s = rest_s + corners.between_s(way_of(first), way_of(second));
        if all_s < best.0 - 1e-12 {
            pairs.push((first, second));
            best = (all_s, pairs);
        }
    }
    best
}
