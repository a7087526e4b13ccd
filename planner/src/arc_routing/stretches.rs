//! Stretches: what has to be driven.

use crate::Instance;
use terrain::{Point, Vector};

/// A line to be driven in one direction or the other.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Stretch {
    /// At least one.
    pub(crate) points: Vec<Point>,
    /// Time from end to end, seconds.
    pub(crate) inner_s: f64,
}

impl Stretch {
    pub(crate) fn new(instance: &Instance<'_>, points: Vec<Point>) -> Self {
        let inner_s = instance.path_s(&points, None);
        Self { points, inner_s }
    }

    /// Its points from one of its ends on; even ends are first points.
    pub(crate) fn entered_at(&self, end: u32) -> Vec<Point> {
        let mut points = self.points.clone();
        if end % 2 == 1 {
            points.reverse();
        }
        points
    }

    /// Where an end is, and the direction (of length 1, or 0 where there is none) in which it is left there.
    pub(crate) fn leaves_at(&self, end: u32) -> (Point, Vector) {
        let points = self.entered_at(end ^ 1);
        let last = points.len() - 1;
        let step = points[last] - points[last.saturating_sub(1)];
        (points[last], step.try_normalize(1e-9).unwrap_or_default())
    }
}

/// A line in parts, straight ones of the same length, none of them longer than `most_m`. A short line is one part.
pub(crate) fn in_parts(instance: &Instance<'_>, points: &[Point], most_m: f64) -> Vec<Stretch> {
    let length_m: f64 = points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
    if length_m <= most_m || points.len() < 2 {
        return vec![Stretch::new(instance, points.to_vec())];
    }
    points.windows(2).flat_map(|pair| straight_in_parts(instance, pair[0], pair[1], most_m)).collect()
}

fn straight_in_parts(instance: &Instance<'_>, from: Point, to: Point, most_m: f64) -> Vec<Stretch> {
    let step = to - from;
    let parts = (step.norm() / most_m).ceil().max(1.0) as u32;
    let at = |part: u32| from + step * (f64::from(part) / f64::from(parts));
    (0..parts).map(|part| Stretch::new(instance, vec![at(part), at(part + 1)])).collect()
}
