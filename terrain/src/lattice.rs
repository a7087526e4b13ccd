//! The lattice of square cells that is laid over a map: the only place where cells and metres are converted.

use crate::{Cell, Point};

/// Square cells over the map: cell (0, 0) has its lower left corner at `origin`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lattice {
    /// Lower left corner of cell (0, 0), metres.
    pub origin: Point,
    /// Side of a cell, metres.
    pub cell_m: f64,
    /// Number of columns.
    pub columns: u32,
    /// Number of rows.
    pub rows: u32,
}

impl Lattice {
    /// Number of cells.
    pub const fn len(&self) -> usize {
        self.columns as usize * self.rows as usize
    }

    /// Whether there is no cell at all.
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether `cell` is one of ours.
    pub const fn contains(&self, cell: Cell) -> bool {
        cell.x >= 0 && cell.y >= 0 && (cell.x as u32) < self.columns && (cell.y as u32) < self.rows
    }

    /// Row-major number of a cell, if it is one of ours.
    pub const fn index(&self, cell: Cell) -> Option<usize> {
        if self.contains(cell) {
            Some(cell.y as usize * self.columns as usize + cell.x as usize)
        } else {
            None
        }
    }

    /// The cell with a row-major number below `len()`.
    pub const fn cell(&self, index: usize) -> Cell {
        Cell::new((index % self.columns as usize) as i32, (index / self.columns as usize) as i32)
    }

    /// Centre of a cell (also of one outside the lattice).
    pub fn center(&self, cell: Cell) -> Point {
        Point::new(
            self.origin.x + (f64::from(cell.x) + 0.5) * self.cell_m,
            self.origin.y + (f64::from(cell.y) + 0.5) * self.cell_m,
        )
    }

    /// The cell that holds a point, if it is one of ours.
    pub fn cell_at(&self, point: Point) -> Option<Cell> {
        let x = ((point.x - self.origin.x) / self.cell_m).floor();
        let y = ((point.y - self.origin.y) / self.cell_m).floor();
        if !(x >= 0.0 && y >= 0.0 && x < f64::from(self.columns) && y < f64::from(self.rows)) {
            return None;
        }
        Some(Cell::new(x as i32, y as i32))
    }

    /// All cells, row by row from the bottom.
    pub fn cells(&self) -> impl Iterator<Item = Cell> + use<> {
        let (columns, rows) = (self.columns as i32, self.rows as i32);
        (0..rows).flat_map(move |y| (0..columns).map(move |x| Cell::new(x, y)))
    }

    /// The cells whose squares touch the box between two corners, clipped to the lattice.
    pub fn cells_in_box(&self, low: Point, high: Point) -> impl Iterator<Item = Cell> + use<> {
        let column = |x: f64| ((x - self.origin.x) / self.cell_m).floor();
        let row = |y: f64| ((y - self.origin.y) / self.cell_m).floor();
        let x0 = column(low.x).max(0.0) as i32;
        let y0 = row(low.y).max(0.0) as i32;
        let x1 = column(high.x).min(f64::from(self.columns) - 1.0) as i32;
        let y1 = row(high.y).min(f64::from(self.rows) - 1.0) as i32;
        (y0..=y1).flat_map(move |y| (x0..=x1).map(move |x| Cell::new(x, y)))
    }
}
