//! A straight piece of a path, and distances to it.

use crate::{Point, Vector};

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

    /// The part of the horizontal line at height `y_m` that is within `radius_m` of the segment, as x from and to, metres: an
    /// interval, since all that is within is convex.
    pub fn within_at(&self, radius_m: f64, y_m: f64) -> Option<(f64, f64)> {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut join = |a: f64, b: f64| {
            low = low.min(a);
            high = high.max(b);
        };
        for end in [self.from, self.to] {
            let half2 = radius_m * radius_m - (y_m - end.y).powi(2);
            if half2 >= 0.0 {
                join(end.x - half2.sqrt(), end.x + half2.sqrt());
            }
        }
        // The corners of the band between the two discs; its edges cross the line between them.
        let way = self.to - self.from;
        let length_m = way.norm();
        if length_m > 1e-12 {
            let aside = Vector::new(-way.y, way.x) * (radius_m / length_m);
            let corners = [self.from + aside, self.to + aside, self.to - aside, self.from - aside];
            for number in 0..4 {
                let (a, b) = (corners[number], corners[(number + 1) % 4]);
                if (a.y - y_m) * (b.y - y_m) <= 0.0 {
                    if (a.y - b.y).abs() < 1e-12 {
                        join(a.x.min(b.x), a.x.max(b.x));
                    } else {
                        let x = a.x + (b.x - a.x) * ((y_m - a.y) / (b.y - a.y));
                        join(x, x);
                    }
                }
            }
        }
        (low <= high).then_some((low, high))
    }

    fn crosses(&self, other: &Self) -> bool {
        let side = |a: Point, b: Point, c: Point| (b - a).perp(&(c - a));
        side(self.from, self.to, other.from) * side(self.from, self.to, other.to) < 0.0
            && side(other.from, other.to, self.from) * side(other.from, other.to, self.to) < 0.0
    }
}
