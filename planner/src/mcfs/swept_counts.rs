//! How often each small square of the ground is swept: lines can be put in and taken out again.

use geo::{BoundingRect, Coord, LinesIter, Polygon};
use terrain::{Point, Segment};

/// Squares across the tool.
const SQUARES: f64 = 8.0;
/// The most squares in all; larger ground gets larger squares.
const SQUARES_MAX: f64 = 16e6;

/// Counts over the bounding box of a polygon. Squares outside the polygon are taken as swept once for good.
pub(super) struct SweptCounts {
    low: Point,
    square_m: f64,
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
        ((y - self.low.y) / self.square_m - 0.5).ceil().max(0.0) as usize
    }

    /// The first column whose middle is not left of `x`.
    fn column_right_of(&self, x: f64) -> usize {
        (((x - self.low.x) / self.square_m - 0.5).ceil().max(0.0) as usize).min(self.columns)
    }

    /// Share of the ground that is swept.
    pub(super) fn coverage(&self) -> f64 {
        1.0 - self.unswept as f64 / self.ground.max(1) as f64
    }

    pub(super) fn unswept_m2(&self) -> f64 {
        self.unswept as f64 * self.square_m * self.square_m
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
        self.low + terrain::Vector::new(column + 0.5, row + 0.5) * self.square_m
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
        let (low_y, high_y) = (segment.from.y.min(segment.to.y), segment.from.y.max(segment.to.y));
        let (first, end) = (self.row_above(low_y - self.radius_m), self.row_above(high_y + self.radius_m));
        for row in first..end.min(self.rows) {
            let y = self.low.y + (row as f64 + 0.5) * self.square_m;
            let Some((left, right)) = span_at(segment, self.radius_m, y) else { continue };
            let (from, to) = (self.column_right_of(left), self.column_right_of(right));
            let start = row * self.columns;
            each(&mut self.counts[start + from..start + to.max(from)]);
        }
    }
}

/// Where the line at height `y` enters and leaves a capsule: it is convex, so there is one stretch.
fn span_at(segment: Segment, radius_m: f64, y: f64) -> Option<(f64, f64)> {
    let mut span: Option<(f64, f64)> = None;
    let mut widen = |left: f64, right: f64| {
        if left <= right {
            span = Some(span.map_or((left, right), |(low, high)| (low.min(left), high.max(right))));
        }
    };
    for end in [segment.from, segment.to] {
        let half2 = radius_m * radius_m - (y - end.y) * (y - end.y);
        if half2 >= 0.0 {
            widen(end.x - half2.sqrt(), end.x + half2.sqrt());
        }
    }
    let along = segment.to - segment.from;
    let length_m = along.norm();
    if length_m > 1e-12 {
        let unit = along / length_m;
        // Within the band: 0 ≤ x·ux + c ≤ length, and −r ≤ x·uy − d ≤ r.
        let offset = y - segment.from.y;
        let (a, b) = between(unit.x, offset * unit.y, 0.0, length_m);
        let (c, d) = between(-unit.y, offset * unit.x, -radius_m, radius_m);
        widen(segment.from.x + a.max(c), segment.from.x + b.min(d));
    }
    span
}

/// The x with `least` ≤ factor·x + constant ≤ `most`.
fn between(factor: f64, constant: f64, least: f64, most: f64) -> (f64, f64) {
    if factor.abs() < 1e-12 {
        let holds = constant >= least && constant <= most;
        return if holds { (f64::NEG_INFINITY, f64::INFINITY) } else { (1.0, -1.0) };
    }
    let (one, other) = ((least - constant) / factor, (most - constant) / factor);
    (one.min(other), one.max(other))
}
