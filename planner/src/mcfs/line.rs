//! A line before it is smoothed: it knows which of its steps are new, for only near those there is something to smooth.

use super::smoothing::LONGEST;
use terrain::Point;

/// Points, and for each step to the next point whether it is new.
pub(super) struct Line {
    pub(super) points: Vec<Point>,
    is_new: Vec<bool>,
}

impl Line {
    /// A line that was never smoothed.
    pub(super) fn all_new(points: Vec<Point>) -> Self {
        Self { is_new: vec![true; points.len().saturating_sub(1)], points }
    }

    /// A line that is smooth already, or the start of a new one.
    pub(super) fn as_before(points: Vec<Point>) -> Self {
        Self { is_new: vec![false; points.len().saturating_sub(1)], points }
    }

    pub(super) fn go(&mut self, to: Point, is_new: bool) {
        self.points.push(to);
        self.is_new.push(is_new);
    }

    /// Goes along a way that begins where the line ends.
    pub(super) fn drive(&mut self, way: Vec<Point>) {
        way.into_iter().skip(1).for_each(|point| self.go(point, true));
    }

    /// The points from which no shortcut reaches a new step, nor the heading before or after it.
    pub(super) fn quiet(&self) -> Vec<bool> {
        let is_quiet = |at: usize| {
            let (from, to) = (at.saturating_sub(1), (at + LONGEST + 2).min(self.is_new.len()));
            !self.is_new[from.min(to)..to].contains(&true)
        };
        (0..self.points.len()).map(is_quiet).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_points_near_a_new_step_are_not_quiet() {
        let mut line = Line::as_before((0..30).map(|x| Point::new(f64::from(x), 0.0)).collect());
        line.go(Point::new(30.0, 1.0), true);
        (31..60).for_each(|x| line.go(Point::new(f64::from(x), 1.0), false));
        let busy: Vec<usize> = (0..60).filter(|&at| !line.quiet()[at]).collect();
        assert_eq!((busy[0], busy[busy.len() - 1]), (29 - LONGEST - 1, 30));
    }
}
