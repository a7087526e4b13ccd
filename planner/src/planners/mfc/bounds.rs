//! Which bounds are tried: bisection, in steps that the even share of the work gives.
//!
//! The paper's binary search ends at the smallest bound that has a cover. Most of its last probes split as the one before
//! did, so here bounds are multiples of a part of an even share, and closer ones are tried only as long as the
//! guarantee needs them: until no cover can weigh less than a quarter of the best one found.

/// Bounds are multiples of an even share of the work over this: of 8 % of a share.
const PARTS: f64 = 12.5;

/// The bracket of a bisection.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    /// No cover weighs so little.
    low: f64,
    /// A cover has been found.
    high: f64,
    unit: f64,
    closest: f64,
}

impl Bounds {
    /// For trees with edges of these weights, shared by so many robots.
    pub(super) fn new(weights: impl Iterator<Item = f64> + Clone, robots: usize) -> Self {
        let (all, heaviest) =
            weights.clone().fold((0.0, 0.0), |(all, most): (f64, f64), w| (all + w, most.max(w)));
        let lightest = weights.filter(|&weight| weight > 0.0).fold(all, f64::min);
        // Closer bounds than half an edge seldom split otherwise.
        let closest = lightest.max(1e-6 * all) / 2.0;
        let unit = closest.max(all / robots as f64 / PARTS);
        // With the first bound everything is left over at the roots.
        let high = ((2.0 * all / unit).round() * unit).max(1.0);
        Self { low: heaviest.min(all), high, unit, closest }
    }

    /// The greatest bound: no tree is split.
    pub(super) const fn whole(self) -> f64 {
        self.high
    }

    /// The next bound, when the heaviest tree of the best cover weighs so much; none when there is no need.
    pub(super) fn next(self, best: f64) -> Option<f64> {
        let width = self.high - self.low;
        let proved = best <= 4.0 * self.low;
        if width <= self.closest || self.closest == 0.0 || proved && width < 1.5 * self.unit {
            return None;
        }
        let middle = f64::midpoint(self.low, self.high);
        let rounded = (middle / self.unit).floor() * self.unit;
        Some(if rounded > self.low && rounded < self.high { rounded } else { middle })
    }

    /// Takes note of whether there was a cover for a bound.
    pub(super) const fn narrow(&mut self, bound: f64, found: bool) {
        if found {
            self.high = bound;
        } else {
            self.low = bound;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tried(weights: &[f64], robots: usize, possible_from: f64, best: f64) -> Vec<f64> {
        let mut bounds = Bounds::new(weights.iter().copied(), robots);
        let mut tried = Vec::new();
        while let Some(bound) = bounds.next(best) {
            bounds.narrow(bound, bound >= possible_from);
            tried.push(bound);
        }
        tried
    }

    #[test]
    fn bounds_are_parts_of_a_share() {
        let tried = tried(&[1.0; 250], 4, 50.0, 100.0);
        assert!(tried.iter().all(|bound| bound % 5.0 == 0.0), "{tried:?}");
        assert!(tried.contains(&50.0) && tried.contains(&45.0), "{tried:?}");
    }

    #[test]
    fn closer_ones_until_the_guarantee_holds() {
        let tried = tried(&[1.0; 320], 4, 50.0, 198.0);
        assert!(tried.iter().any(|&bound| bound < 50.0 && 4.0 * bound >= 198.0), "{tried:?}");
    }

    #[test]
    fn nothing_to_share() {
        assert_eq!(tried(&[], 2, 0.0, 4.0), Vec::<f64>::new());
        assert_eq!(tried(&[0.0, 0.0], 2, 0.0, 4.0), Vec::<f64>::new());
    }
}
