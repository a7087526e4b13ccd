//! The places at which a tour is broken off, as numbers alone.
//!
//! **Problem.** A robot drives a tour, and its battery lasts λ seconds. At chosen places it drives to a station,
//! charges, drives back and goes on; between two charges at most λ seconds may pass. Least total time is wanted.
//!
//! **Idea** ([`BreakOff::Optimal`]). A trip from a charge at station *s*, back to place *a*, along the tour to place
//! *b* and to a station *t* takes back(a, s) + S(b) − S(a) + home(b, t). What is best up to a break at (b, t) depends
//! on the break before alone, so breaks are a shortest path in an acyclic graph whose nodes are breaks. The time of a
//! trip splits into a part known at *a* and one known at *b*: so a break keeps one value (what is spent up to it, less
//! S(a)) and one deadline (the largest S(b) + home(b, t) that its charge allows), and the best break before (b, t) is
//! the least value among those with a deadline that is late enough. A Fenwick tree over the deadlines answers that. A trip
//! from one station to the next that drives nothing of the tour is told by itself.
//!
//! [`BreakOff::Latest`] is the rule of the paper: on to the next place if and only if the battery then still lasts to
//! the nearest station.
//!
//! **Guarantee.** The optimum over all choices among the given places and stations; never more than the latest rule,
//! for which the optimum stands in where that comes to a place it cannot leave.
//! Times are those of [`Tour`]; the finer its places, the nearer to the optimum over the whole line.
//!
//! **Complexity.** O(p log p + p s) for p places times stations, s stations.
//!
//! **Paper.** Coverage of unstructured environments with finite resources (`../shared/papers/003`), section 5: breaks
//! off as late as possible, anywhere in a lane, and names the choice of better places as future work.
//! Split of a giant tour: C. Prins, *A simple and effective evolutionary algorithm for the vehicle routing problem*,
//! Computers & Operations Research 31, 2004.
//!
//! **Departures.** Several stations, each with time to charge and to queue; a transfer at a break is saved; breaks
//! within a lane; a first trip with what is left in the battery.

use crate::BreakOff;

/// A place of the tour at which it may be broken off.
#[derive(Debug, Clone)]
pub(crate) struct Place {
    /// S: seconds from the start of the tour to here.
    pub(crate) at_s: f64,
    /// The same when it has turned to go on: later than `at_s` at a corner.
    pub(crate) leaves_s: f64,
    /// Number of the place at which it goes on after a charge: a later one where a transfer is saved.
    pub(crate) goes_on: usize,
    /// Per station: the way to it from here, and back to the place at which it goes on, seconds.
    pub(crate) ways: Vec<Ways>,
    /// Row-major by two stations: from the one by here to the other, seconds.
    pub(crate) by_here_s: Vec<f64>,
}

/// The way to a station and back, seconds; infinite where there is none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ways {
    pub(crate) home_s: f64,
    pub(crate) back_s: f64,
}

/// A tour and what its robot can do.
#[derive(Debug, Clone)]
pub(crate) struct Tour {
    /// In their order; the first is the start.
    pub(crate) places: Vec<Place>,
    /// Seconds from the start to the end of the tour, which lies behind the last place.
    pub(crate) end_s: f64,
    /// Seconds that must be left in the battery at the end.
    pub(crate) left_at_end_s: f64,
    /// Per station: seconds of a visit.
    pub(crate) visit_s: Vec<f64>,
    /// Seconds that a trip may take.
    pub(crate) budget_s: f64,
    /// Seconds that the trip from the start to the first charge may take.
    pub(crate) first_budget_s: f64,
}

/// Broken off at a place to charge at a station.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Break {
    pub(crate) place: usize,
    pub(crate) station: usize,
}

/// A place that the battery does not reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct OutOfRange {
    pub(crate) place: usize,
    /// What a trip there takes, seconds.
    pub(crate) takes_s: f64,
    /// What it may take, seconds.
    pub(crate) lasts_s: f64,
}

impl Tour {
    /// Where to break off, in the order of the tour.
    pub(crate) fn breaks(&self, rule: BreakOff) -> Result<Vec<Break>, OutOfRange> {
        match rule {
            BreakOff::Optimal => self.optimal_breaks(),
            // Between several stations the rule may come to a place that it cannot leave, where others would have gone on.
            BreakOff::Latest => self.latest_breaks().map_or_else(|| self.optimal_breaks(), Ok),
        }
    }

