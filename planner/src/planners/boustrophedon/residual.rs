//! What lanes leave out, along slanted walls and round small obstacles: places from which it is swept, by side trips from where
//! a route comes nearest.
//!
//! The places are centres of cells, the one from which most is gained first, until the share asked for is swept. From all of
//! them together everything that can be asked for is swept, so this always gets there.

use crate::{Instance, Mode, Route, transfers::Transfers};
use std::collections::{BTreeMap, BinaryHeap};
use terrain::{Cell, Point, Segment, SweptRaster, samples_swept_from};

/// So many places of routes are looked at for a side trip.
const CANDIDATES: usize = 4;

/// Adds side trips to routes until they sweep `share` of what is to be swept. Routes have at least one point each.
pub(super) fn sweep_the_rest(transfers: &mut Transfers<'_, '_>, routes: &mut [Route], share: f64) {
    let instance = transfers.space().instance();
    for stop in stops(instance, routes, share) {
        side_trip(transfers, routes, instance.center(stop));
    }
}

/// Samples that are still to be swept, per cell.
type Missing = BTreeMap<usize, u64>;

/// Cells from whose centres the rest is swept.
fn stops(instance: &Instance<'_>, routes: &[Route], share: f64) -> Vec<Cell> {
    let lattice = instance.floor.lattice();
    let mut raster = SweptRaster::new(*lattice);
    let radius_m = instance.floor.tool_width_m() / 2.0;
    for pair in routes.iter().flat_map(|route| route.points.windows(2)) {
        raster.sweep(Segment::new(pair[0], pair[1]), radius_m, |_| {});
    }
    let (mut wanted, mut left) = (0_u64, 0_u64);
    let mut missing = Missing::new();
    for index in (0..lattice.len()).filter(|&index| instance.visit[index]) {
        let required = instance.floor.required(index);
        let open = required & !raster.samples(index);
        wanted += u64::from(required.count_ones());
        left += u64::from(open.count_ones());
        if open != 0 {
            missing.insert(index, open);
        }
    }
    let allowed = ((1.0 - share).max(0.0) * wanted as f64) as u64;
    let mut gains = first_gains(instance, &missing, radius_m);
    let mut stops = Vec::new();
    while left > allowed {
        let Some((promised, at)) = gains.pop() else { break };
        let swept = swept_from(instance, &missing, lattice.cell(at), radius_m);
        let gain: u32 = swept.iter().map(|(_, samples)| samples.count_ones()).sum();
        if gain == 0 {
            continue;
        }
        if gain < promised {
            gains.push((gain, at));
            continue;
        }
        for (index, samples) in swept {
            let open = missing.entry(index).or_default();
            *open &= !samples;
        }
        left -= u64::from(gain);
        stops.push(lattice.cell(at));
    }
    stops
}

/// What each cell around missing ground would gain.
fn first_gains(instance: &Instance<'_>, missing: &Missing, radius_m: f64) -> BinaryHeap<(u32, usize)> {
    let lattice = instance.floor.lattice();
    let reachable = instance.reachable();
    let mut near: Vec<usize> = missing
        .keys()
        .flat_map(|&index| cells_around(instance, lattice.cell(index), radius_m))
        .filter(|&index| reachable[index])
        .collect();
    near.sort_unstable();
    near.dedup();
    near.into_iter()
        .map(|index| {
            let swept = swept_from(instance, missing, lattice.cell(index), radius_m);
            (swept.iter().map(|(_, samples)| samples.count_ones()).sum(), index)
        })
        .collect()
}

fn cells_around<'a>(
    instance: &'a Instance<'_>,
    cell: Cell,
    radius_m: f64,
) -> impl Iterator<Item = usize> + 'a {
    let lattice = instance.floor.lattice();
    let center = lattice.center(cell);
    let reach_m = radius_m + lattice.cell_m;
    let low = Point::new(center.x - reach_m, center.y - reach_m);
    let high = Point::new(center.x + reach_m, center.y + reach_m);
    lattice.cells_in_box(low, high).filter_map(move |cell| lattice.index(cell))
}

/// The missing samples that are swept from the centre of a cell.
fn swept_from(instance: &Instance<'_>, missing: &Missing, cell: Cell, radius_m: f64) -> Vec<(usize, u64)> {
    let lattice = instance.floor.lattice();
    let center = lattice.center(cell);
    cells_around(instance, cell, radius_m)
        .filter_map(|index| {
            let open = missing.get(&index)?;
            let swept = open & samples_swept_from(lattice, lattice.cell(index), center, radius_m);
            (swept != 0).then_some((index, swept))
        })
        .collect()
}

/// A place on a route: between point `at` and the next one.
#[derive(Debug, Clone, Copy)]
struct Branch {
    robot: usize,
    at: usize,
    place: Point,
    distance_m: f64,
}

/// Leads the nearest route to a place and back.
fn side_trip(transfers: &mut Transfers<'_, '_>, routes: &mut [Route], stop: Point) {
    let ways = branches(routes, stop).into_iter().filter_map(|branch| {
        let way = transfers.way(branch.place, stop)?;
        Some((branch, way))
    });
    let best = ways.min_by(|a, b| a.1.length_m.total_cmp(&b.1.length_m));
    let Some((branch, way)) = best else { return };
    let points = &mut routes[branch.robot].points;
    let ends_here = branch.at + 1 == points.len();
    let mut trip = vec![branch.place];
    trip.extend(&way.points);
    if !(ends_here && transfers.space().instance().mode == Mode::Cover) {
        trip.extend(way.points.iter().rev().skip(1));
    }
    trip.dedup();
    points.splice(branch.at + 1..branch.at + 1, trip);
    points.dedup_by(|a, b| (*a - *b).norm() < 1e-9);
}

/// Where routes come nearest to a place, in a straight line.
fn branches(routes: &[Route], stop: Point) -> Vec<Branch> {
    let mut found: Vec<Branch> = Vec::new();
    for (robot, route) in routes.iter().enumerate() {
        for (at, &from) in route.points.iter().enumerate() {
            let to = route.points.get(at + 1).copied().unwrap_or(from);
            let place = Segment::new(from, to).nearest(stop);
            found.push(Branch { robot, at, place, distance_m: (place - stop).norm() });
        }
    }
    found.sort_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
    found.truncate(CANDIDATES);
    found
}
