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

pub(crate) use stretches::Stretch;

use crate::{
    Instance, Mode, Plan, PlanError, PlanOptions, Route, configuration_space::ConfigurationSpace, recharging,
    transfers::Transfers, verify,
};
use links::Links;
use ruin_recreate::Search;
use terrain::Point;

/// Steps of the search per stretch and effort.
const STEPS: u64 = 400;
/// Rounds in which links that were only guessed are priced.
const ROUNDS: u32 = 4;

/// No stretch is longer than this share of what each robot has to do.
const SHARE_MAX: f64 = 1.0 / 40.0;

/// A route as the ends at which its stretches are entered: end `2 i + side` belongs to stretch `i`.
pub(crate) type Ends = Vec<u32>;

/// Divides the line that one robot would drive to cover everything among all robots of an instance. Where they have a
/// battery, the routes charge.
pub(crate) fn divided(
    instance: &Instance<'_>,
    line: &[Point],
    options: &PlanOptions,
) -> Result<Plan, PlanError> {
    let space = ConfigurationSpace::new(instance);
    let mut transfers = Transfers::new(&space);
    let length_m: f64 = line.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
    let most_m = (length_m / instance.starts.len() as f64 * SHARE_MAX).max(4.0 * instance.floor.tool_width_m());
    let stretches = stretches::stretches_of(instance, line, most_m);
    let mut routing = Routing::new(&mut transfers, &stretches, options);
    routing.improve();
    let plain = routing.plan()?;
    if instance.battery.is_none() {
        return Ok(plain);
    }
    let charged = recharging::with_charges(instance, plain.clone())?;
    let without_battery = Instance { battery: None, ..instance.clone() };
    let (Ok(before), Ok(after)) = (verify(&without_battery, &plain), verify(instance, &charged)) else {
        return Ok(charged);
    };
    routing.burden =
        after.cost_s.iter().zip(&before.cost_s).map(|(after_s, before_s)| after_s / before_s.max(1.0)).collect();
    routing.improve();
    let again = recharging::with_charges(instance, routing.plan()?)?;
    let is_better = verify(instance, &again).is_ok_and(|again| again.makespan_s < after.makespan_s);
    Ok(if is_better { again } else { charged })
}

/// Routes over stretches, on the way to being good.
struct Routing<'t, 's, 'a> {
    transfers: &'t mut Transfers<'s, 'a>,
    stretches: &'t [Stretch],
    links: Links<'a>,
    /// What a second of each robot counts: more than 1 where it will have to charge.
    burden: Vec<f64>,
    routes: Vec<Ends>,
    options: &'t PlanOptions,
}

impl<'t, 's, 'a> Routing<'t, 's, 'a> {
    /// The stretches come in the order of a giant tour.
    fn new(
        transfers: &'t mut Transfers<'s, 'a>,
        stretches: &'t [Stretch],
        options: &'t PlanOptions,
    ) -> Self {
        let links = Links::new(transfers, stretches, options.effort);
        let burden = vec![1.0; links.robots()];
        let routes = cut::cut(&links, &burden);
        Self { transfers, stretches, links, burden, routes, options }
    }

    fn improve(&mut self) {
        let steps = STEPS * u64::from(self.options.effort) * self.stretches.len() as u64;
        for round in 0..if steps > 0 { ROUNDS } else { 0 } {
            let seed = self.options.seed + u64::from(round);
            let routes = std::mem::take(&mut self.routes);
            let mut search = Search::new(&self.links, &self.burden, routes, seed);
            search.run(steps / u64::from(ROUNDS), f64::from(ROUNDS - round) / f64::from(ROUNDS));
            self.routes = search.into_best();
            self.links.price(self.transfers, &self.routes);
        }
    }

    /// The routes with all points.
    fn plan(&mut self) -> Result<Plan, PlanError> {
        let instance = self.transfers.space().instance();
        let routes = self.routes.iter().enumerate();
        let driven = routes.map(|(robot, route)| driven(self.transfers, instance, robot, self.stretches, route));
        Ok(Plan { routes: driven.collect::<Result<_, _>>()? })
    }
}

/// A route with all points.
fn driven(
    transfers: &mut Transfers<'_, '_>,
    instance: &Instance<'_>,
    robot: usize,
    stretches: &[Stretch],
    route: &Ends,
) -> Result<Route, PlanError> {
    if route.is_empty() {
        return Ok(Route::default());
    }
    let start = instance.place(&instance.starts[robot]);
    let mut points = vec![start];
    for &end in route {
        let stretch = stretches[end as usize / 2].entered_at(end);
        go(transfers, instance, &mut points, stretch[0])?;
        points.extend(stretch.iter().skip(1));
    }
    if instance.mode == Mode::CoverAndReturn {
        go(transfers, instance, &mut points, start)?;
    }
    Ok(Route::new(points))
}

fn go(
    transfers: &mut Transfers<'_, '_>,
    instance: &Instance<'_>,
    points: &mut Vec<Point>,
    to: Point,
) -> Result<(), PlanError> {
    let from = *points.last().expect("a route begins somewhere");
    let cell = || instance.floor.lattice().cell_at(to).expect("stretches stay on the floor");
    let way = transfers.way(from, to).ok_or_else(|| PlanError::Unreachable(cell()))?;
    points.extend(way.points.into_iter().filter(|point| (point - from).norm() > 1e-9));
    Ok(())
}
