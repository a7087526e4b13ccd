//! A giant tour cut into one piece per robot.

use super::{Ends, links::Links};

/// Halvings of the bound on the makespan.
const HALVINGS: u32 = 24;
/// Places at which the tour is opened, besides those nearest to the robots.
const OPENINGS: usize = 16;

/// The best cut found: for each place at which the tour is opened, the least bound within which robots, each taking as
/// much as it can in the order in which the tour passes them by, take all.
pub(super) fn cut(links: &Links<'_>, burden: &[f64]) -> Vec<Ends> {
    let tour = Tour::new(links, burden);
    let stretches = links.stretches();
    let mut openings: Vec<usize> = (0..OPENINGS).map(|part| part * stretches / OPENINGS).collect();
    openings.extend(&tour.passes);
    openings.sort_unstable();
    openings.dedup();
    let cuts = openings.into_iter().map(|opening| tour.best_cut(opening));
    let best = cuts.min_by(|a, b| a.0.total_cmp(&b.0)).expect("there is a place to open the tour");
    best.1
}

/// The tour, closed.
struct Tour<'l, 'a> {
    links: &'l Links<'a>,
    burden: &'l [f64],
    /// Seconds from leaving each stretch to being ready to drive the next one.
    link_s: Vec<f64>,
    /// Per robot: the stretch that its start is nearest to.
    passes: Vec<usize>,
}

impl<'l, 'a> Tour<'l, 'a> {
    fn new(links: &'l Links<'a>, burden: &'l [f64]) -> Self {
        let stretches = links.stretches();
        let link_s = |stretch: usize| {
            let next = (stretch + 1) % stretches;
            links.link_s(2 * stretch as u32 + 1, 2 * next as u32)
        };
        let nearest = |robot: usize| {
            let out_s = |stretch: &usize| links.out_s(robot, 2 * *stretch as u32);
            (0..stretches).min_by(|a, b| out_s(a).total_cmp(&out_s(b))).unwrap_or(0)
        };
        let link_s = (0..stretches).map(link_s).collect();
        Self { links, burden, link_s, passes: (0..links.robots()).map(nearest).collect() }
    }

    fn best_cut(&self, opening: usize) -> (f64, Vec<Ends>) {
        let stretches = self.links.stretches();
        let mut order: Vec<usize> = (0..self.links.robots()).collect();
        order.sort_by_key(|&robot| ((self.passes[robot] + stretches - opening) % stretches, robot));
        let mut high_s = 1.0;
        let mut best = loop {
            match self.within(opening, &order, high_s) {
                Some(cut) => break cut,
                None => high_s *= 2.0,
            }
        };
        let mut low_s = 0.0;
        for _ in 0..HALVINGS {
            let middle_s = f64::midpoint(low_s, high_s);
            match self.within(opening, &order, middle_s) {
                Some(cut) => (best, high_s) = (cut, middle_s),
                None => low_s = middle_s,
            }
        }
        let time_s = |(robot, route): (usize, &Ends)| self.burden[robot] * self.links.route_s(robot, route);
        (best.iter().enumerate().map(time_s).fold(0.0, f64::max), best)
    }

    /// Routes of at most `bound_s` that take all stretches, if this order of robots gives any.
    fn within(&self, opening: usize, order: &[usize], bound_s: f64) -> Option<Vec<Ends>> {
        let stretches = self.links.stretches();
        let mut routes = vec![Ends::new(); order.len()];
        let mut taken = 0;
        for &robot in order {
            let count = self.takes(robot, (opening + taken) % stretches, stretches - taken, bound_s);
            routes[robot] =
                (taken..taken + count).map(|at| 2 * ((opening + at) % stretches) as u32).collect();
            taken += count;
        }
        (taken == stretches).then_some(routes)
    }

    /// How many stretches from a first one on a robot drives within a bound.
    fn takes(&self, robot: usize, first: usize, most: usize, bound_s: f64) -> usize {
        let links = self.links;
        if most == 0 {
            return 0;
        }
        let mut spent_s = links.available_in_s(robot) + links.out_s(robot, 2 * first as u32);
        let mut takes = 0;
        for count in 1..=most {
            let stretch = (first + count - 1) % links.stretches();
            spent_s += links.inner_s(2 * stretch as u32);
            let done_s = spent_s + links.home_s(robot, 2 * stretch as u32 + 1);
            if self.burden[robot] * done_s <= bound_s {
                takes = count;
            } else if self.burden[robot] * spent_s > bound_s {
                break;
            }
            spent_s += self.link_s[stretch];
        }
        takes
    }
}
