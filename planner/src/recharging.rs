//! Puts charges into routes: for any planner, where robots have a battery.
//!
//! ```text
//!   route of a planner ──▶ places along it, each with its ways to the stations and back ──▶ breaks (break_off)
//!                     ◀── up to a break, to the station, back to where it goes on, … ◀──────┘
//! ```
//!
//! A stretch of a route that sweeps nothing new is a transfer: after a charge within it, or at its begin, the robot
//! drives straight to its end. Routes along the lattice are broken off at cells, all others anywhere.

pub(crate) mod break_off;
mod homeward;
mod line;
mod work;

use crate::{Battery, Instance, Plan, PlanError, configuration_space::ConfigurationSpace};
use homeward::{AlongLattice, Homeward, OverGround};
use line::Line;
use work::Work;

/// Puts charges into those routes of a plan that have none and take longer than a battery lasts.
pub(crate) fn with_charges(instance: &Instance<'_>, plan: Plan) -> Result<Plan, PlanError> {
    let Some(battery) = &instance.battery else { return Ok(plan) };
    let work = Work::new(instance, &plan);
    if work.is_along_lattice() {
        charged(instance, battery, plan, work, &mut AlongLattice::new(instance))
    } else {
        let space = ConfigurationSpace::new(instance);
        charged(instance, battery, plan, work, &mut OverGround::new(&space))
    }
}

fn charged<'a>(
    instance: &'a Instance<'a>,
    battery: &Battery,
    mut plan: Plan,
    mut work: Work<'a>,
    homeward: &mut dyn Homeward,
) -> Result<Plan, PlanError> {
    for (robot, route) in plan.routes.iter_mut().enumerate() {
        if route.points.len() > 1 && route.charges.is_empty() {
            let points = std::mem::take(&mut route.points);
            *route = Line::new(instance, robot, &points, homeward, &mut work).charged(battery)?;
        }
    }
    Ok(plan)
}
