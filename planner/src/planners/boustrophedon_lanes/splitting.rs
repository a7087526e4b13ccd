//! Which robots drive which lanes: those that reach them, in parts of equal time.

use crate::{
    Instance, Mode, Plan, configuration_space::ConfigurationSpace, lane_tour::Stop, transfers::Transfers,
};
use std::collections::BTreeMap;
use terrain::Point;

/// The robots on each connected piece of the space.
pub(super) fn groups(space: &ConfigurationSpace<'_>) -> Vec<Vec<usize>> {
    if space.instance().starts.len() == 1 {
        return vec![vec![0]];
    }
    let piece = pieces_of_places(space);
    let mut found: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (robot, start) in space.instance().starts.iter().enumerate() {
        if let Some(place) = space.place_in_middle(start.cell) {
            found.entry(piece[place]).or_default().push(robot);
        }
    }
    found.into_values().collect()
}

fn pieces_of_places(space: &ConfigurationSpace<'_>) -> Vec<u32> {
    let mut piece = vec![u32::MAX; space.places().len()];
    let mut stack = Vec::new();
    for (number, start) in space.instance().starts.iter().enumerate() {
        let Some(place) = space.place_in_middle(start.cell) else { continue };
        if piece[place] != u32::MAX {
            continue;
        }
        piece[place] = number as u32;
        stack.push(place);
        while let Some(place) = stack.pop() {
            for (_, next) in space.steps(place) {
                if piece[next] == u32::MAX {
                    piece[next] = number as u32;
                    stack.push(next);
                }
            }
        }
    }
    piece
}

/// Gives each robot a part of the tour; all parts take about the same time.
pub(super) fn divide(
    transfers: &mut Transfers<'_, '_>,
    instance: &Instance<'_>,
    robots: &[usize],
    stops: &[Stop],
    plan: &mut Plan,
) {
    let time_s = |stop: &Stop| instance.motion.path_s(&stop.lane.points, None) + stop.way.inner_s;
    let total_s: f64 = stops.iter().map(time_s).sum();
    let mut parts: Vec<Vec<&Stop>> = vec![Vec::new(); robots.len()];
    let mut so_far_s = 0.0;
    for stop in stops {
        let middle_s = so_far_s + time_s(stop) / 2.0;
        let part = (middle_s / total_s.max(1e-9) * robots.len() as f64) as usize;
        parts[part.min(robots.len() - 1)].push(stop);
        so_far_s += time_s(stop);
    }
    for (&robot, part) in robots.iter().zip(&parts) {
        let place = instance.place(&instance.starts[robot]);
        plan.routes[robot].points = route(transfers, instance, place, part);
    }
}

fn route(
    transfers: &mut Transfers<'_, '_>,
    instance: &Instance<'_>,
    place: Point,
    stops: &[&Stop],
) -> Vec<Point> {
    let (Some(first), Some(last)) = (stops.first(), stops.last()) else { return Vec::new() };
    let mut points = vec![place];
    let mut go = |points: &mut Vec<Point>, from: Point, to: Point| {
        if let Some(way) = transfers.way(from, to) {
            points.extend(way.points);
        }
    };
    for (number, stop) in stops.iter().enumerate() {
        if number > 0 || stop.way.points.first() == Some(&place) {
            points.extend(&stop.way.points);
        } else {
            go(&mut points, place, first.lane.from());
        }
        points.extend(&stop.lane.points);
    }
    if instance.mode == Mode::CoverAndReturn {
        go(&mut points, last.lane.to(), place);
    }
    points.dedup_by(|a, b| (*a - *b).norm() < 1e-7);
    points
}
