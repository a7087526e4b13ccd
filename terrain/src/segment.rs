//! A straight piece of a path, and distances to it.

use crate::Point;

/// A straight line between two points, metres. Both ends may be the same point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// One end.
    pub from: Point,
    /// The other end.
    pub to: Point,
}

impl Segment {
    /// The segment between two points.
    pub const fn new(from: Point, to: Point) -> Self {
        Self { from, to }
    }

    /// Length, metres.
    pub fn length(&self) -> f64 {
        (self.to - self.from).norm()
    }

    /// The point of the segment that is nearest to `point`.
    pub fn nearest(&self, point: Point) -> Point {
        let along = self.to - self.from;
        let length2 = along.norm_squared();
        if length2 == 0.0 {
            return self.from;
        }
        self.from + along * ((point - self.from).dot(&along) / length2).clamp(0.0, 1.0)
    }

    /// Shortest distance to a point, metres.
    pub fn distance_to_point(&self, point: Point) -> f64 {
        (self.nearest(point) - point).norm()
    }

    /// Shortest distance to another segment, metres; 0 when they cross.
    pub fn distance(&self, other: &Self) -> f64 {
        if self.crosses(other) {
            return 0.0;
        }
        self.distance_to_point(other.from)
            .min(self.distance_to_point(other.to))
            .min(other.distance_to_point(self.from))
            .min(other.distance_to_point(self.to))
    }

    fn crosses(&self, other: &Self) -> bool {
        let side = |a: Point, b: Point, c: Point| (b - a).perp(&(c - a));
        side(self.from, self.to, other.from) * side(self.from, self.to, other.to) < 0.0
            && side(other.from, other.to, self.from) * side(other.from, other.to, self.to) < 0.0
    }
}
