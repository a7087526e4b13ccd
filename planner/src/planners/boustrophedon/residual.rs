//! What lanes leave out, along slanted walls and round small obstacles: places from which it is swept, by side trips from where
//! a route comes nearest.
//!
//! The places are centres of cells, the one from which most is gained first, until the share asked for is swept. From all of
//! them together everything that can be asked for is swept, so this always gets there.

use crate::{Instance, Mode, Plan, Route, VerifyError, transfers::Transfers, verify};
use std::collections::BinaryHeap;
use terrain::{Cell, Lattice, Point, Segment, SweptRaster, samples_swept_from};

/// So many places of routes are looked at for a side trip.
const CANDIDATES: usize = 4;

/// Adds side trips to routes until they sweep `share` of what is to be swept. Routes have at least one point each.
pub(in crate::planners) fn sweep_the_rest(
    transfers: &mut Transfers<'_, '_>,
    routes: &mut [Route],
    share: f64,
) {
    let instance = transfers.space().instance();
    // A bump may leave a little out that the straight line swept; out and back never does.
    for trips in [&[Trip::Bump, Trip::OutAndBack][..], &[Trip::Bump, Trip::OutAndBack], &[Trip::OutAndBack]] {
        for stop in stops(instance, routes, share) {
            side_trip(transfers, routes, instance.center(stop), trips);
        }
    }
}

/// How a route gets to a place beside it.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Trip {
    /// Leaves its line some way before, and comes back to it some way after.
    Bump,
    /// Goes there from where it is nearest, and back.
    OutAndBack,
}

/// Side trips to cells that are left out where a plan goes along the lattice all the way: there, cells are what counts.
pub(in crate::planners) fn visit_gaps(transfers: &mut Transfers<'_, '_>, plan: &mut Plan) {
    let instance = transfers.space().instance();
    while let Err(VerifyError::Gap(cell)) = verify(instance, plan) {
        let before = plan.clone();
        for (route, start) in plan.routes.iter_mut().zip(&instance.starts) {
            if route.points.is_empty() {
                route.points.push(instance.place(start));
            }
        }
        side_trip(transfers, &mut plan.routes, instance.center(cell), &[Trip::OutAndBack]);
        let idle = plan.routes.iter_mut().zip(&before.routes).filter(|(route, _)| route.points.len() < 2);
        idle.for_each(|(route, before)| route.clone_from(before));
        if *plan == before {
            return;
        }
    }
}

/// Takes the routes away of robots that stay where they are, unless what they sweep there is asked for. Routes of one point have
/// not been counted on so far: where nobody else sweeps it, a side trip to where a robot stands anyway is no trip.
pub(in crate::planners) fn drop_idle(instance: &Instance<'_>, plan: &mut Plan) {
    if plan.routes.iter().all(|route| route.points.len() != 1) {
        return;
    }
    let mut without = plan.clone();
    let idle = without.routes.iter_mut().filter(|route| route.points.len() < 2);
    idle.for_each(|route| *route = Route::default());
    if is_whole(instance, &without) {
        *plan = without;
    }
}

/// Whether all is swept that has to be, by the measure of verify. Charges come later, or are there already: they do not count
/// here.
pub(in crate::planners) fn is_whole(instance: &Instance<'_>, plan: &Plan) -> bool {
    let without_battery = Instance { battery: None, ..instance.clone() };
    !matches!(verify(&without_battery, plan), Err(VerifyError::NotSwept { .. } | VerifyError::Gap(_)))
}

/// Cells from whose centres the rest is swept.
fn stops(instance: &Instance<'_>, routes: &[Route], share: f64) -> Vec<Cell> {
    let mut rest = Rest::new(instance, routes);
    let allowed = ((1.0 - share).max(0.0) * rest.wanted as f64) as u64;
    let mut stops = Vec::new();
    // Places some way apart first; all of them where these are not enough.
    for stride in [rest.stride(), 1] {
        let mut gains = rest.first_gains(stride);
        while rest.left > allowed {
            let Some((promised, at)) = gains.pop() else { break };
            let gain = rest.gain(at);
            if gain > 0 && gain < promised {
                gains.push((gain, at));
            } else if gain > 0 {
                rest.sweep(at);
                stops.push(instance.floor.lattice().cell(at));
            }
        }
    }
    stops
}