    /// Time of the tour with these breaks, seconds.
    #[cfg(test)]
    fn total_s(&self, breaks: &[Break]) -> f64 {
        let detour_s = |(number, &at): (usize, &Break)| {
            let before = number.checked_sub(1).map(|before| breaks[before]);
            self.home_s(before, at) + self.visit_s[at.station] + self.ways(at).back_s
                - self.goes_on_s(at.place)
        };
        self.end_s + breaks.iter().enumerate().map(detour_s).sum::<f64>()
    }

    fn ways(&self, at: Break) -> Ways {
        self.places[at.place].ways[at.station]
    }

    fn goes_on_s(&self, place: usize) -> f64 {
        self.places[self.places[place].goes_on].leaves_s
    }

    /// S when the station of a break is reached, after the break before. From one station to another the place at which
    /// it goes on may be nothing but on the way: then nothing of the tour is driven in between.
    fn home_s(&self, before: Option<Break>, at: Break) -> f64 {
        match before {
            Some(before) if before.place < at.place && self.places[before.place].goes_on == at.place => {
                self.goes_on_s(before.place) - self.ways(before).back_s + self.by_s(before, at)
            }
            _ => self.places[at.place].at_s + self.ways(at).home_s,
        }
    }

    /// From the station of a break to that of the next one, by the next one's place, seconds.
    fn by_s(&self, before: Break, at: Break) -> f64 {
        self.places[at.place].by_here_s[before.station * self.stations() + at.station]
    }

    fn stations(&self) -> usize {
        self.visit_s.len()
    }

    fn all_breaks(&self) -> impl Iterator<Item = Break> {
        let stations = self.stations();
        (0..self.places.len())
            .flat_map(move |place| (0..stations).map(move |station| Break { place, station }))
    }

    fn number(&self, at: Break) -> usize {
        at.place * self.stations() + at.station
    }

    fn optimal_breaks(&self) -> Result<Vec<Break>, OutOfRange> {
        let mut charges = Charges::new(self);
        // Breaks that open when the place is reached at which they go on.
        let mut opens: Vec<Vec<Break>> = vec![Vec::new(); self.places.len() + 1];
        let mut before: Vec<Option<Charge>> = vec![None; self.places.len() * self.stations()];
        // By how much no charge lasts there and on to a station, where that is worst.
        let mut worst = (0.0, self.places.len() - 1);
        let mut note = |over_s: f64, place: usize| {
            if over_s.is_finite() && over_s > worst.0 {
                worst = (over_s, place);
            }
            OutOfRange { place: worst.1, takes_s: self.budget_s + worst.0, lasts_s: self.budget_s }
        };
        for place in 0..self.places.len() {
            let open = std::mem::take(&mut opens[place]);
            let (here, earlier): (Vec<Break>, Vec<Break>) =
                open.into_iter().partition(|open| self.places[open.place].goes_on == place);
            let value_s = |before: &[Option<Charge>], open: Break| {
                before[self.number(open)].expect("it was reached").value_s
            };
            for open in earlier {
                charges.open(self, open, value_s(&before, open));
            }
            for station in 0..self.stations() {
                let at = Break { place, station };
                let home_s = self.ways(at).home_s;
                let along = charges.best(self.places[place].at_s + home_s);
                let along =
                    along.map(|charge| (charge.value_s + self.places[place].at_s + home_s, charge.at));
                // From one station to the next by this place.
                let by = here.iter().filter_map(|&open| {
                    let home_s = self.home_s(Some(open), at);
                    let lasts = self.by_s(open, at) <= self.budget_s;
                    lasts.then(|| (value_s(&before, open) + home_s, Some(open)))
                });
                let Some((spent_s, last)) = along.into_iter().chain(by).min_by(|a, b| a.0.total_cmp(&b.0))
                else {
                    continue;
                };
                let visited_s = spent_s + self.visit_s[station];
                let value_s = visited_s + self.ways(at).back_s - self.goes_on_s(place);
                if value_s.is_finite() {
                    before[self.number(at)] = Some(Charge { value_s, at: last });
                    opens[self.places[place].goes_on.max(place + 1)].push(at);
                }
            }
            for open in here {
                charges.open(self, open, value_s(&before, open));
            }
        }
        for open in opens.into_iter().flatten() {
            charges.open(self, open, before[self.number(open)].expect("it was reached").value_s);
        }
        let ends_s = self.end_s + self.left_at_end_s;
        let found = note(ends_s - charges.latest_s, self.places.len() - 1);
        let last = charges.best(ends_s).ok_or(found)?;
        let mut breaks: Vec<Break> =
            std::iter::successors(last.at, |&at| before[self.number(at)].and_then(|charge| charge.at))
                .collect();
        breaks.reverse();
        Ok(breaks)
    }

