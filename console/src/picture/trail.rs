//! The line that a robot drove, by its corners.

use terrain::{Point, Vector};

/// Points nearer than this to the last one are left out, metres.
const STEP_M: f64 = 0.05;
/// Turns smaller than this are straight on (as the sine of the angle).
const STRAIGHT: f64 = 0.03;

/// A line that grows at its end.
#[derive(Debug)]
pub(super) struct Trail {
    corners: Vec<Point>,
    end: Point,
}

impl Trail {
    pub(super) fn new(start: Point) -> Self {
        Self { corners: vec![start], end: start }
    }

    pub(super) fn add(&mut self, here: Point) {
        if (here - self.end).norm() < STEP_M {
            return;
        }
        let corner = self.corners[self.corners.len() - 1];
        if !is_straight(self.end - corner, here - self.end) {
            self.corners.push(self.end);
        }
        self.end = here;
    }

    pub(super) fn points(&self) -> impl Iterator<Item = Point> + '_ {
        self.corners.iter().copied().chain([self.end])
    }
}

fn is_straight(before: Vector, after: Vector) -> bool {
    let lengths = before.norm() * after.norm();
    lengths == 0.0 || (before.dot(&after) > 0.0 && before.perp(&after).abs() < STRAIGHT * lengths)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trail_keeps_its_corners_only() {
        let mut trail = Trail::new(Point::new(0.0, 0.0));
        for tick in 1..=20 {
            trail.add(Point::new(0.1 * f64::from(tick), 0.0));
        }
        for tick in 1..=10 {
            trail.add(Point::new(2.0, 0.1 * f64::from(tick)));
        }
        let points: Vec<Point> = trail.points().collect();
        assert_eq!(points.len(), 3);
        assert!((points[1] - Point::new(2.0, 0.0)).norm() < 1e-9);
    }
}
