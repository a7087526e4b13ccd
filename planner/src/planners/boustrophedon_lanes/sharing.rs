//! Lanes of one tour shared among several robots.
//!
//! The tour is cut and improved over all robots at once ([`crate::arc_routing`]). Where robots have to charge, the
//! time that this takes each of them is weighed in, and the lanes are shared again.

use crate::{
    Instance, Plan, PlanError, PlanOptions, Route,
    arc_routing::{Routing, Stretch, in_parts},
    lane_tour::Stop,
    recharging,
    transfers::Transfers,
    verify::costs_s,
};

/// No stretch is longer than this share of what each robot has to do.
const SHARE_MAX: f64 = 1.0 / 40.0;
/// Nor cut shorter than so many tool widths.
const TOOLS_MIN: f64 = 6.0;

/// Gives routes to the robots that share a tour, none of which has any yet.
pub(super) fn share(
    transfers: &mut Transfers<'_, '_>,
    robots: &[usize],
    stops: &[Stop],
    options: &PlanOptions,
    plan: &mut Plan,
) -> Result<(), PlanError> {
    let instance = transfers.space().instance();
    let mut routing = Routing::new(transfers, robots, stretches(instance, robots.len(), stops), options);
    routing.improve();
    let plain = routing.routes()?;
    let routes = match &instance.battery {
        Some(_) if robots.len() > 1 => shared_with_charges(instance, &mut routing, robots, plain)?,
        _ => plain,
    };
    robots.iter().zip(routes).for_each(|(&robot, route)| plan.routes[robot] = route);
    Ok(())
}

/// Shares again with what a second of each robot counts, its charges included; the better of both.
fn shared_with_charges(
    instance: &Instance<'_>,
    routing: &mut Routing<'_, '_, '_>,
    robots: &[usize],
    plain: Vec<Route>,
) -> Result<Vec<Route>, PlanError> {
    let plain_s = times_s(instance, robots, &plain);
    let charged = with_charges(instance, robots, plain)?;
    let charged_s = times_s(instance, robots, &charged);
    for (burden, (after_s, before_s)) in routing.burden.iter_mut().zip(charged_s.iter().zip(&plain_s)) {
        *burden = after_s / before_s.max(1.0);
    }
    routing.improve();
    let again = with_charges(instance, robots, routing.routes()?)?;
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

fn stretches(instance: &Instance<'_>, robots: usize, stops: &[Stop]) -> Vec<Stretch> {
    let length_m: f64 = stops.iter().map(|stop| stop.lane.length_m()).sum();
    let most_m = (length_m / robots as f64 * SHARE_MAX).max(TOOLS_MIN * instance.floor.tool_width_m());
    stops.iter().flat_map(|stop| in_parts(instance, &stop.lane.points, most_m)).collect()
}