    fn latest_breaks(&self) -> Option<Vec<Break>> {
        let mut breaks: Vec<Break> = Vec::new();
        let (mut place, mut began_s, mut lasts_s) = (0, 0.0, self.first_budget_s);
        while place < self.places.len() {
            if self.then_home_s(breaks.last().copied(), place) - began_s > lasts_s {
                return None;
            }
            if self.then_home_s(None, place + 1) - began_s <= lasts_s {
                place += 1;
                continue;
            }
            let at = self.nearest(place).filter(|at| breaks.last() != Some(at));
            let at = at?;
            breaks.push(at);
            (began_s, lasts_s) = (self.goes_on_s(at.place) - self.ways(at).back_s, self.budget_s);
            place = self.places[place].goes_on;
        }
        Some(breaks)
    }

    /// S at a place after a break, or behind the last place at the end, and what must be left there to get to a station.
    fn then_home_s(&self, before: Option<Break>, place: usize) -> f64 {
        if place == self.places.len() {
            return self.end_s + self.left_at_end_s;
        }
        self.nearest(place).map_or(f64::INFINITY, |at| self.home_s(before, at))
    }

    fn nearest(&self, place: usize) -> Option<Break> {
        let all = (0..self.stations()).map(|station| Break { place, station });
        let reached = all.filter(|&at| self.ways(at).home_s.is_finite() && self.ways(at).back_s.is_finite());
        let spent_s = |at: Break| self.ways(at).home_s + self.visit_s[at.station];
        reached.min_by(|&a, &b| spent_s(a).total_cmp(&spent_s(b)))
    }
}

/// What is known of a charge: the time spent up to its trip less S where the trip begins, and the break it belongs to
/// (`None`: the start).
#[derive(Debug, Clone, Copy)]
struct Charge {
    value_s: f64,
    at: Option<Break>,
}

/// Charges by deadline: a Fenwick tree of least values, latest deadline first.
struct Charges {
    /// Descending.
    deadlines_s: Vec<f64>,
    tree: Vec<Option<Charge>>,
    /// The latest of those that have been put in.
    latest_s: f64,
}

impl Charges {
    fn new(tour: &Tour) -> Self {
        let deadlines_s = tour.all_breaks().map(|at| Self::deadline_s(tour, at));
        let mut deadlines_s: Vec<f64> = deadlines_s.chain([tour.first_budget_s]).collect();
        deadlines_s.sort_by(|a, b| b.total_cmp(a));
        let tree = vec![None; deadlines_s.len() + 1];
        let mut charges = Self { deadlines_s, tree, latest_s: f64::NEG_INFINITY };
        charges.insert(tour.first_budget_s, Charge { value_s: 0.0, at: None });
        charges
    }

    /// The largest S + way home that the charge at a break allows.
    fn deadline_s(tour: &Tour, at: Break) -> f64 {
        tour.goes_on_s(at.place) - tour.ways(at).back_s + tour.budget_s
    }

    fn open(&mut self, tour: &Tour, at: Break, value_s: f64) {
        self.insert(Self::deadline_s(tour, at), Charge { value_s, at: Some(at) });
    }

    fn insert(&mut self, deadline_s: f64, charge: Charge) {
        self.latest_s = self.latest_s.max(deadline_s);
        let mut node = self.deadlines_s.partition_point(|&other| other > deadline_s) + 1;
        while let Some(held) = self.tree.get_mut(node) {
            if held.is_none_or(|held| charge.value_s < held.value_s) {
                *held = Some(charge);
            }
            node += node & node.wrapping_neg();
        }
    }

