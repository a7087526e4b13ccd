//! The lattice of square cells that is laid over a map: the only place where cells and metres are converted.

use crate::{Cell, Direction, Point, Segment, Vector};

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

    /// The cells that a segment passes through, in order; parts outside the lattice are left out. A segment through a
    /// corner of four cells passes two of them.
    pub fn cells_along(&self, segment: Segment) -> Vec<Cell> {
        let way = segment.to - segment.from;
        let mut shares = vec![0.0, 1.0];
        for axis in 0..2 {
            if way[axis] == 0.0 {
                continue;
            }
            let line = |place: f64| (place - self.origin[axis]) / self.cell_m;
            let (one, other) = (line(segment.from[axis]), line(segment.to[axis]));
            let lines = one.min(other).ceil() as i64..=one.max(other).floor() as i64;
            let share = |number: i64| (number as f64 - one) / (other - one);
            shares.extend(lines.map(share).filter(|share| (0.0..=1.0).contains(share)));
        }
        shares.sort_by(f64::total_cmp);
        let mut cells: Vec<Cell> = shares
            .windows(2)
            .filter(|pair| way.norm() == 0.0 || (pair[1] - pair[0]) * way.norm() > 1e-9)
            .filter_map(|pair| self.cell_at(segment.from + way * f64::midpoint(pair[0], pair[1])))
            .collect();
        cells.dedup();
        cells
    }

    /// The side of a cell towards a neighbour, in the frame of the map, metres; the cell may lie outside the lattice.
    pub fn side(&self, cell: Cell, towards: Direction) -> Segment {
        let (dx, dy) = towards.offset();
        let half_m = self.cell_m / 2.0;
        let middle = self.center(cell) + Vector::new(f64::from(dx), f64::from(dy)) * half_m;
        let along = Vector::new(-f64::from(dy), f64::from(dx)) * half_m;
        Segment::new(middle - along, middle + along)
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

#[cfg(test)]
mod tests {
    use super::*;

    fn along(from: (f64, f64), to: (f64, f64)) -> Vec<(i32, i32)> {
        let lattice = Lattice { origin: Point::new(-1.0, 0.0), cell_m: 0.5, columns: 6, rows: 4 };
        let segment = Segment::new(Point::new(from.0, from.1), Point::new(to.0, to.1));
        lattice.cells_along(segment).into_iter().map(|cell| (cell.x, cell.y)).collect()
    }

    #[test]
    fn a_segment_passes_the_cells_between_its_ends() {
        assert_eq!(along((-0.9, 0.1), (0.6, 0.1)), [(0, 0), (1, 0), (2, 0), (3, 0)]);
        assert_eq!(along((-0.6, 0.9), (-0.4, 1.3)), [(0, 1), (0, 2), (1, 2)]);
        assert_eq!(along((-1.0, 0.0), (0.0, 1.0)), [(0, 0), (1, 1)]);
        assert_eq!(along((0.1, 0.1), (0.1, 0.1)), [(2, 0)]);
        assert_eq!(along((1.9, 0.1), (5.0, 0.1)), [(5, 0)]);
    }
}