/// What is still to be swept.
struct Rest<'a, 'i> {
    instance: &'a Instance<'i>,
    /// Samples, per cell.
    missing: Vec<u64>,
    wanted: u64,
    left: u64,
    /// What a tool over the centre of a cell sweeps: column and row difference, and samples.
    tool: Vec<(i32, i32, u64)>,
}

impl<'a, 'i> Rest<'a, 'i> {
    fn new(instance: &'a Instance<'i>, routes: &[Route]) -> Self {
        let lattice = instance.floor.lattice();
        let mut raster = SweptRaster::new(*lattice);
        let radius_m = instance.floor.tool_width_m() / 2.0;
        for pair in routes.iter().flat_map(|route| route.points.windows(2)) {
            raster.sweep(Segment::new(pair[0], pair[1]), radius_m, |_| {});
        }
        let wanted = |index: usize| if instance.visit[index] { instance.wanted(index) } else { 0 };
        let missing: Vec<u64> =
            (0..lattice.len()).map(|index| wanted(index) & !raster.samples(index)).collect();
        let count =
            |samples: &mut dyn Iterator<Item = u64>| samples.map(|bits| u64::from(bits.count_ones())).sum();
        Self {
            instance,
            wanted: count(&mut (0..lattice.len()).map(wanted)),
            left: count(&mut missing.iter().copied()),
            missing,
            tool: stencil(lattice, radius_m),
        }
    }

    /// A quarter of the tool, in cells.
    fn stride(&self) -> i32 {
        let floor = self.instance.floor;
        ((floor.tool_width_m() / 4.0 / floor.lattice().cell_m) as i32).max(1)
    }

    /// Cells around one, and the missing samples of theirs that are swept from its centre.
    fn swept_from(&self, at: usize) -> impl Iterator<Item = (usize, u64)> + '_ {
        let lattice = self.instance.floor.lattice();
        let cell = lattice.cell(at);
        self.tool.iter().filter_map(move |&(dx, dy, samples)| {
            let index = lattice.index(Cell::new(cell.x + dx, cell.y + dy))?;
            Some((index, self.missing[index] & samples))
        })
    }

    fn gain(&self, at: usize) -> u32 {
        self.swept_from(at).map(|(_, samples)| samples.count_ones()).sum()
    }

    fn sweep(&mut self, at: usize) {
        let swept: Vec<(usize, u64)> = self.swept_from(at).collect();
        for (index, samples) in swept {
            self.missing[index] &= !samples;
            self.left -= u64::from(samples.count_ones());
        }
    }

    /// What reachable cells around missing ground would gain; only every `stride`th column and row.
    fn first_gains(&self, stride: i32) -> BinaryHeap<(u32, usize)> {
        let lattice = self.instance.floor.lattice();
        let mut near = vec![false; lattice.len()];
        for (index, _) in self.missing.iter().enumerate().filter(|&(_, &open)| open != 0) {
            let cell = lattice.cell(index);
            for &(dx, dy, _) in &self.tool {
                if let Some(index) = lattice.index(Cell::new(cell.x + dx, cell.y + dy)) {
                    near[index] = true;
                }
            }
        }
        let reachable = self.instance.reachable();
        let on_stride = |index: usize| {
            let cell = lattice.cell(index);
            cell.x % stride == 0 && cell.y % stride == 0
        };
        let stands = (0..near.len()).filter(|&index| near[index] && reachable[index] && on_stride(index));
        stands.map(|index| (self.gain(index), index)).collect()
    }
}

