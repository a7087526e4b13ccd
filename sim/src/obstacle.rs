//! Things on the floor that no map knows: pallets, spills, people.

use protocol::{Timestamp, v1};
use terrain::{Point, Segment};

/// The outline of an obstacle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Shape {
    /// A disc.
    Disc {
        /// Its middle, metres.
        x_m: f64,
        /// Its middle, metres.
        y_m: f64,
        /// Its radius, metres.
        radius_m: f64,
    },
    /// A rectangle, parallel to the axes.
    Rectangle {
        /// Its middle, metres.
        x_m: f64,
        /// Its middle, metres.
        y_m: f64,
        /// Its size along x, metres.
        width_m: f64,
        /// Its size along y, metres.
        height_m: f64,
    },
}

impl Shape {
    /// Its middle.
    pub(crate) fn centre(&self) -> Point {
        match *self {
            Self::Disc { x_m, y_m, .. } | Self::Rectangle { x_m, y_m, .. } => Point::new(x_m, y_m),
        }
    }

    /// No part of it is farther from its middle than this, metres.
    pub(crate) fn reach_m(&self) -> f64 {
        match *self {
            Self::Disc { radius_m, .. } => radius_m,
            Self::Rectangle { width_m, height_m, .. } => width_m.hypot(height_m) / 2.0,
        }
    }

    /// Distance from a point to its outline, metres; 0 inside.
    pub(crate) fn distance_m(&self, point: Point) -> f64 {
        let from = point - self.centre();
        match *self {
            Self::Disc { radius_m, .. } => (from.norm() - radius_m).max(0.0),
            Self::Rectangle { width_m, height_m, .. } => {
                (from.x.abs() - width_m / 2.0).max(0.0).hypot((from.y.abs() - height_m / 2.0).max(0.0))
            }
        }
    }

    /// Shortest distance from a straight way to it, metres; 0 when the way enters it.
    pub(crate) fn distance_to_way_m(&self, way: Segment) -> f64 {
        if let Self::Disc { radius_m, .. } = *self {
            return (way.distance_to_point(self.centre()) - radius_m).max(0.0);
        }
        let ends = self.distance_m(way.from).min(self.distance_m(way.to));
        if ends == 0.0 || way.from == way.to {
            return ends;
        }
        let corners = self.corners();
        (0..4).map(|at| way.distance(&Segment::new(corners[at], corners[(at + 1) % 4]))).fold(ends, f64::min)
    }

    fn corners(&self) -> [Point; 4] {
        let (Self::Disc { x_m, y_m, .. } | Self::Rectangle { x_m, y_m, .. }) = *self;
        let (x, y) = self.half_m();
        [
            Point::new(x_m - x, y_m - y),
            Point::new(x_m + x, y_m - y),
            Point::new(x_m + x, y_m + y),
            Point::new(x_m - x, y_m + y),
        ]
    }

    fn half_m(&self) -> (f64, f64) {
        match *self {
            Self::Disc { radius_m, .. } => (radius_m, radius_m),
            Self::Rectangle { width_m, height_m, .. } => (width_m / 2.0, height_m / 2.0),
        }
    }

    /// Distance from `eye` along a unit direction to its outline, metres; infinite when the ray misses it.
    pub(crate) fn ray_m(&self, eye: Point, direction: (f64, f64)) -> f64 {
        match *self {
            Self::Disc { radius_m, .. } => ray_to_disc_m(eye, direction, self.centre(), radius_m),
            Self::Rectangle { .. } => self.ray_to_box_m(eye, direction),
        }
    }

    fn ray_to_box_m(&self, eye: Point, direction: (f64, f64)) -> f64 {
        let centre = self.centre();
        let (half_x, half_y) = self.half_m();
        let slab = |eye: f64, towards: f64, low: f64, high: f64| {
            if towards == 0.0 {
                return if eye >= low && eye <= high { (0.0, f64::INFINITY) } else { (f64::INFINITY, 0.0) };
            }
            let (a, b) = ((low - eye) / towards, (high - eye) / towards);
            (a.min(b), a.max(b))
        };
        let (in_x, out_x) = slab(eye.x, direction.0, centre.x - half_x, centre.x + half_x);
        let (in_y, out_y) = slab(eye.y, direction.1, centre.y - half_y, centre.y + half_y);
        let (enter, leave) = (in_x.max(in_y).max(0.0), out_x.min(out_y));
        if enter <= leave { enter } else { f64::INFINITY }
    }
}

/// Distance from `eye` along a unit direction to a disc, metres; infinite when the ray misses it.
pub(crate) fn ray_to_disc_m(eye: Point, direction: (f64, f64), centre: Point, radius_m: f64) -> f64 {
    let to = centre - eye;
    let along = to.x * direction.0 + to.y * direction.1;
    let aside2 = to.norm_squared() - along * along;
    let half2 = radius_m * radius_m - aside2;
    if half2 < 0.0 {
        return f64::INFINITY;
    }
    let half = half2.sqrt();
    if along + half < 0.0 { f64::INFINITY } else { (along - half).max(0.0) }
}

/// Something that stands on the floor.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Obstacle {
    pub(crate) id: String,
    pub(crate) shape: Shape,
    pub(crate) until: Option<Timestamp>,
}

impl Obstacle {
    pub(crate) fn truth(&self) -> v1::ObstacleTruth {
        let centre = self.shape.centre();
        let (half_x_m, half_y_m) = self.shape.half_m();
        let (half_x_m, half_y_m, radius_m) = match self.shape {
            Shape::Disc { radius_m, .. } => (0.0, 0.0, radius_m),
            Shape::Rectangle { .. } => (half_x_m, half_y_m, 0.0),
        };
        v1::ObstacleTruth {
            obstacle_id: self.id.clone(),
            centre: Some(v1::Point { x_m: centre.x, y_m: centre.y }),
            half_x_m,
            half_y_m,
            radius_m,
            person: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: Shape = Shape::Rectangle { x_m: 2.0, y_m: 1.0, width_m: 2.0, height_m: 1.0 };
    const DISC: Shape = Shape::Disc { x_m: 2.0, y_m: 1.0, radius_m: 0.5 };

    #[test]
    fn distances_are_to_the_outline() {
        assert!((BOX.distance_m(Point::new(0.0, 1.0)) - 1.0).abs() < 1e-12);
        assert!((BOX.distance_m(Point::new(4.0, 2.5)) - 2.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!(BOX.distance_m(Point::new(2.5, 1.2)), 0.0);
        assert!((DISC.distance_m(Point::new(2.0, 3.0)) - 1.5).abs() < 1e-12);
    }

    #[test]
    fn a_way_through_a_shape_has_no_distance_to_it() {
        let across = Segment::new(Point::new(0.0, 1.0), Point::new(5.0, 1.0));
        assert_eq!((BOX.distance_to_way_m(across), DISC.distance_to_way_m(across)), (0.0, 0.0));
        let past = Segment::new(Point::new(0.0, 2.0), Point::new(5.0, 2.0));
        assert!((BOX.distance_to_way_m(past) - 0.5).abs() < 1e-12);
        assert!((DISC.distance_to_way_m(past) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn rays_end_at_the_outline_or_miss() {
        let eye = Point::new(0.0, 1.0);
        assert!((BOX.ray_m(eye, (1.0, 0.0)) - 1.0).abs() < 1e-12);
        assert!((DISC.ray_m(eye, (1.0, 0.0)) - 1.5).abs() < 1e-12);
        assert!(BOX.ray_m(eye, (-1.0, 0.0)).is_infinite());
        assert!(DISC.ray_m(eye, (0.0, 1.0)).is_infinite());
    }
}
