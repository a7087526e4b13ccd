//! Whether any cell of a box is blocked: by sums over all cells below and to the left, so that each question takes four look-ups.

use crate::Instance;
use terrain::{Lattice, Point};

/// For each corner of the lattice, how many cells below it and to its left are blocked; empty where none is.
#[derive(Debug, Clone)]
pub(super) struct BlockedCells {
    below: Vec<u32>,
}

impl BlockedCells {
    pub(super) fn new(instance: &Instance<'_>) -> Self {
        let columns = instance.floor.lattice().columns as usize;
        if !instance.blocked.contains(&true) {
            return Self { below: Vec::new() };
        }
        let mut below = vec![0; columns + 1];
        for (row, blocked) in instance.blocked.chunks(columns).enumerate() {
            let mut in_row = 0;
            below.push(0);
            for (column, &blocked) in blocked.iter().enumerate() {
                in_row += u32::from(blocked);
                below.push(below[row * (columns + 1) + column + 1] + in_row);
            }
        }
        Self { below }
    }

    /// Whether a cell that touches the box between two corners is blocked; what lies outside the lattice is not looked at.
    pub(super) fn any_in_box(&self, lattice: &Lattice, low: Point, high: Point) -> bool {
        if self.below.is_empty() {
            return false;
        }
        let number = |at: Point, axis: usize| ((at[axis] - lattice.origin[axis]) / lattice.cell_m).floor();
        let first = |axis: usize, most: u32| number(low, axis).clamp(0.0, f64::from(most)) as usize;
        let end = |axis: usize, most: u32| (number(high, axis) + 1.0).clamp(0.0, f64::from(most)) as usize;
        let (x, y) = (first(0, lattice.columns), first(1, lattice.rows));
        let (end_x, end_y) = (end(0, lattice.columns).max(x), end(1, lattice.rows).max(y));
        let sum = |x: usize, y: usize| self.below[y * (lattice.columns as usize + 1) + x];
        sum(end_x, end_y) + sum(x, y) > sum(x, end_y) + sum(end_x, y)
    }
}
