//! Several robots: who can reach which cells, and who drives which stretch of the tour.

use super::{
    cell_tour::{Costs, Stop},
    distances::Distances,
};
use crate::Instance;

const BISECTIONS: u32 = 40;

/// Robots on one piece of ground, and its cells.
#[derive(Debug, Default)]
pub(super) struct Group {
    pub(super) robots: Vec<usize>,
    pub(super) cells: Vec<usize>,
}

/// The connected pieces of ground with robots on them. Ends are numbered as in [`Costs`], the robots' stations last.
pub(super) fn groups(distances: &Distances, cells: usize, robots: usize) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    let station = |robot: usize| 4 * cells + robot;
    for robot in 0..robots {
        let known = groups.iter_mut().find(|group| {
            group.robots.iter().any(|&other| distances.between(station(robot), station(other)).is_finite())
        });
        match known {
            Some(group) => group.robots.push(robot),
            None => groups.push(Group { robots: vec![robot], cells: Vec::new() }),
        }
    }
    for cell in 0..cells {
        let reaches = |robot: &usize| distances.between(station(*robot), 4 * cell).is_finite();
        if let Some(group) = groups.iter_mut().find(|group| group.robots.iter().any(reaches)) {
            group.cells.push(cell);
        }
    }
    groups
}

/// Cuts a tour among the robots of a group: those that stand near its begin get its begin; the latest is as early as cuts at
/// cells allow.
pub(super) fn divide<'a>(
    instance: &Instance<'_>,
    robots: &[usize],
    tour: &[Stop],
    costs: impl Fn(usize) -> Costs<'a>,
) -> Vec<(usize, Vec<Stop>)> {
    if let [only] = robots {
        return vec![(*only, tour.to_vec())];
    }
    let speed = instance.motion.speed_m_per_s;
    let seconds = |robot: usize, stops: &[Stop]| {
        let driving_s = if stops.is_empty() { 0.0 } else { costs(robot).length_m(stops) / speed };
        instance.starts[robot].available_in_s + driving_s
    };
    let mut order = robots.to_vec();
    order.sort_by_key(|&robot| (nearest(&costs(robot), tour), robot));
    let deal = |bound_s: f64| {
        let mut rest = tour;
        let mut parts = Vec::new();
        for &robot in &order {
            // Within a bound, a longer stretch takes longer: the longest that is not too long is found by halving.
            let fits = |count: &usize| seconds(robot, &rest[..*count]) <= bound_s;
            let counts: Vec<usize> = (0..=rest.len()).collect();
            let count = counts.partition_point(fits).saturating_sub(1);
            parts.push((robot, rest[..count].to_vec()));
            rest = &rest[count..];
        }
        rest.is_empty().then_some(parts)
    };
    let (mut low, mut high) =
        (0.0, order.iter().map(|&robot| seconds(robot, tour)).fold(0.0, f64::max) + 1.0);
    let mut best = deal(high).unwrap_or_else(|| vec![(order[0], tour.to_vec())]);
    for _ in 0..BISECTIONS {
        let bound_s = f64::midpoint(low, high);
        match deal(bound_s) {
            Some(parts) => (best, high) = (parts, bound_s),
            None => low = bound_s,
        }
    }
    best
}

/// The stop of a tour that is nearest to a robot.
fn nearest(costs: &Costs<'_>, tour: &[Stop]) -> usize {
    let way = |at: usize| costs.way(None, Some(tour[at]));
    (0..tour.len()).min_by(|&a, &b| way(a).total_cmp(&way(b))).unwrap_or(0)
}
