//! Blocks of open cells and how a walk may pass between them.
//!
//! A block is a connected part of an aligned 2 × 2 square. On its own it is walked around: whole, along its four inner
//! moves; where quarters are missing, there and back along a path. Two blocks that touch can be joined in one of two ways:
//!
//! ```text
//!   parallel:  u1 ── v1      both crossings, in place of one      single:  u ══ v   one crossing,
//!              :      :      inner move of either block                             there and back
//!              u2 ── v2
//! ```
//!
//! Around any tree of joined blocks this gives a connected set of moves in which each cell has an even number: a closed
//! walk, whose cost is a sum over blocks that depends only on which joints of each block are used.

use crate::Instance;
use terrain::{Cell, Direction};

/// Number of a block.
pub(crate) type Block = u32;

/// A pair of blocks that can be joined.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Joint {
    /// The other block.
    pub(crate) other: Block,
    /// Number of this joint among those of the other block.
    pub(crate) back: u8,
    /// Cells on this side; the second one for a parallel joint only.
    pub(crate) own: (Cell, Option<Cell>),
    /// Where the crossings lead.
    pub(crate) side: Direction,
}

/// All blocks of open, reachable ground.
#[derive(Debug)]
pub(crate) struct Blocks {
    /// Per block its open cells, by quarter: south-west, south-east, north-east, north-west.
    pub(crate) cells: Vec<[Option<Cell>; 4]>,
    /// Per block: whether the body can move from each quarter to the next one, anticlockwise.
    pub(crate) inner: Vec<[bool; 4]>,
    /// Per block: whether a cell of it is to be visited.
    pub(crate) needed: Vec<bool>,
    /// Per block its joints.
    pub(crate) joints: Vec<Vec<Joint>>,
    /// Row-major: the block of each cell; `Block::MAX` for closed ones.
    pub(crate) of_cell: Vec<Block>,
}

const fn quarter(cell: Cell) -> usize {
    match (cell.x & 1, cell.y & 1) {
        (0, 0) => 0,
        (1, 0) => 1,
        (1, 1) => 2,
        _ => 3,
    }
}

const fn square(cell: Cell) -> (i32, i32) {
    (cell.x >> 1, cell.y >> 1)
}

impl Blocks {
    pub(crate) fn new(instance: &Instance<'_>) -> Self {
        let lattice = *instance.floor.lattice();
        let reachable = instance.reachable();
        let mut blocks = Self {
            cells: Vec::new(),
            inner: Vec::new(),
            needed: Vec::new(),
            joints: Vec::new(),
            of_cell: vec![Block::MAX; lattice.len()],
        };
        for cell in lattice.cells() {
            let index = lattice.index(cell).expect("cells() gives cells of the lattice");
            if reachable[index] && blocks.of_cell[index] == Block::MAX {
                blocks.add(instance, cell);
            }
        }
        blocks.joints = vec![Vec::new(); blocks.cells.len()];
        for block in 0..blocks.cells.len() as Block {
            for side in [Direction::East, Direction::North] {
                blocks.join(instance, block, side);
            }
        }
        blocks
    }

    pub(crate) fn len(&self) -> usize {
        self.cells.len()
    }

    /// The block of a cell.
    pub(crate) fn at(&self, instance: &Instance<'_>, cell: Cell) -> Option<Block> {
        let block = self.of_cell[instance.floor.lattice().index(cell)?];
        (block != Block::MAX).then_some(block)
    }

    /// The connected part of a square that holds `cell`.
    fn add(&mut self, instance: &Instance<'_>, cell: Cell) {
        let lattice = instance.floor.lattice();
        let block = self.cells.len() as Block;
        let mut own = [None; 4];
        let mut needed = false;
        let mut stack = vec![cell];
        while let Some(at) = stack.pop() {
            let index = lattice.index(at).expect("only cells of the lattice are stacked");
            if self.of_cell[index] != Block::MAX {
                continue;
            }
            self.of_cell[index] = block;
            own[quarter(at)] = Some(at);
            needed |= instance.visit[index];
            stack.extend(instance.neighbours(at).filter(|&next| square(next) == square(cell)));
        }
        let moves = |from: usize| {
            let (from, to) = (own[from], own[(from + 1) % 4]);
            from.zip(to).is_some_and(|(from, to)| can_move(instance, from, to))
        };
        self.inner.push([moves(0), moves(1), moves(2), moves(3)]);
        self.cells.push(own);
        self.needed.push(needed);
    }

    /// Joins a block to the one or two blocks on a side.
    fn join(&mut self, instance: &Instance<'_>, block: Block, side: Direction) {
        let (first, second) = match side {
            Direction::East => (1, 2),
            _ => (3, 2),
        };
        let own = self.cells[block as usize];
        let crossing = |quarter: usize| {
            let cell = own[quarter]?;
            let next = cell.step(side);
            let crosses = instance.floor.can_move(cell, side) && instance.is_open(next);
            crosses.then(|| self.at(instance, next)).flatten().map(|other| (cell, other))
        };
        match (crossing(first), crossing(second)) {
            (Some((a, one)), Some((b, other))) if one == other => {
                let parallel = can_move(instance, a, b) && can_move(instance, a.step(side), b.step(side));
                let second = (parallel && parallel_is_cheaper(instance, a, b, side)).then_some(b);
                let cells = (a, second);
                self.link(block, one, side, cells);
            }
            (one, other) => {
                for (cell, next) in [one, other].into_iter().flatten() {
                    self.link(block, next, side, (cell, None));
                }
            }
        }
    }

    fn link(&mut self, block: Block, other: Block, side: Direction, own: (Cell, Option<Cell>)) {
        let (here, there) =
            (self.joints[block as usize].len() as u8, self.joints[other as usize].len() as u8);
        let across = (own.0.step(side), own.1.map(|cell| cell.step(side)));
        self.joints[block as usize].push(Joint { other, back: there, own, side });
        self.joints[other as usize].push(Joint {
            other: block,
            back: here,
            own: across,
            side: side.opposite(),
        });
    }
}

fn can_move(instance: &Instance<'_>, from: Cell, to: Cell) -> bool {
    Direction::between(from, to).is_some_and(|way| instance.floor.can_move(from, way))
}

/// Whether two crossings, less the inner moves that they replace, take no longer than one crossing there and back.
fn parallel_is_cheaper(instance: &Instance<'_>, a: Cell, b: Cell, side: Direction) -> bool {
    let (over_a, over_b) = (a.step(side), b.step(side));
    let parallel_s = instance.move_s(a, over_a) + instance.move_s(b, over_b)
        - instance.move_s(a, b)
        - instance.move_s(over_a, over_b);
    parallel_s <= 2.0 * instance.move_s(a, over_a)
}
