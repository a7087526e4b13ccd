//! Ground as rows of squares along the lanes of one direction: turn the ground, not the algorithm.
//!
//! ```text
//!   along ──▶                     a square's label says which piece of ground it belongs to;
//!   row 2   ..00000..1111..       NONE where nothing is to be swept.
//!   row 1   ..0000000111...       A slice is a row cut into runs of one label.
//!   row 0   ....00000000...
//! ```

use terrain::{Point, Vector};

/// Label of squares that are not to be swept.
pub(super) const NONE: u32 = u32::MAX;

/// Where squares lie whose rows run at some angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    corner: Point,
    along: Vector,
    step_m: f64,
    columns: usize,
    rows: usize,
}

impl Frame {
    /// Squares of side `step_m` over the box between two corners, with rows at an angle.
    pub(super) fn around(low: Point, high: Point, step_m: f64, angle_rad: f64) -> Self {
        let exact = |value: f64| if (value - value.round()).abs() < 1e-12 { value.round() } else { value };
        let along = Vector::new(exact(angle_rad.cos()), exact(angle_rad.sin()));
        let across = Vector::new(-along.y, along.x);
        let corners = [low, Point::new(high.x, low.y), high, Point::new(low.x, high.y)];
        let spread = |axis: Vector| {
            let places = corners.map(|corner| corner.coords.dot(&axis));
            places.into_iter().fold((f64::MAX, f64::MIN), |(least, most), at| (least.min(at), most.max(at)))
        };
        let ((left, right), (bottom, top)) = (spread(along), spread(across));
        let count = |length: f64| (length / step_m - 1e-6).ceil().max(1.0) as usize;
        let corner = Point::from(along * left + across * bottom);
        Self { corner, along, step_m, columns: count(right - left), rows: count(top - bottom) }
    }

    /// Side of a square, metres.
    pub(super) fn step_m(&self) -> f64 {
        self.step_m
    }

    /// Centre of a square.
    pub(super) fn place(&self, column: u32, row: u32) -> Point {
        self.point(f64::from(column) + 0.5, f64::from(row) + 0.5)
    }

    /// The point so many squares along and across.
    pub(super) fn point(&self, along: f64, across: f64) -> Point {
        self.corner + (self.along * along + Vector::new(-self.along.y, self.along.x) * across) * self.step_m
    }

    /// Number of the square that holds a point, if it is one of ours.
    fn index_at(&self, point: Point) -> Option<usize> {
        let way = point - self.corner;
        let across = Vector::new(-self.along.y, self.along.x);
        let column = (way.dot(&self.along) / self.step_m + 1e-9).floor();
        let row = (way.dot(&across) / self.step_m + 1e-9).floor();
        let inside = column >= 0.0 && row >= 0.0 && column < self.columns as f64 && row < self.rows as f64;
        inside.then(|| row as usize * self.columns + column as usize)
    }
}

/// Squares with labels.
#[derive(Debug, Clone)]
pub(super) struct Raster {
    frame: Frame,
    labels: Vec<u32>,
}

/// Squares of one row and one label, side by side: columns `from..to`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Run {
    pub(super) from: u32,
    pub(super) to: u32,
    pub(super) label: u32,
}

impl Run {
    pub(super) fn length(&self) -> u32 {
        self.to - self.from
    }

    pub(super) fn touches(&self, other: &Self) -> bool {
        self.from < other.to && other.from < self.to
    }
}

impl Raster {
    /// Squares with the labels that their centres have.
    pub(super) fn new(frame: Frame, label: impl Fn(Point) -> u32) -> Self {
        let squares = (0..frame.rows as u32)
            .flat_map(|row| (0..frame.columns as u32).map(move |column| frame.place(column, row)));
        Self { labels: squares.map(label).collect(), frame }
    }

    pub(super) fn frame(&self) -> &Frame {
        &self.frame
    }

    pub(super) fn columns(&self) -> usize {
        self.frame.columns
    }

