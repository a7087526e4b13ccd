//! A map as it is given: squares that are free or not.

use crate::{Point, Segment};
use thiserror::Error;

/// The most squares a map may have; checked before anything is allocated.
pub const SQUARES_MAX: u64 = 64 << 20;

/// A map of squares that are free or blocked. Everything outside is blocked.
#[derive(Debug, Clone, PartialEq)]
pub struct GridMap {
    columns: u32,
    rows: u32,
    resolution_m: f64,
    origin: Point,
    free: Vec<bool>,
}

/// Why a map could not be read.
#[derive(Debug, Clone, Error, PartialEq)]
pub enum MapError {
    /// The text or picture breaks the format at this line (1 = first; 0 = the file as a whole).
    #[error("{}{what}", at_line(*line))]
    Format {
        /// Line in the file, from 1; 0 when the file as a whole is meant.
        line: usize,
        /// What is wrong, and what was expected.
        what: String,
    },
    /// A polygon whose rings bound no ground.
    #[error("polygon {polygon}: {source}")]
    Rings {
        /// Number of the polygon in the file, from 0.
        polygon: usize,
        /// What is wrong with it.
        source: crate::RingError,
    },
    /// The map has more squares than we take.
    #[error("the map has {columns} x {rows} squares; at most {SQUARES_MAX} are taken")]
    TooLarge {
        /// Width in squares.
        columns: u64,
        /// Height in squares.
        rows: u64,
    },
    /// A size, resolution or origin that is not a finite (positive) number.
    #[error("`{key}` is {value}: {expected}")]
    Value {
        /// The key in the file or option.
        key: &'static str,
        /// What it said.
        value: String,
        /// What was expected.
        expected: &'static str,
    },
    /// There is no free square.
    #[error("the map has no free square")]
    NothingFree,
}

fn at_line(line: usize) -> String {
    if line == 0 { String::new() } else { format!("line {line}: ") }
}

impl GridMap {
    /// A map from squares, row by row from the bottom; `resolution_m` is the side of a square, `origin` the
    /// lower left corner of the first one.
    ///
    /// # Errors
    ///
    /// [`MapError::TooLarge`], and [`MapError::Value`] when a number is not finite or not positive.
    pub fn new(
        columns: u32,
        rows: u32,
        resolution_m: f64,
        origin: Point,
        free: Vec<bool>,
    ) -> Result<Self, MapError> {
        Self::check_size(u64::from(columns), u64::from(rows))?;
        if !(resolution_m.is_finite() && resolution_m > 0.0) {
            return Err(MapError::Value {
                key: "resolution",
                value: resolution_m.to_string(),
                expected: "the side of a square in metres, a finite number above 0",
            });
        }
        if !(origin.x.is_finite() && origin.y.is_finite()) {
            return Err(MapError::Value {
                key: "origin",
                value: format!("{}, {}", origin.x, origin.y),
                expected: "two finite numbers in metres",
            });
        }
        assert_eq!(free.len(), columns as usize * rows as usize, "one value per square");
        Ok(Self { columns, rows, resolution_m, origin, free })
    }

    /// Refuses sizes above the limit; to be called before anything is allocated.
    ///
    /// # Errors
    ///
    /// [`MapError::TooLarge`].
    pub fn check_size(columns: u64, rows: u64) -> Result<(), MapError> {
        match columns.checked_mul(rows) {
            Some(squares) if squares > 0 && squares <= SQUARES_MAX => Ok(()),
            _ => Err(MapError::TooLarge { columns, rows }),
        }
    }

    /// Width in squares.
    pub fn columns(&self) -> u32 {
        self.columns
    }

    /// Height in squares.
    pub fn rows(&self) -> u32 {
        self.rows
    }

    /// Side of a square, metres.
    pub fn resolution_m(&self) -> f64 {
        self.resolution_m
    }

    /// Lower left corner, metres.
    pub fn origin(&self) -> Point {
        self.origin
    }

    /// Upper right corner, metres.
    pub fn corner(&self) -> Point {
        Point::new(
            self.origin.x + f64::from(self.columns) * self.resolution_m,
            self.origin.y + f64::from(self.rows) * self.resolution_m,
        )
    }

    /// Whether the square in column `x` and row `y` (from the bottom) is free; outside nothing is.
    pub fn is_free(&self, x: i64, y: i64) -> bool {
        x >= 0
            && y >= 0
            && x < i64::from(self.columns)
            && y < i64::from(self.rows)
            && self.free[y as usize * self.columns as usize + x as usize]
    }