/// What a tool over the centre of a cell sweeps, as in [`Rest::tool`].
fn stencil(lattice: &Lattice, radius_m: f64) -> Vec<(i32, i32, u64)> {
    let around = Lattice { origin: Point::origin(), ..*lattice };
    let center = around.center(Cell::new(0, 0));
    let longest = lattice.columns.max(lattice.rows);
    let reach = (radius_m / lattice.cell_m + 0.5).ceil().min(f64::from(longest)) as i32;
    (-reach..=reach)
        .flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy)))
        .map(|(dx, dy)| (dx, dy, samples_swept_from(&around, Cell::new(dx, dy), center, radius_m)))
        .filter(|&(_, _, samples)| samples != 0)
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

/// Leads the route that loses least time to a place beside it.
fn side_trip(transfers: &mut Transfers<'_, '_>, routes: &mut [Route], stop: Point, trips: &[Trip]) {
    let mut best: Option<(f64, Branch, Vec<Point>)> = None;
    let mut found = 0;
    for branch in branches(routes, stop) {
        if found >= CANDIDATES {
            break;
        }
        for &trip in trips {
            let points = &routes[branch.robot].points;
            let Some(made) = detour(transfers, points, branch, stop, trip) else { break };
            found += usize::from(trip == trips[0]);
            let added_s = added_s(transfers.space().instance(), points, branch.at, &made);
            if best.as_ref().is_none_or(|(least_s, ..)| added_s < *least_s) {
                best = Some((added_s, branch, made));
            }
        }
    }
    let Some((_, branch, made)) = best else { return };
    let points = &mut routes[branch.robot].points;
    let behind = branch.at + 1;
    points.splice(behind..behind, made);
    points.dedup_by(|a, b| (*a - *b).norm() < 1e-9);
}

/// The points of a trip, between point `branch.at` and the next one.
fn detour(
    transfers: &mut Transfers<'_, '_>,
    points: &[Point],
    branch: Branch,
    stop: Point,
    trip: Trip,
) -> Option<Vec<Point>> {
    let instance = transfers.space().instance();
    let Some(&next) = points.get(branch.at + 1) else {
        let mut way = transfers.way(branch.place, stop)?.points;
        if instance.mode == Mode::CoverAndReturn {
            way.extend(way.clone().into_iter().rev().skip(1));
        }
        return Some(way);
    };
    let aside_m = if trip == Trip::Bump { instance.floor.tool_width_m() } else { 0.0 };
    let beside = |end: Point| {
        let way = end - branch.place;
        if way.norm() <= aside_m { end } else { branch.place + way * (aside_m / way.norm()) }
    };
    let (before, after) = (beside(points[branch.at]), beside(next));
    let mut made = transfers.way(before, stop)?.points;
    made.extend(transfers.way(stop, after)?.points);
    Some(made)
}

/// Time that a route loses by what is put in after point `at`, seconds.
fn added_s(instance: &Instance<'_>, points: &[Point], at: usize, made: &[Point]) -> f64 {
    let before = &points[at.saturating_sub(1)..=at];
    let after = &points[at + 1..points.len().min(at + 3)];
    let path_s = |between: &[Point]| instance.motion.path_s(&[before, between, after].concat(), None);
    path_s(made) - path_s(&[])
}

/// Where each route comes nearest to a place, in a straight line; the nearest first.
fn branches(routes: &[Route], stop: Point) -> Vec<Branch> {
    let mut found: Vec<Branch> = Vec::new();
    for (robot, route) in routes.iter().enumerate() {
        let branch = |(at, &from): (usize, &Point)| {
            let to = route.points.get(at + 1).copied().unwrap_or(from);
            let place = Segment::new(from, to).nearest(stop);
            Branch { robot, at, place, distance_m: (place - stop).norm() }
        };
        let mut of_route: Vec<Branch> = route.points.iter().enumerate().map(branch).collect();
        of_route.sort_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
        found.extend(of_route.into_iter().take(CANDIDATES));
    }
    found.sort_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
    found
}
