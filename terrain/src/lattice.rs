//! The lattice of square cells that is laid over a map: the only place where cells and metres are converted.

use crate::{Cell, Direction, Point, Segment, Vector};
use std::ops::RangeInclusive;

/// Ends of a segment that differ by less are at the same place along an axis, metres.
const PARALLEL_M: f64 = 1e-9;
/// What is nearer to a line of the lattice counts as on it, cells; it is taken to be so far beyond it.
const ON_LINE: f64 = 1e-8;

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
        // What is parallel to lines but for rounding stays on its side of them, whichever end it begins at; what runs
        // along a line but for rounding does, too, whatever part of it is asked for.
        let is_parallel = |axis: usize| way[axis].abs() < PARALLEL_M;
        let middle = self.off_lines(nalgebra::center(&segment.from, &segment.to));
        let point = |share: f64| {
            let on_way = segment.from + way * share;
            Point::from([0, 1].map(|axis| if is_parallel(axis) { middle[axis] } else { on_way[axis] }))
        };
        for axis in 0..2 {
            if is_parallel(axis) {
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
            .filter_map(|pair| self.cell_at(point(f64::midpoint(pair[0], pair[1]))))
            .collect();
        cells.dedup();
        cells
    }

    /// A point; where it is on lines of the lattice but for rounding, a little beyond them.
    fn off_lines(&self, point: Point) -> Point {
        Point::from([0, 1].map(|axis| {
            let line = (point[axis] - self.origin[axis]) / self.cell_m;
            let is_on = (line - line.round()).abs() < ON_LINE;
            if is_on { self.origin[axis] + (line.round() + ON_LINE) * self.cell_m } else { point[axis] }
        }))
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
        let [columns, rows] = self.ranges_in_box(low, high);
        rows.flat_map(move |y| columns.clone().map(move |x| Cell::new(x, y)))
    }

    /// Columns and rows of these cells.
    pub(crate) fn ranges_in_box(&self, low: Point, high: Point) -> [RangeInclusive<i32>; 2] {
        let column = |x: f64| ((x - self.origin.x) / self.cell_m).floor();
        let row = |y: f64| ((y - self.origin.y) / self.cell_m).floor();
        let x0 = column(low.x).max(0.0) as i32;
        let y0 = row(low.y).max(0.0) as i32;
        let x1 = column(high.x).min(f64::from(self.columns) - 1.0) as i32;
        let y1 = row(high.y).min(f64::from(self.rows) - 1.0) as i32;
        [x0..=x1, y0..=y1]
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
    fn a_segment_on_a_line_but_for_rounding_stays_on_one_side_whichever_way() {
        for end in [-4.4e-16, -1.1e-16, 0.0, 1.1e-16, 4.4e-16] {
            let up = along((0.0, 0.2), (end, 1.9));
            let mut down = along((end, 1.9), (0.0, 0.2));
            down.reverse();
            assert_eq!(up, down, "{end}");
            assert!(up.len() == 4 && up.iter().all(|cell| cell.0 == up[0].0), "{end}: {up:?}");
        }
    }

    /// A lane along a line was free in parts and not as a whole: `what_is_left_of_random_floors_is_swept` of the planner.
    #[test]
    fn parts_of_a_segment_on_a_line_but_for_rounding_lie_on_the_side_of_the_whole() {
        let ys = [0.5, 0.499_999_999_999_999_9, 0.500_000_000_000_000_1];
        for (from, to) in ys.iter().flat_map(|&from| ys.map(|to| (from, to))) {
            let cells = along((-0.9, from), (0.6, to));
            assert_eq!(cells, [(0, 1), (1, 1), (2, 1), (3, 1)], "{from} {to}");
        }
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
