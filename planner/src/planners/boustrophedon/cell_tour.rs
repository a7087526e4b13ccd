//! The tour over cells with a choice of entry and exit.
//!
//! The paper gives each cell three vertices, start, middle and end, so that a tour that enters a cell drives all of it, and solves
//! one travelling salesman problem by 2-opt for each of up to 2ⁿ choices of start corners. Here a stop is a cell with
//! one of four variants (two paths, forwards and backwards), which is the same set of tours:
//!
//! ```text
//!   station ─▶ [entry ≈≈ cell 3, variant 2 ≈≈ exit] ─▶ [entry ≈≈ cell 0, variant 1 ≈≈ exit] ─▶ … ─▶ station
//! ```
//!
//! - 2-opt: reversing a stretch turns each stop in it round; only two ways change.
//! - Variants: for a given order the best ones are a shortest path through layers of four, O(16 n). This stands in for
//!   the 2ⁿ choices (our departure); for a few cells all of them are tried as well, as in the paper.

use super::distances::Distances;

/// Up to so many cells, all choices of start corners are tried.
const TRY_ALL: usize = 8;
const GAIN: f64 = 1e-6;

/// A cell, and how it is driven: variant / 2 is the path, odd ones go backwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Stop {
    pub(super) cell: usize,
    pub(super) variant: usize,
}

impl Stop {
    /// Number among all ends: that of the station is `None`.
    pub(super) fn entry(self) -> usize {
        4 * self.cell + self.variant
    }

    fn exit(self) -> usize {
        4 * self.cell + (self.variant ^ 1)
    }

    fn reversed(self) -> Self {
        Self { variant: self.variant ^ 1, ..self }
    }
}

/// Lengths of ways between ends of cells and a station, and of cells' paths.
///
/// Ends are numbered 4 · cell + 2 · path + (0: where the path begins, 1: where it ends): the end with the number of a
/// variant is where that variant begins.
pub(super) struct Costs<'a> {
    pub(super) distances: &'a Distances,
    /// Number of the station among the ends.
    pub(super) station: usize,
    /// Per cell and path: length, metres.
    pub(super) inner_m: &'a [[f64; 2]],
    /// Whether the way back to the station counts.
    pub(super) returns: bool,
}

impl Costs<'_> {
    fn out_m(&self, to: Stop) -> f64 {
        self.distances.between(self.station, to.entry())
    }

    fn home_m(&self, from: Stop) -> f64 {
        if self.returns { self.distances.between(from.exit(), self.station) } else { 0.0 }
    }

    pub(super) fn way(&self, from: Option<Stop>, to: Option<Stop>) -> f64 {
        match (from, to) {
            (Some(from), Some(to)) => self.distances.between(from.exit(), to.entry()),
            (None, Some(to)) => self.out_m(to),
            (Some(from), None) => self.home_m(from),
            (None, None) => 0.0,
        }
    }

    fn inner(&self, stop: Stop) -> f64 {
        self.inner_m[stop.cell][stop.variant / 2]
    }

    /// Length of a whole tour, metres.
    pub(super) fn length_m(&self, tour: &[Stop]) -> f64 {
        let ways: f64 = tour.windows(2).map(|pair| self.way(Some(pair[0]), Some(pair[1]))).sum();
        let ends = self.way(None, tour.first().copied()) + self.way(tour.last().copied(), None);
        ways + ends + tour.iter().map(|&stop| self.inner(stop)).sum::<f64>()
    }
}

/// A short tour over all cells that are given.
pub(super) fn tour(costs: &Costs<'_>, cells: &[usize]) -> Vec<Stop> {
    let mut tour = nearest_next(costs, cells);
    loop {
        let before = costs.length_m(&tour);
        two_opt(costs, &mut tour);
        choose_variants(costs, &mut tour);
        if costs.length_m(&tour) > before - GAIN {
            break;
        }
    }
    if cells.len() > TRY_ALL {
        return tour;
    }
    let other = over_all_choices(costs, cells);
    if costs.length_m(&other) < costs.length_m(&tour) - GAIN { other } else { tour }
}

/// The nearest end next.
fn nearest_next(costs: &Costs<'_>, cells: &[usize]) -> Vec<Stop> {
    let mut left: Vec<usize> = cells.to_vec();
    let mut tour: Vec<Stop> = Vec::new();
    while !left.is_empty() {
        let last = tour.last().copied();
        let stops = left.iter().flat_map(|&cell| (0..4).map(move |variant| Stop { cell, variant }));
        let priced = stops.map(|stop| (costs.way(last, Some(stop)), stop));
        let (_, next) = priced.min_by(|a, b| a.0.total_cmp(&b.0)).expect("cells are left");
        left.retain(|&cell| cell != next.cell);
        tour.push(next);
    }
    tour
}

/// Reverses stretches while that makes the tour shorter.
fn two_opt(costs: &Costs<'_>, tour: &mut [Stop]) {
    let mut improved = true;
    while std::mem::take(&mut improved) {
        for first in 0..tour.len() {
            for last in first..tour.len() {
                if gain_of_reversal(costs, tour, first, last) > GAIN {
                    tour[first..=last].reverse();
                    tour[first..=last].iter_mut().for_each(|stop| *stop = stop.reversed());
                    improved = true;
                }
            }
        }
    }
}

