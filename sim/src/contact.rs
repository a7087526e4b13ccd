//! Who touches whom: exact for discs that move along straight lines within one step.

use terrain::{Point, Segment};

/// The least distance between two points that both move evenly along their ways, and whether they come nearer.
pub(crate) fn least_distance_m(a: Segment, b: Segment) -> f64 {
    let apart = a.from - b.from;
    let drift = (a.to - a.from) - (b.to - b.from);
    let speed2 = drift.norm_squared();
    if speed2 == 0.0 {
        return apart.norm();
    }
    let when = (-apart.dot(&drift) / speed2).clamp(0.0, 1.0);
    (apart + drift * when).norm()
}

/// Two things that touch; reported once until they part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Touch {
    Robots(usize, usize),
    Wall(usize),
    Obstacle(usize, usize),
    Person(usize, usize),
}

/// The touches that were reported and still last.
#[derive(Debug, Clone, Default)]
pub(crate) struct Touches {
    lasting: Vec<Touch>,
}

impl Touches {
    /// Whether this touch is a new one.
    pub(crate) fn begin(&mut self, touch: Touch) -> bool {
        let new = !self.lasting.contains(&touch);
        if new {
            self.lasting.push(touch);
        }
        new
    }

    /// Forgets the touches that do not last.
    pub(crate) fn part(&mut self, lasts: impl FnMut(&Touch) -> bool) {
        self.lasting.retain(lasts);
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.lasting.is_empty()
    }
}

/// Where two discs meet: between their middles.
pub(crate) fn midpoint(a: Point, b: Point) -> Point {
    nalgebra::center(&a, &b)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn way(x0: f64, y0: f64, x1: f64, y1: f64) -> Segment {
        Segment::new(Point::new(x0, y0), Point::new(x1, y1))
    }

    #[test]
    fn two_that_cross_at_the_same_time_meet() {
        assert!(least_distance_m(way(0.0, 0.0, 2.0, 0.0), way(1.0, -1.0, 1.0, 1.0)) < 1e-12);
    }

    #[test]
    fn two_that_cross_one_after_the_other_do_not() {
        let gap = least_distance_m(way(0.0, 0.0, 2.0, 0.0), way(2.0, -2.0, 2.0, 0.0));
        assert!((gap - 0.0).abs() < 1e-12);
        let gap = least_distance_m(way(0.0, 0.0, 2.0, 0.0), way(1.0, -3.0, 1.0, -1.0));
        assert!(gap > 0.9);
    }

    #[test]
    fn a_touch_is_new_once_until_it_ends() {
        let mut touches = Touches::default();
        assert!(touches.begin(Touch::Wall(1)) && !touches.begin(Touch::Wall(1)));
        touches.part(|_| false);
        assert!(touches.begin(Touch::Wall(1)));
    }
}
