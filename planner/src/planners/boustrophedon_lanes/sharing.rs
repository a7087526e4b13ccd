//! Lanes of one tour shared among several robots.
//!
//! The tour is cut and improved over all robots at once ([`crate::arc_routing`]). What the routes then leave unswept,
//! since other ways are driven than in the tour, gets short lanes as in a tour for one. Where robots have to charge, the
//! time that this takes each of them is weighed in, and the lanes are shared again.

use super::{COVERAGE_MARGIN, ROUNDS, Stop, residue};
use crate::{
    Instance, Plan, PlanError, PlanOptions, Route,
    arc_routing::{Routing, Stretch, in_parts},
    configuration_space::ConfigurationSpace,
    ground::Ground,
    lane_tour::Lane,
    minimum_lanes::ToolLattice,
    recharging,
    transfers::Transfers,
    verify::costs_s,
};

/// No stretch is longer than this share of what each robot has to do.
const SHARE_MAX: f64 = 1.0 / 40.0;
/// Nor cut shorter than so many tool widths.
const TOOLS_MIN: f64 = 6.0;

/// What is swept, and how what is left is found.
pub(super) struct Sweeping<'g, 's, 'a> {
    pub(super) space: &'s ConfigurationSpace<'a>,
    pub(super) ground: &'g mut Ground,
    pub(super) lattice: &'g ToolLattice,
}

/// Gives routes to the robots that share a tour, which is swept already, as are the tours of others.
pub(super) fn share(
    sweeping: &mut Sweeping<'_, '_, '_>,
    transfers: &mut Transfers<'_, '_>,
    robots: &[usize],
    stops: &[Stop],
    options: &PlanOptions,
    plan: &mut Plan,
) -> Result<(), PlanError> {
    let instance = sweeping.space.instance();
    for stop in stops {
        sweeping.ground.unsweep(&stop.way.points);
        sweeping.ground.unsweep(&[stop.lane.from, stop.lane.to]);
    }
    let mut routing = Routing::new(transfers, robots, stretches(instance, robots.len(), stops), options);
    routing.improve();
    let plain = sweeping.routes_that_sweep_all(&mut routing)?;
    let routes = match &instance.battery {
        Some(_) if robots.len() > 1 => shared_with_charges(sweeping, &mut routing, robots, plain)?,
        _ => plain,
    };
    for route in &routes {
        sweeping.ground.sweep(&route.points);
    }
    robots.iter().zip(routes).for_each(|(&robot, route)| plan.routes[robot] = route);
    Ok(())
}

/// Shares again with what a second of each robot counts, its charges included; the better of both.
fn shared_with_charges(
    sweeping: &mut Sweeping<'_, '_, '_>,
    routing: &mut Routing<'_, '_, '_>,
    robots: &[usize],
    plain: Vec<Route>,
) -> Result<Vec<Route>, PlanError> {
    let instance = sweeping.space.instance();
    let plain_s = times_s(instance, robots, &plain);
    let charged = with_charges(instance, robots, plain)?;
    let charged_s = times_s(instance, robots, &charged);
    for (burden, (after_s, before_s)) in routing.burden.iter_mut().zip(charged_s.iter().zip(&plain_s)) {
        *burden = after_s / before_s.max(1.0);
    }
    routing.improve();
    let again = with_charges(instance, robots, sweeping.routes_that_sweep_all(routing)?)?;
    let longest_s = |times_s: &[f64]| times_s.iter().copied().fold(0.0, f64::max);
    let is_better = longest_s(&times_s(instance, robots, &again)) < longest_s(&charged_s);
    Ok(if is_better { again } else { charged })
}

fn with_charges(
    instance: &Instance<'_>,
    robots: &[usize],
    routes: Vec<Route>,
) -> Result<Vec<Route>, PlanError> {
    let mut plan = plan_of(instance, robots, routes);
    plan = recharging::with_charges(instance, plan)?;
    Ok(robots.iter().map(|&robot| std::mem::take(&mut plan.routes[robot])).collect())
}

fn times_s(instance: &Instance<'_>, robots: &[usize], routes: &[Route]) -> Vec<f64> {
    let costs_s = costs_s(instance, &plan_of(instance, robots, routes.to_vec()));
    robots.iter().map(|&robot| costs_s[robot]).collect()
}

fn plan_of(instance: &Instance<'_>, robots: &[usize], routes: Vec<Route>) -> Plan {
    let mut plan = Plan { routes: vec![Route::default(); instance.starts.len()] };
    robots.iter().zip(routes).for_each(|(&robot, route)| plan.routes[robot] = route);
    plan
}

impl Sweeping<'_, '_, '_> {
    /// The routes, with short lanes added for what they leave unswept.
    fn routes_that_sweep_all(&mut self, routing: &mut Routing<'_, '_, '_>) -> Result<Vec<Route>, PlanError> {
        let instance = self.space.instance();
        let goal = instance.coverage_min + COVERAGE_MARGIN;
        for _ in 0..ROUNDS {
            let routes = routing.routes()?;
            for route in &routes {
                self.ground.sweep(&route.points);
            }
            let enough = self.ground.coverage() >= goal.min(1.0);
            let added =
                if enough { Vec::new() } else { residue::lanes(self.space, self.ground, self.lattice, goal) };
            for route in &routes {
                self.ground.unsweep(&route.points);
            }
            for lane in &added {
                self.ground.unsweep(&[lane.from, lane.to]);
            }
            if added.is_empty() {
                return Ok(routes);
            }
            let stretch = |lane: &Lane| Stretch::new(instance, vec![lane.from, lane.to]);
            routing.add(added.iter().map(stretch).collect());
        }
        routing.routes()
    }
}

fn stretches(instance: &Instance<'_>, robots: usize, stops: &[Stop]) -> Vec<Stretch> {
    let length_m: f64 = stops.iter().map(|stop| (stop.lane.to - stop.lane.from).norm()).sum();
    let most_m = (length_m / robots as f64 * SHARE_MAX).max(TOOLS_MIN * instance.floor.tool_width_m());
    stops.iter().flat_map(|stop| in_parts(instance, stop.lane.from, stop.lane.to, most_m)).collect()
}