    /// Whether all squares of row `y` from column `first` to column `last` are free.
    pub fn row_is_free(&self, y: i64, first: i64, last: i64) -> bool {
        let (columns, rows) = (i64::from(self.columns), i64::from(self.rows));
        if first > last {
            return true;
        }
        if y < 0 || y >= rows || first < 0 || last >= columns {
            return false;
        }
        let begin = (y * columns) as usize;
        self.free[begin + first as usize..=begin + last as usize].iter().all(|&free| free)
    }

    /// Whether the point lies in a free square.
    pub fn point_is_free(&self, point: Point) -> bool {
        let (x, y) = self.square_at(point);
        self.is_free(x, y)
    }

    /// Column and row of the square that holds a point (may be outside).
    pub fn square_at(&self, point: Point) -> (i64, i64) {
        (
            ((point.x - self.origin.x) / self.resolution_m).floor() as i64,
            ((point.y - self.origin.y) / self.resolution_m).floor() as i64,
        )
    }

    /// Free area, square metres.
    pub fn free_area_m2(&self) -> f64 {
        self.free.iter().filter(|&&free| free).count() as f64 * self.resolution_m * self.resolution_m
    }

    /// Whether a disc touches no blocked square (touching the edge alone is allowed). Exact.
    pub fn disc_is_free(&self, center: Point, radius_m: f64) -> bool {
        self.capsule_is_free(Segment::new(center, center), radius_m)
    }

    /// Whether everything nearer than `radius_m` to the segment is free. Exact.
    pub fn capsule_is_free(&self, segment: Segment, radius_m: f64) -> bool {
        // The box around a long slanting segment is large: look along pieces of it.
        let pieces = (segment.length() / (16.0 * self.resolution_m)).ceil().clamp(1.0, 1e6);
        let at = |piece: f64| segment.from + (segment.to - segment.from) * (piece / pieces);
        (0..pieces as u32).map(f64::from).all(|piece| {
            let part = Segment::new(at(piece), at(piece + 1.0));
            self.blocked_squares_near(part, radius_m).next().is_none()
        })
    }

    /// The blocked squares (column, row; also outside the map) nearer than `radius_m` to the segment.
    pub fn blocked_squares_near(
        &self,
        segment: Segment,
        radius_m: f64,
    ) -> impl Iterator<Item = (i64, i64)> + '_ {
        let low = segment.from.coords.inf(&segment.to.coords).add_scalar(-radius_m);
        let high = segment.from.coords.sup(&segment.to.coords).add_scalar(radius_m);
        let (x0, y0) = self.square_at(Point::from(low));
        let (x1, y1) = self.square_at(Point::from(high));
        let slack = 1e-9;
        (y0..=y1)
            .flat_map(move |y| (x0..=x1).map(move |x| (x, y)))
            .filter(move |&(x, y)| !self.is_free(x, y))
            .filter(move |&(x, y)| self.distance_to_square(segment, x, y) < radius_m - slack)
    }

    fn distance_to_square(&self, segment: Segment, x: i64, y: i64) -> f64 {
        let low = self.origin + crate::Vector::new(x as f64, y as f64) * self.resolution_m;
        let high = low + crate::Vector::new(self.resolution_m, self.resolution_m);
        let outside = |p: Point| {
            let dx = (low.x - p.x).max(p.x - high.x).max(0.0);
            let dy = (low.y - p.y).max(p.y - high.y).max(0.0);
            dx.hypot(dy)
        };
        if segment.from == segment.to {
            return outside(segment.from);
        }
        let corners = [low, Point::new(high.x, low.y), high, Point::new(low.x, high.y)];
        let to_ends = outside(segment.from).min(outside(segment.to));
        (0..4)
            .map(|i| segment.distance(&Segment::new(corners[i], corners[(i + 1) % 4])))
            .fold(to_ends, f64::min)
    }

    /// A map drawn as text, first line on top: `.` free, anything else blocked. For tests and examples.
    ///
    /// # Errors
    ///
    /// [`MapError::Format`] when lines differ in length.
    pub fn from_drawing(drawing: &str, resolution_m: f64) -> Result<Self, MapError> {
        let lines: Vec<&str> = drawing.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
        let columns = lines.first().map_or(0, |line| line.len());
        if let Some(at) = lines.iter().position(|line| line.len() != columns) {
            return Err(MapError::Format { line: at + 1, what: format!("expected {columns} characters") });
        }
        let free = lines.iter().rev().flat_map(|line| line.bytes().map(|byte| byte == b'.')).collect();
        Self::new(columns as u32, lines.len() as u32, resolution_m, Point::origin(), free)
    }
}