fn gain_of_reversal(costs: &Costs<'_>, tour: &[Stop], first: usize, last: usize) -> f64 {
    let before = first.checked_sub(1).map(|at| tour[at]);
    let after = tour.get(last + 1).copied();
    let (one, other) = (tour[first], tour[last]);
    costs.way(before, Some(one)) + costs.way(Some(other), after)
        - costs.way(before, Some(other.reversed()))
        - costs.way(Some(one.reversed()), after)
}

/// The best variants for the order of a tour: a shortest path through layers of four.
fn choose_variants(costs: &Costs<'_>, tour: &mut [Stop]) {
    let mut reached = [0.0; 4];
    let mut came_by: Vec<[usize; 4]> = Vec::with_capacity(tour.len());
    for at in 0..tour.len() {
        let (mut next, mut by) = ([f64::INFINITY; 4], [0; 4]);
        for variant in 0..4 {
            let stop = Stop { variant, ..tour[at] };
            for (before, so_far) in reached.iter().enumerate() {
                let last = at.checked_sub(1).map(|at| Stop { variant: before, ..tour[at] });
                let length = so_far + costs.way(last, Some(stop)) + costs.inner(stop);
                if length < next[variant] {
                    (next[variant], by[variant]) = (length, before);
                }
            }
        }
        reached = next;
        came_by.push(by);
    }
    let Some(&last) = tour.last() else { return };
    let end = |variant: &usize| reached[*variant] + costs.home_m(Stop { variant: *variant, ..last });
    let mut variant = (0..4).min_by(|a, b| end(a).total_cmp(&end(b))).expect("there are four");
    for at in (0..tour.len()).rev() {
        tour[at].variant = variant;
        variant = came_by[at][variant];
    }
}

/// For each choice of paths, 2-opt over orders and directions: the paper's 2ⁿ problems.
fn over_all_choices(costs: &Costs<'_>, cells: &[usize]) -> Vec<Stop> {
    let choice = |bits: usize| {
        let stop = |(at, &cell): (usize, &usize)| Stop { cell, variant: 2 * (bits >> at & 1) };
        let mut tour: Vec<Stop> = cells.iter().enumerate().map(stop).collect();
        two_opt(costs, &mut tour);
        (costs.length_m(&tour), tour)
    };
    let tours = (0..1_usize << cells.len()).map(choice);
    tours.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, tour)| tour).unwrap_or_default()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use proptest::prelude::*;

    fn of_points(points: &[(f64, f64)]) -> Distances {
        let way = |a: &(f64, f64), b: &(f64, f64)| (a.0 - b.0).hypot(a.1 - b.1) as f32;
        let table = points.iter().flat_map(|a| points.iter().map(move |b| way(a, b))).collect();
        Distances::from_table(points.len(), table)
    }

    fn least_by_trying(costs: &Costs<'_>, done: &mut Vec<Stop>, cells: usize) -> f64 {
        if done.len() == cells {
            return costs.length_m(done);
        }
        let mut least = f64::INFINITY;
        for cell in (0..cells).filter(|&cell| done.iter().all(|stop| stop.cell != cell)).collect::<Vec<_>>() {
            for variant in 0..4 {
                done.push(Stop { cell, variant });
                least = least.min(least_by_trying(costs, done, cells));
                done.pop();
            }
        }
        least
    }

    proptest! {
        /// Four ends per cell, anywhere; the station last.
        #[test]
        fn a_tour_passes_each_cell_once_and_is_nearly_the_best(
            ends in prop::collection::vec((0.0..10.0, 0.0..10.0), 17),
            returns in any::<bool>(),
        ) {
            let distances = of_points(&ends);
            let inner_m = vec![[3.0, 4.0]; 4];
            let costs = Costs { distances: &distances, station: 16, inner_m: &inner_m, returns };
            let tour = tour(&costs, &[0, 1, 2, 3]);
            let mut cells: Vec<usize> = tour.iter().map(|stop| stop.cell).collect();
            cells.sort_unstable();
            prop_assert_eq!(cells, [0, 1, 2, 3]);
            let best = least_by_trying(&costs, &mut Vec::new(), 4);
            let found = costs.length_m(&tour);
            prop_assert!(found >= best - 1e-3 && found <= 1.3 * best, "{} {}", found, best);
        }

        #[test]
        fn no_other_variants_are_better_for_the_order(
            ends in prop::collection::vec((0.0..10.0, 0.0..10.0), 13),
        ) {
            let distances = of_points(&ends);
            let inner_m = vec![[3.0, 4.0]; 3];
            let costs = Costs { distances: &distances, station: 12, inner_m: &inner_m, returns: true };
            let mut tour: Vec<Stop> = (0..3).map(|cell| Stop { cell, variant: 0 }).collect();
            choose_variants(&costs, &mut tour);
            let chosen = costs.length_m(&tour);
            for choice in 0..64 {
                let other: Vec<Stop> =
                    (0..3).map(|cell| Stop { cell, variant: choice >> (2 * cell) & 3 }).collect();
                prop_assert!(chosen <= costs.length_m(&other) + 1e-3);
            }
        }
    }
}
