//! The least number of straight lanes along two directions on a lattice of tool-wide squares.
//!
//! ```text
//!   each square is driven along or across:   ═══╗      a lane begins at an along-square whose left neighbour is not one,
//!                                            ═══║      and at an across-square whose upper neighbour is not one
//! ```
//!
//! With x = 1 for along, these are the terms `x (1 − x_left)` and `(1 − x) x_up`: submodular, so the labelling with the fewest
//! lanes is a minimum cut, and its capacity is the number of lanes: a certificate that no labelling of this lattice has
//! fewer. Squares are neighbours where
//! wanted ground goes on from one to the other. O(E √V) for V squares and at most 2 V edges.

use crate::{configuration_space::ConfigurationSpace, ground::Ground, maximum_flow::Network};
use std::ops::Range;
use terrain::{Lattice, Point, Vector};

/// A square belongs to the lattice with this share of it wanted, at least.
const SHARE_MIN: f64 = 0.06;

/// Tool-wide squares over the ground.
#[derive(Debug, Clone)]
pub(crate) struct ToolLattice {
    /// Lower left corner of square 0.
    pub(crate) origin: Point,
    /// Side of a square, metres.
    pub(crate) side_m: f64,
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    /// Row-major: whether enough of a square is wanted.
    pub(crate) is_in: Vec<bool>,
    /// Row-major: whether the body gets to the right neighbour, and to the upper one.
    pub(crate) joined: Vec<[bool; 2]>,
}

/// Which squares are driven along the rows, and the lanes that makes.
#[derive(Debug, Clone)]
pub(crate) struct Orientation {
    pub(crate) lattice: ToolLattice,
    /// Row-major: along the rows, or across.
    pub(crate) is_along: Vec<bool>,
    /// The number of lanes, which is the capacity of the cut: none has fewer.
    pub(crate) lanes: u64,
}

/// A maximal run of squares of one direction.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Run {
    pub(crate) is_along: bool,
    /// Numbers of the squares, in the lattice's direction.
    pub(crate) squares: Vec<usize>,
}

impl ToolLattice {
    /// Over the ground that is left, moved by `shift` (shares of a square).
    pub(crate) fn new(space: &ConfigurationSpace<'_>, ground: &Ground, shift: [f64; 2]) -> Self {
        let side_m = space.instance().floor.tool_width_m();
        let samples = ground.samples();
        let [x, y] = ground.left_box().unwrap_or_default();
        let corner = [x, y].map(|range| range.0 as f64 * samples.cell_m);
        let corner = [0, 1].map(|axis| corner[axis] - shift[axis] * side_m);
        let count = |axis: usize, last: usize| {
            let far_m = (last + 1) as f64 * samples.cell_m;
            ((far_m - corner[axis]) / side_m - 1e-6).ceil().max(1.0) as usize
        };
        let (columns, rows) = if ground.left_count() == 0 { (0, 0) } else { (count(0, x.1), count(1, y.1)) };
        let mut lattice = Self {
            origin: samples.origin + Vector::from(corner),
            side_m,
            columns,
            rows,
            is_in: Vec::new(),
            joined: vec![[false; 2]; columns * rows],
        };
        lattice.mark(ground);
        lattice
    }

    /// The samples in a column (axis 0) or row (axis 1) of squares: a range of their columns or rows.
    pub(crate) fn samples_in(&self, samples: &Lattice, axis: usize, number: usize) -> Range<usize> {
        let most = if axis == 0 { samples.columns } else { samples.rows };
        let begin = |number: usize| {
            let from_m = self.origin[axis] - samples.origin[axis] + number as f64 * self.side_m;
            (from_m / samples.cell_m - 0.5 - 1e-9).ceil().clamp(0.0, f64::from(most)) as usize
        };
        begin(number)..begin(number + 1)
    }