    pub(super) fn rows(&self) -> usize {
        self.frame.rows
    }

    pub(super) fn labels(&self) -> &[u32] {
        &self.labels
    }

    pub(super) fn labels_mut(&mut self) -> &mut [u32] {
        &mut self.labels
    }

    /// Label of the square that holds a point.
    pub(super) fn label_at(&self, point: Point) -> u32 {
        self.frame.index_at(point).map_or(NONE, |index| self.labels[index])
    }

    /// Label of a square; NONE outside.
    pub(super) fn label(&self, column: i64, row: i64) -> u32 {
        let inside =
            column >= 0 && row >= 0 && column < self.frame.columns as i64 && row < self.frame.rows as i64;
        if inside { self.labels[row as usize * self.frame.columns + column as usize] } else { NONE }
    }

    /// The same ground in rows at another angle, nearest square by nearest square.
    pub(super) fn turned(&self, angle_rad: f64) -> Self {
        let (low, high) = self.bounds();
        Self::new(Frame::around(low, high, self.frame.step_m, angle_rad), |point| self.label_at(point))
    }

    /// Corners of the box in the map frame that holds everything labelled.
    fn bounds(&self) -> (Point, Point) {
        let (mut low, mut high) = (Vector::repeat(f64::MAX), Vector::repeat(f64::MIN));
        for (row, slice) in self.slices().iter().enumerate() {
            for run in slice {
                for column in [run.from, run.to - 1] {
                    let place = self.frame.place(column, row as u32).coords;
                    (low, high) = (low.inf(&place), high.sup(&place));
                }
            }
        }
        if low.x > high.x {
            return (self.frame.corner, self.frame.corner);
        }
        // Along the axes, corners of squares fall on corners of squares.
        let half = Vector::repeat(self.frame.step_m / 2.0);
        (Point::from(low - half), Point::from(high + half))
    }

    /// Per row, the runs of one label each, left to right.
    pub(super) fn slices(&self) -> Vec<Vec<Run>> {
        self.labels.chunks(self.frame.columns).map(slice).collect()
    }
}

fn slice(row: &[u32]) -> Vec<Run> {
    let mut runs = Vec::new();
    let mut from = 0;
    for to in 1..=row.len() {
        if to == row.len() || row[to] != row[from] {
            if row[from] != NONE {
                runs.push(Run { from: from as u32, to: to as u32, label: row[from] });
            }
            from = to;
        }
    }
    runs
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

    /// Squares of side 1 from a drawing, first line on top: digits are labels.
    pub(in super::super) fn drawn(drawing: &str) -> Raster {
        let lines: Vec<&str> = drawing.lines().map(str::trim).filter(|line| !line.is_empty()).rev().collect();
        let high = Point::new(lines[0].len() as f64, lines.len() as f64);
        Raster::new(Frame::around(Point::origin(), high, 1.0, 0.0), |point| {
            lines[point.y as usize].chars().nth(point.x as usize).unwrap().to_digit(10).unwrap_or(NONE)
        })
    }

    #[test]
    fn a_quarter_turn_keeps_every_square() {
        let ground = drawn("0..1\n0001\n....");
        let turned = ground.turned(FRAC_PI_2);
        assert_eq!((turned.columns(), turned.rows()), (2, 4));
        assert_eq!(turned.slices()[3], [Run { from: 0, to: 2, label: 0 }], "the left column comes last");
        assert_eq!(turned.slices()[0], [Run { from: 0, to: 2, label: 1 }]);
        assert_eq!(turned.turned(0.0).slices(), drawn("0..1\n0001").slices());
    }

    #[test]
    fn turning_keeps_the_area() {
        let ground = drawn(&vec!["0".repeat(40); 40].join("\n"));
        let turned = ground.turned(FRAC_PI_4);
        let area = turned.labels().iter().filter(|&&label| label == 0).count();
        assert!((1520..1680).contains(&area), "{area}");
    }
}
