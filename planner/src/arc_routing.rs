//! Several robots drive a set of stretches, each stretch once and in either direction, so that the last one is done
//! as early as possible: the rural postman problem with several depots and the makespan as objective.
//!
//! **Idea.** One order of all stretches (a giant tour, as a planner for one robot makes it) is cut into one piece per
//! robot: the makespan is bisected, and for each bound robots take as much as they can, in the order in which the tour
//! passes them by. Then runs of stretches change hands and places by ruin and recreate: runs around a random stretch
//! are taken out of their routes and put back one by one where they cost least, with simulated annealing on a power
//! mean of the robots' times. Links between stretches are ways of the body, priced with all turns; only near ones are
//! known from the start, others are guessed high and priced when a good answer uses them. Long stretches are cut
//! beforehand, so that no single one is a large share of a robot's time.
//!
//! **Guarantee.** Every stretch is driven. None on quality; the best routes seen are the answer, and never worse than
//! the first cut.
//!
//! **Complexity.** O(n) bounded searches for the links of n stretches, O(n) for a bound on the makespan, and for a step
//! of the search O(removed × near links).
//!
//! **Papers.** Cut of a giant tour: J. Beasley, *Route first–cluster second methods for vehicle routing*, Omega 11,
//! 1983; C. Prins, Computers & Operations Research 31, 2004. Ruin and recreate by runs: J. Christiaens and G. Vanden
//! Berghe, *Slack induction by string removals for vehicle routing problems*, Transportation Science 54, 2020.
//!
//! **Departures.** Stretches have two directions, both tried at each insertion; the objective is a power mean of times,
//! not a sum; no fleet reduction.

mod cut;
mod links;
mod ruin_recreate;
mod stretches;

pub(crate) use stretches::{Stretch, in_parts};

use crate::{Mode, PlanError, PlanOptions, Route, transfers::Transfers};
use links::Links;
use ruin_recreate::Search;
use terrain::Point;

/// Steps of the search per stretch and effort.
const STEPS: u64 = 400;
/// Rounds in which links that were only guessed are priced.
const ROUNDS: u32 = 8;

/// A route as the ends at which its stretches are entered: end `2 i + side` belongs to stretch `i`.
pub(crate) type Ends = Vec<u32>;

/// Routes over stretches, on the way to being good.
pub(crate) struct Routing<'t, 's, 'a> {
    transfers: &'t mut Transfers<'s, 'a>,
    /// Numbers of the robots in the instance.
    robots: Vec<usize>,
    stretches: Vec<Stretch>,
    links: Links<'a>,
    /// What a second of each robot counts: more than 1 where it will have to charge.
    pub(crate) burden: Vec<f64>,
    routes: Vec<Ends>,
    options: &'t PlanOptions,
}

impl<'t, 's, 'a> Routing<'t, 's, 'a> {
    /// The first cut: stretches come in the order and direction of a giant tour. All can be reached by each robot.
    pub(crate) fn new(
        transfers: &'t mut Transfers<'s, 'a>,
        robots: &[usize],
        stretches: Vec<Stretch>,
        options: &'t PlanOptions,
    ) -> Self {
        let links = Links::new(transfers, robots, &stretches, options.effort);
        let burden = vec![1.0; robots.len()];
        let routes = cut::cut(&links, &burden);
        Self { transfers, robots: robots.to_vec(), stretches, links, burden, routes, options }
    }

    /// Searches for better routes, for a number of steps that grows with the effort. After each round guessed links are
    /// priced, and the routes that then are the best are searched on.
    pub(crate) fn improve(&mut self) {
        let steps = STEPS * u64::from(self.options.effort) * self.stretches.len() as u64;
        if steps == 0 {
            return;
        }
        self.links.price(self.transfers, &self.routes);
        for round in 0..ROUNDS {
            let seed = self.options.seed + u64::from(round);
            let mut search = Search::new(&self.links, &self.burden, self.routes.clone(), seed);
            search.run(steps / u64::from(ROUNDS), f64::from(ROUNDS - round) / f64::from(ROUNDS));
            let found = search.into_best();
            self.links.price(self.transfers, &found);
            if self.objective_s(&found) < self.objective_s(&self.routes) {
                self.routes = found;
            }
        }
    }

    fn objective_s(&self, routes: &[Ends]) -> f64 {
        Search::new(&self.links, &self.burden, routes.to_vec(), 0).objective_s()
    }

    /// The routes with all points, in the order of the robots given.
    pub(crate) fn routes(&mut self) -> Result<Vec<Route>, PlanError> {
        (0..self.robots.len()).map(|route| self.driven(route)).collect()
    }

    fn driven(&mut self, number: usize) -> Result<Route, PlanError> {
        let instance = self.transfers.space().instance();
        let route = &self.routes[number];
        if route.is_empty() {
            return Ok(Route::default());
        }
        let start = instance.place(&instance.starts[self.robots[number]]);
        let mut points = vec![start];
        for &end in route {
            let stretch = self.stretches[end as usize / 2].entered_at(end);
            go(self.transfers, &mut points, stretch[0])?;
            points.extend(stretch.iter().skip(1));
        }
        if instance.mode == Mode::CoverAndReturn {
            go(self.transfers, &mut points, start)?;
        }
        Ok(Route::new(points))
    }
}

fn go(transfers: &mut Transfers<'_, '_>, points: &mut Vec<Point>, to: Point) -> Result<(), PlanError> {
    let from = *points.last().expect("a route begins somewhere");
    let floor = transfers.space().instance().floor;
    let cell = || floor.lattice().cell_at(to).expect("stretches stay on the floor");
    let way = transfers.way(from, to).ok_or_else(|| PlanError::Unreachable(cell()))?;
    points.extend(way.points.into_iter().skip(1));
    Ok(())
}
