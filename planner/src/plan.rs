//! A plan: one route per robot.

use crate::Figures;
use terrain::Point;

/// One robot's ordered places, metres in the map frame. The first is the centre of its start cell. An empty
/// route means: stay.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Route {
    /// The places, in the order of driving; straight lines between them.
    pub points: Vec<Point>,
    /// Numbers of the points at which it charges, ascending; each is at a station.
    pub charges: Vec<usize>,
}

impl Route {
    /// A route along points, without a charge on the way.
    pub const fn new(points: Vec<Point>) -> Self {
        Self { points, charges: Vec::new() }
    }

    /// The stretches between charges, each with the point it charges at in the end (the last one has none). A
    /// stretch begins and ends with the points charged at.
    pub fn stretches(&self) -> impl Iterator<Item = &[Point]> {
        let last = self.points.len().saturating_sub(1);
        let begins = std::iter::once(0).chain(self.charges.iter().copied());
        let ends = self.charges.iter().copied().chain(std::iter::once(last));
        begins.zip(ends).map(|(begin, end)| self.points.get(begin..=end).unwrap_or_default())
    }
}

/// One route per robot, in the order of the instance's starts.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Plan {
    /// The routes.
    pub routes: Vec<Route>,
}

/// A plan that stood the test of [`crate::verify()`]: the only plan that can be driven.
#[derive(Debug, Clone, PartialEq)]
pub struct VerifiedPlan {
    plan: Plan,
    figures: Figures,
    planner: &'static str,
}

impl VerifiedPlan {
    pub(crate) fn new(plan: Plan, figures: Figures, planner: &'static str) -> Self {
        Self { plan, figures, planner }
    }

    /// The routes, in the order of the instance's starts.
    pub fn routes(&self) -> &[Route] {
        &self.plan.routes
    }

    /// What verify measured.
    pub fn figures(&self) -> &Figures {
        &self.figures
    }

    /// Name of the planner that made it.
    pub fn planner(&self) -> &'static str {
        self.planner
    }
}