    /// The charge of least value with a deadline of at least `needs_s`.
    fn best(&self, needs_s: f64) -> Option<Charge> {
        let mut node = self.deadlines_s.partition_point(|&deadline_s| deadline_s >= needs_s);
        let mut best: Option<Charge> = None;
        while node > 0 {
            let held = self.tree[node];
            if held.is_some_and(|held| best.is_none_or(|best| held.value_s < best.value_s)) {
                best = held;
            }
            node &= node - 1;
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    prop_compose! {
        /// A tour past stations that stand anywhere beside it, with transfers to be saved.
        fn tour()(places in 2_usize..14, stations in 1_usize..4)(
            steps in prop::collection::vec(0.1_f64..5.0, places),
            ways in prop::collection::vec((0.0_f64..12.0, 0.0_f64..12.0), places * stations),
            saved in prop::collection::vec(prop::bool::weighted(0.2), places),
            visit_s in prop::collection::vec(0.0_f64..9.0, stations),
            budget_s in 8.0_f64..60.0,
            first_budget_s in 5.0_f64..60.0,
            left_at_end_s in 0.0_f64..5.0,
        ) -> Tour {
            let stations = visit_s.len();
            let mut at_s = 0.0;
            let last = steps.len() - 1;
            let places = steps.iter().enumerate().map(|(place, step_s)| {
                let ways = ways[place * stations..][..stations].iter();
                let ways: Vec<Ways> = ways.map(|&(home_s, back_s)| Ways { home_s, back_s }).collect();
                let by = |from: &Ways| ways.iter().map(move |to| 0.7 * (from.back_s + to.home_s)).collect::<Vec<_>>();
                let by_here_s = ways.iter().flat_map(by).collect();
                let (here_s, leaves_s) = (at_s, at_s + 0.3 * step_s);
                at_s += step_s;
                Place { at_s: here_s, leaves_s, goes_on: place + usize::from(saved[place] && place < last), ways, by_here_s }
            });
            Tour { places: places.collect(), end_s: at_s, left_at_end_s, visit_s, budget_s, first_budget_s }
        }
    }

    /// Whether every trip lasts.
    fn lasts(tour: &Tour, breaks: &[Break]) -> bool {
        let (mut from_s, mut lasts_s) = (0.0, tour.first_budget_s);
        for (number, &at) in breaks.iter().enumerate() {
            let before = number.checked_sub(1).map(|before| breaks[before]);
            if tour.home_s(before, at) - from_s > lasts_s + 1e-9 {
                return false;
            }
            from_s = tour.goes_on_s(at.place) - tour.ways(at).back_s;
            lasts_s = tour.budget_s;
        }
        tour.end_s + tour.left_at_end_s - from_s <= lasts_s + 1e-9
    }

    /// All choices of breaks, tried one by one.
    fn tried_s(tour: &Tour, breaks: &mut Vec<Break>, from: usize) -> f64 {
        let mut best_s = if lasts(tour, breaks) { tour.total_s(breaks) } else { f64::INFINITY };
        for place in from..tour.places.len() {
            for station in 0..tour.stations() {
                breaks.push(Break { place, station });
                best_s = best_s.min(tried_s(tour, breaks, tour.places[place].goes_on.max(place + 1)));
                breaks.pop();
            }
        }
        best_s
    }

    proptest! {
        #[test]
        fn optimal_is_the_best_of_all_choices_and_latest_is_one_of_them(
            mut tour in tour(),
        ) {
            tour.places.truncate(6);
            tour.places.iter_mut().for_each(|place| place.goes_on = place.goes_on.min(5));
            let last = tour.places.len() - 1;
            tour.places[last].goes_on = last;
            let tried_s = tried_s(&tour, &mut Vec::new(), 0);
            let optimal = tour.breaks(BreakOff::Optimal);
            match &optimal {
                Ok(breaks) => {
                    prop_assert!(lasts(&tour, breaks));
                    prop_assert!((tour.total_s(breaks) - tried_s).abs() < 1e-6);
                }
                Err(_) => prop_assert!(tried_s.is_infinite(), "{tried_s}"),
            }
            if let Ok(latest) = tour.breaks(BreakOff::Latest) {
                prop_assert!(lasts(&tour, &latest));
                prop_assert!(tour.total_s(&latest) >= tour.total_s(&optimal.unwrap()) - 1e-6);
            }
        }

        #[test]
        fn a_long_tour_is_never_better_broken_off_late(tour in tour()) {
            if let Ok(latest) = tour.breaks(BreakOff::Latest) {
                let optimal = tour.breaks(BreakOff::Optimal).unwrap();
                prop_assert!(lasts(&tour, &optimal) && lasts(&tour, &latest));
                prop_assert!(tour.total_s(&optimal) <= tour.total_s(&latest) + 1e-6);
            }
        }
    }
}