    fn mark(&mut self, ground: &Ground) {
        let samples = *ground.samples();
        let x: Vec<Range<usize>> = (0..self.columns).map(|n| self.samples_in(&samples, 0, n)).collect();
        let y: Vec<Range<usize>> = (0..self.rows).map(|n| self.samples_in(&samples, 1, n)).collect();
        let index = |column: usize, row: usize| row * samples.columns as usize + column;
        let is_left = |column: usize, row: usize| ground.is_left(index(column, row));
        let least = (SHARE_MIN * (self.side_m / samples.cell_m).powi(2)).max(1.0);
        for (row, rows) in y.iter().enumerate() {
            for (column, columns) in x.iter().enumerate() {
                let in_row = |row: usize| columns.clone().filter(|&column| is_left(column, row)).count();
                let count: usize = rows.clone().map(in_row).sum();
                self.is_in.push(count as f64 >= least);
                let (right, up) = (columns.end, rows.end);
                // Joined to the next square where ground goes on across its first column or row; a square beyond the
                // last of the samples has none.
                let joined = &mut self.joined[row * self.columns + column];
                joined[0] = column + 1 < self.columns
                    && (1..samples.columns as usize).contains(&right)
                    && rows.clone().any(|row| is_left(right - 1, row) && is_left(right, row));
                joined[1] = row + 1 < self.rows
                    && (1..samples.rows as usize).contains(&up)
                    && columns.clone().any(|column| is_left(column, up - 1) && is_left(column, up));
            }
        }
    }

    /// Distances of a point from the origin along the rows and across them.
    pub(crate) fn position(&self, point: Point) -> [f64; 2] {
        let from_origin = point - self.origin;
        [from_origin.x, from_origin.y]
    }

    /// The point at these distances.
    pub(crate) fn point(&self, from_origin: [f64; 2]) -> Point {
        self.origin + Vector::from(from_origin)
    }

    fn left(&self, square: usize) -> Option<usize> {
        (!square.is_multiple_of(self.columns) && self.is_in[square - 1] && self.joined[square - 1][0])
            .then(|| square - 1)
    }

    fn up(&self, square: usize) -> Option<usize> {
        let above = square + self.columns;
        (above < self.is_in.len() && self.is_in[above] && self.joined[square][1]).then_some(above)
    }

    fn down(&self, square: usize) -> Option<usize> {
        let below = square.checked_sub(self.columns)?;
        (self.is_in[below] && self.joined[below][1]).then_some(below)
    }

    fn squares(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.is_in.len()).filter(|&square| self.is_in[square])
    }
}

impl Orientation {
    /// The fewest lanes.
    pub(crate) fn minimum(lattice: ToolLattice) -> Self {
        let squares = lattice.is_in.len();
        let (along, across) = (squares, squares + 1);
        let mut network = Network::new(squares + 2);
        for square in lattice.squares() {
            network.add(square, lattice.left(square).unwrap_or(across), 1);
            network.add(lattice.up(square).unwrap_or(along), square, 1);
        }
        let (lanes, is_along) = network.minimum_cut(along, across);
        let found = Self { is_along: is_along[..squares].to_vec(), lattice, lanes };
        assert_eq!(found.runs().len() as u64, found.lanes, "the cut is the number of lanes");
        found
    }

    /// The lanes as runs of squares.
    pub(crate) fn runs(&self) -> Vec<Run> {
        let mut runs = Vec::new();
        for first in self.lattice.squares() {
            let is_along = self.is_along[first];
            let same = |square: &usize| self.is_along[*square] == is_along;
            let before = if is_along { self.lattice.left(first) } else { self.lattice.up(first) };
            if before.as_ref().is_some_and(same) {
                continue;
            }
            let next = |&square: &usize| {
                let next = if is_along {
                    Some(square + 1).filter(|&next| {
                        next < self.lattice.is_in.len() && self.lattice.left(next) == Some(square)
                    })
                } else {
                    self.lattice.down(square)
                };
                next.filter(|next| self.lattice.is_in[*next]).filter(same)
            };
            let mut squares: Vec<usize> = std::iter::successors(Some(first), next).collect();
            if !is_along {
                squares.reverse();
            }
            runs.push(Run { is_along, squares });
        }
        runs
    }
}
