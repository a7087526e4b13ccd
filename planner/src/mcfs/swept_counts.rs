//! How often each small square of the ground is swept: lines can be put in and taken out again.

use geo::{BoundingRect, Coord, LinesIter, Polygon};
use terrain::{Point, Segment, Vector};

/// Squares across the tool.
const SQUARES: f64 = 8.0;
/// The most squares in all; larger ground gets larger squares.
const SQUARES_MAX: f64 = 16e6;

/// Counts over the bounding box of a polygon. Squares outside the polygon are taken as swept once for good.
pub(super) struct SweptCounts {
    low: Point,
    square_m: f64,
    squares_per_m: f64,
    columns: usize,
    rows: usize,
    radius_m: f64,
    counts: Vec<u16>,
    unswept: i64,
    ground: i64,
}

impl SweptCounts {
    pub(super) fn new(ground: &Polygon<f64>, width_m: f64) -> Self {
        let bounds = ground.bounding_rect().expect("a checked polygon has corners");
        let least_m = (bounds.width() * bounds.height() / SQUARES_MAX).sqrt();
        let square_m = (width_m / SQUARES).max(least_m);
        let count = |length: f64| (length / square_m).ceil() as usize + 1;
        let (columns, rows) = (count(bounds.width()), count(bounds.height()));
        let low = Point::new(bounds.min().x, bounds.min().y);
        let mut counts = Self {
            low,
            square_m,
            squares_per_m: 1.0 / square_m,
            columns,
            rows,
            radius_m: width_m / 2.0,
            counts: vec![1; columns * rows],
            unswept: 0,
            ground: 0,
        };
        counts.open(ground);
        counts
    }

    /// Marks the squares whose middles lie inside as unswept.
    fn open(&mut self, ground: &Polygon<f64>) {
        let mut crossings: Vec<Vec<f64>> = vec![Vec::new(); self.rows];
        for edge in ground.lines_iter() {
            self.add_crossings(edge.start, edge.end, &mut crossings);
        }
        for (row, mut crossings) in crossings.into_iter().enumerate() {
            crossings.sort_by(f64::total_cmp);
            for pair in crossings.chunks_exact(2) {
                let (from, to) = (self.column_right_of(pair[0]), self.column_right_of(pair[1]));
                self.counts[row * self.columns + from..row * self.columns + to].fill(0);
                self.unswept += (to - from) as i64;
            }
        }
        self.ground = self.unswept;
    }

    fn add_crossings(&self, start: Coord<f64>, end: Coord<f64>, crossings: &mut [Vec<f64>]) {
        let (low, high) = if start.y <= end.y { (start, end) } else { (end, start) };
        for (row, crossings) in crossings.iter_mut().enumerate().skip(self.row_above(low.y)) {
            let y = self.low.y + (row as f64 + 0.5) * self.square_m;
            if y >= high.y {
                break;
            }
            crossings.push(low.x + (high.x - low.x) * (y - low.y) / (high.y - low.y));
        }
    }

    /// The first row whose middle is not below `y`.
    fn row_above(&self, y: f64) -> usize {
        ceil((y - self.low.y) * self.squares_per_m - 0.5)
    }

    /// The first column whose middle is not left of `x`.
    fn column_right_of(&self, x: f64) -> usize {
        ceil((x - self.low.x) * self.squares_per_m - 0.5).min(self.columns)
    }

    /// Share of the ground that is swept.
    pub(super) fn coverage(&self) -> f64 {
        1.0 - self.unswept as f64 / self.ground.max(1) as f64
    }

    pub(super) fn unswept_m2(&self) -> f64 {
        self.unswept as f64 * self.square_m * self.square_m
    }

    /// Ground that several of the lines sweep, square metres.
    pub(super) fn shared_m2(ground: &Polygon<f64>, width_m: f64, lines: &[Vec<Point>]) -> f64 {
        const OUTSIDE: u16 = 1;
        const SEVERAL: u16 = u16::MAX;
        // The counts hold who sweeps a square.
        let mut owners = Self::new(ground, width_m);
        let mut shared = 0_u32;
        for (line, own) in lines.iter().zip(OUTSIDE + 1..SEVERAL) {
            for pair in line.windows(2) {
                owners.each_span(Segment::new(pair[0], pair[1]), |span| {
                    for owner in span {
                        if *owner == 0 {
                            *owner = own;
                        } else if ![own, OUTSIDE, SEVERAL].contains(owner) {
                            *owner = SEVERAL;
                            shared += 1;
                        }
                    }
                });
            }
        }
        f64::from(shared) * owners.square_m * owners.square_m
    }

    /// The connected pieces of ground that nothing sweeps, of at least so much area: the middles of their squares.
    pub(super) fn gaps(&self, least_m2: f64) -> Vec<Vec<Point>> {
        let mut seen = vec![false; self.counts.len()];
        let least = (least_m2 / (self.square_m * self.square_m)) as usize;
        let mut gaps = Vec::new();
        for first in 0..self.counts.len() {
            if self.counts[first] == 0 && !seen[first] {
                let gap = self.piece(first, &mut seen);
                if gap.len() >= least {
                    gaps.push(gap.into_iter().map(|square| self.middle(square)).collect());
                }
            }
        }
        gaps
    }

    /// The unswept squares that hang together with one.
    fn piece(&self, first: usize, seen: &mut [bool]) -> Vec<usize> {
        let mut piece = vec![first];
        seen[first] = true;
        let mut next = 0;
        while let Some(&square) = piece.get(next) {
            next += 1;
            let (column, row) = (square % self.columns, square / self.columns);
            let beside = [
                (column > 0).then(|| square - 1),
                (column + 1 < self.columns).then(|| square + 1),
                (row > 0).then(|| square - self.columns),
                (row + 1 < self.rows).then(|| square + self.columns),
            ];
            for other in beside.into_iter().flatten() {
                if self.counts[other] == 0 && !seen[other] {
                    seen[other] = true;
                    piece.push(other);
                }
            }
        }
        piece
    }

    fn middle(&self, square: usize) -> Point {
        let (column, row) = ((square % self.columns) as f64, (square / self.columns) as f64);
        self.low + Vector::new(column + 0.5, row + 0.5) * self.square_m
    }

    pub(super) fn put_in(&mut self, from: Point, to: Point) {
        let mut newly = 0;
        self.each_span(Segment::new(from, to), |span| {
            for count in span {
                newly += i64::from(*count == 0);
                *count += 1;
            }
        });
        self.unswept -= newly;
    }

    pub(super) fn take_out(&mut self, from: Point, to: Point) {
        let mut lost = 0;
        self.each_span(Segment::new(from, to), |span| {
            for count in span {
                *count -= 1;
                lost += i64::from(*count == 0);
            }
        });
        self.unswept += lost;
    }

    /// The squares under the disc along a segment, row by row.
    fn each_span(&mut self, segment: Segment, mut each: impl FnMut(&mut [u16])) {
        let capsule = Capsule::new(segment, self.radius_m);
        let (low_y, high_y) = (capsule.low.y - self.radius_m, capsule.high.y + self.radius_m);
        let (first, end) = (self.row_above(low_y), self.row_above(high_y).min(self.rows));
        for row in first..end {
            let y = self.low.y + (row as f64 + 0.5) * self.square_m;
            let (left, right) = capsule.span_at(y);
            let (from, to) = (self.column_right_of(left), self.column_right_of(right));
            let start = row * self.columns;
            each(&mut self.counts[start + from..start + to.max(from)]);
        }
    }
}

/// What a disc sweeps along a segment: half discs around its ends, and straight sides between them.
struct Capsule {
    /// The lower end; of a level segment the left one.
    low: Point,
    high: Point,
    /// From the middle line to the left side.
    to_left: Vector,
    /// How far a side goes to the right for each metre up.
    slope: f64,
    radius_m: f64,
}

impl Capsule {
    fn new(segment: Segment, radius_m: f64) -> Self {
        let Segment { from, to } = segment;
        let (low, high) = if (from.y, from.x) <= (to.y, to.x) { (from, to) } else { (to, from) };
        let along = high - low;
        let unit = along.try_normalize(1e-12).unwrap_or_else(Vector::x);
        let slope = if along.y > 0.0 { along.x / along.y } else { 0.0 };
        Self { low, high, to_left: Vector::new(-unit.y, unit.x) * radius_m, slope, radius_m }
    }

    /// Where the line at a height between `low.y` − radius and `high.y` + radius enters and leaves.
    fn span_at(&self, y: f64) -> (f64, f64) {
        let half_m = |end: Point| (self.radius_m * self.radius_m - (y - end.y) * (y - end.y)).max(0.0).sqrt();
        let side = |to_side: Vector, sign: f64| {
            if y < self.low.y + to_side.y {
                self.low.x + sign * half_m(self.low)
            } else if y > self.high.y + to_side.y {
                self.high.x + sign * half_m(self.high)
            } else {
                self.low.x + to_side.x + (y - self.low.y - to_side.y) * self.slope
            }
        };
        (side(self.to_left, -1.0), side(-self.to_left, 1.0))
    }
}

/// The least whole number that is no less; 0 for what is below.
fn ceil(value: f64) -> usize {
    let whole = value.max(0.0) as usize;
    whole + usize::from(value > whole as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The span of a capsule against the distance to its segment.
        #[test]
        fn a_span_holds_what_is_near_its_segment(
            ends in prop::array::uniform4(-2_i32..3), down in 0_u32..21, across in -60_i32..61,
        ) {
            let ends = ends.map(f64::from);
            let segment = Segment::new(Point::new(ends[0], ends[1]), Point::new(ends[2], ends[3]));
            let (low_y, high_y) = (ends[1].min(ends[3]) - 1.0, ends[1].max(ends[3]) + 1.0);
            let y = low_y + (high_y - low_y) * f64::from(down) / 20.0;
            let (left, right) = Capsule::new(segment, 1.0).span_at(y);
            let x = 0.05 * f64::from(across) + 1e-3;
            let distance = segment.distance_to_point(Point::new(x, y));
            prop_assume!((distance - 1.0).abs() > 1e-6);
            prop_assert_eq!(distance < 1.0, left < x && x < right, "{} {} {}", left, x, right);
        }
    }
}
