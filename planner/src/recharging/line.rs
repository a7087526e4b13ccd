//! One robot's route as a line of places at which it may be broken off.

use super::{
    FirstBreakOff,
    break_off::{Break, OutOfRange, Place, Tour, Ways},
    homeward::{Homeward, corner_s, ramps_s},
    work::Work,
};
use crate::{Battery, Instance, Mode, PlanError, Route, Start};
use terrain::{MotionModel, Point, angle_between};

/// Places off the lattice are at most this many tool widths apart.
const APART_TOOLS: f64 = 1.0;
/// How often breaks are chosen anew, with more to spare, when a stretch takes longer than its places told.
const TRIES: usize = 8;

/// A line and what is known of its places.
pub(super) struct Line<'a> {
    instance: &'a Instance<'a>,
    robot: usize,
    points: Vec<Point>,
    /// Per point, whether it was put in between those of the route.
    is_between: Vec<bool>,
    /// Per piece between two points, whether it does work.
    works: Vec<bool>,
    /// Per point and station: the way there.
    ways: Vec<Vec<Option<Vec<Point>>>>,
}

impl<'a> Line<'a> {
    pub(super) fn new(
        instance: &'a Instance<'a>,
        robot: usize,
        points: &[Point],
        homeward: &mut dyn Homeward,
        work: &mut Work<'a>,
    ) -> Self {
        let apart_m =
            if work.is_along_lattice() { f64::INFINITY } else { APART_TOOLS * instance.floor.tool_width_m() };
        let (points, is_between) = with_points_between(points, apart_m);
        let works = work.drive(&points);
        let stations = 0..instance.stations.len();
        let mut ways =
            |&point: &Point| stations.clone().map(|station| homeward.way(point, station)).collect();
        let mut ways: Vec<Vec<Option<Vec<Point>>>> = points.iter().map(&mut ways).collect();
        for station in stations.clone() {
            for at in 1..points.len() {
                lead_along(&mut ways, &points, station, at, at - 1);
            }
            for at in (1..points.len()).rev() {
                lead_along(&mut ways, &points, station, at - 1, at);
            }
        }
        Self { instance, robot, points, is_between, works, ways }
    }

    /// The route with its charges. What the places tell is exact but for bends that are driven through, which may take a
    /// little longer than a stop to turn: then breaks are chosen again with more to spare.
    pub(super) fn charged(&self, battery: &Battery) -> Result<Route, PlanError> {
        self.broken_off(battery).map(|(_, route)| route).map_err(|found| self.out_of_range(battery, found))
    }

    /// The first break of that route; `None` where none is needed, or none helps.
    pub(super) fn first_break_off(&self, battery: &Battery) -> Option<FirstBreakOff> {
        let ahead_m =
            |place: usize| self.points[place..].windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
        let Break { place, station } = self.broken_off(battery).ok()?.0.into_iter().next()?;
        Some(FirstBreakOff { ahead_m: ahead_m(place), station })
    }

    fn broken_off(&self, battery: &Battery) -> Result<(Vec<Break>, Route), OutOfRange> {
        let mut spare_s = 0.0;
        let mut tried = 0;
        loop {
            let tour = self.tour(battery, spare_s);
            let breaks = tour.breaks(battery.break_off)?;
            let route = self.route(&breaks, &tour);
            let over_s = self.over_s(battery, &route);
            tried += 1;
            if over_s <= 1e-7 || tried == TRIES {
                return Ok((breaks, route));
            }
            // Other breaks leave other bends to a stretch: what is to spare has to outgrow all of them.
            spare_s = 2.0 * spare_s + over_s;
        }
    }

    /// How much longer the worst stretch takes than the battery lasts, seconds.
    fn over_s(&self, battery: &Battery, route: &Route) -> f64 {
        let over_s = |(number, points): (usize, &[Point])| {
            let is_first = number == 0;
            let lasts_s = if is_first { self.first_s(battery) } else { battery.budget_s() };
            self.instance.path_s(points, self.start().heading_rad.filter(|_| is_first)) - lasts_s
        };
        route.stretches().enumerate().map(over_s).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Seconds that the battery lasts until the first charge.
    fn first_s(&self, battery: &Battery) -> f64 {
        self.start().charge_s.unwrap_or(f64::INFINITY).min(battery.capacity_s) - battery.reserve_s
    }

    fn tour(&self, battery: &Battery, spare_s: f64) -> Tour {
        let (instance, last) = (self.instance, self.points.len() - 1);
        let stations = 0..instance.stations.len();
        let (at_s, leaves_s) = self.times_s();
        let goes_on = self.goes_on();
        let place = |point: usize| Place {
            at_s: at_s[point],
            leaves_s: leaves_s[point],
            goes_on: goes_on[point],
            ways: stations.clone().map(|station| self.ways(point, goes_on[point], station)).collect(),
            by_here_s: stations
                .clone()
                .flat_map(|from| stations.clone().map(move |to| self.by_s(point, from, to)))
                .collect(),
        };
        let home_s = |station| self.home_s(last, station);
        let nearest_s = stations.clone().map(home_s).fold(f64::INFINITY, f64::min);
        let spare_s = spare_s + ramps_s(&instance.motion);
        Tour {
            places: (0..last).map(place).collect(),
            end_s: at_s[last],
            left_at_end_s: if instance.mode == Mode::Cover { nearest_s } else { 0.0 },
            visit_s: instance.stations.iter().map(|station| battery.charge_s + station.queue_s).collect(),
            budget_s: battery.budget_s() - spare_s,
            first_budget_s: self.first_s(battery) - spare_s,
        }
    }

    fn start(&self) -> &Start {
        &self.instance.starts[self.robot]
    }

    fn motion(&self) -> &MotionModel {
        &self.instance.motion
    }

    /// Per point but the last, the point from which there is work again.
    fn goes_on(&self) -> Vec<usize> {
        let mut goes_on: Vec<usize> = (0..self.works.len()).collect();
        for point in (0..self.works.len().saturating_sub(1)).rev() {
            if !self.works[point] {
                goes_on[point] = goes_on[point + 1];
            }
        }
        goes_on
    }

    /// Seconds from the start to each point, and until it is left when the robot has turned; at full speed but for
    /// the corners.
    fn times_s(&self) -> (Vec<f64>, Vec<f64>) {
        let (mut at_s, mut leaves_s) = (vec![0.0], Vec::new());
        for (point, pair) in self.points.windows(2).enumerate() {
            let length_m = (pair[1] - pair[0]).norm();
            let before_rad = self.arriving_rad(point);
            let angle_rad = before_rad.map_or(0.0, |rad| angle_between(rad, self.leaving_rad(point)).abs());
            let corner_s = if angle_rad > 1e-6 { corner_s(self.motion(), angle_rad) } else { 0.0 };
            leaves_s.push(at_s[point] + corner_s);
            let ground_s = self.instance.path_s(pair, None) - self.motion().run_s(length_m);
            at_s.push(leaves_s[point] + length_m / self.motion().speed_m_per_s + ground_s);
        }
        (at_s, leaves_s)
    }

    /// Heading with which a point is left; not for the last one.
    fn leaving_rad(&self, point: usize) -> f64 {
        heading_rad(self.points[point], self.points[point + 1])
    }

    /// Heading with which a point is reached; `None` at the start when the first turn is free.
    fn arriving_rad(&self, point: usize) -> Option<f64> {
        if point == 0 { self.start().heading_rad } else { Some(self.leaving_rad(point - 1)) }
    }

    /// The way from one place to a station and back to another, with the turns from and into the line.
    fn ways(&self, from: usize, to: usize, station: usize) -> Ways {
        Ways { home_s: self.home_s(from, station), back_s: self.back_s(to, station) }
    }

    /// From one station by a point to another, seconds; turning at the first is part of the charge.
    fn by_s(&self, point: usize, from: usize, to: usize) -> f64 {
        let (Some(out), Some(home)) = (&self.ways[point][from], &self.ways[point][to]) else {
            return f64::INFINITY;
        };
        let turn_s = match (&out[..], &home[..]) {
            ([here, before, ..], [_, next, ..]) => {
                self.motion().turn_s(angle_between(heading_rad(*before, *here), heading_rad(*here, *next)))
            }
            _ => 0.0,
        };
        self.instance.path_s(out, None) + turn_s + self.instance.path_s(home, None)
    }

    fn home_s(&self, point: usize, station: usize) -> f64 {
        let Some(way) = &self.ways[point][station] else { return f64::INFINITY };
        let [from, to, ..] = way[..] else { return 0.0 };
        let angle_rad = self.arriving_rad(point).map_or(0.0, |rad| angle_between(rad, heading_rad(from, to)));
        self.instance.path_s(way, None) + self.motion().turn_s(angle_rad)
    }

    fn back_s(&self, point: usize, station: usize) -> f64 {
        let Some(way) = &self.ways[point][station] else { return f64::INFINITY };
        let [to, from, ..] = way[..] else { return 0.0 };
        let angle_rad = angle_between(heading_rad(from, to), self.leaving_rad(point));
        self.instance.path_s(way, None) + self.motion().turn_s(angle_rad)
    }

    fn route(&self, breaks: &[Break], tour: &Tour) -> Route {
        let mut route = Route::default();
        let mut from = 0;
        for &Break { place, station } in breaks {
            self.follow(&mut route.points, from, place);
            from = tour.places[place].goes_on;
            let way = |point: usize| self.ways[point][station].as_deref().expect("a break has ways");
            route.points.extend(way(place).iter().skip(1));
            route.charges.push(route.points.len() - 1);
            route.points.extend(way(from).iter().rev().skip(1).take(way(from).len().saturating_sub(2)));
        }
        self.follow(&mut route.points, from, self.points.len() - 1);
        route
    }

    /// Goes along the line from one place to another.
    fn follow(&self, points: &mut Vec<Point>, from: usize, to: usize) {
        let kept = (from..=to).filter(|&point| point == from || point == to || !self.is_between[point]);
        points.extend(kept.map(|point| self.points[point]));
    }

    fn out_of_range(&self, battery: &Battery, found: OutOfRange) -> PlanError {
        let place = self.points[found.place];
        let cell = self.instance.floor.lattice().cell_at(place).expect("a route stays on the floor");
        let needed_s = battery.capacity_s + found.takes_s - found.lasts_s;
        PlanError::OutOfRange { cell, place, capacity_s: battery.capacity_s, needed_s }
    }
}

/// A place in a nook from which no way was found gets the one of the place beside it on the line.
fn lead_along(
    ways: &mut [Vec<Option<Vec<Point>>>],
    points: &[Point],
    station: usize,
    at: usize,
    beside: usize,
) {
    if let (None, Some(way)) = (&ways[at][station], &ways[beside][station]) {
        ways[at][station] = Some(std::iter::once(points[at]).chain(way.iter().copied()).collect());
    }
}

fn heading_rad(from: Point, to: Point) -> f64 {
    (to.y - from.y).atan2(to.x - from.x)
}

/// The same line with points between, so that no two are farther apart, and which these are; repeated points left out.
fn with_points_between(points: &[Point], apart_m: f64) -> (Vec<Point>, Vec<bool>) {
    let mut finer = vec![(points[0], false)];
    for pair in points.windows(2) {
        let step = pair[1] - pair[0];
        let pieces = (step.norm() / apart_m).ceil().max(1.0) as u32;
        if step.norm() > 1e-9 {
            let at = |piece: u32| pair[0] + step * (f64::from(piece) / f64::from(pieces));
            finer.extend((1..pieces).map(|piece| (at(piece), true)));
            finer.push((pair[1], false));
        }
    }
    finer.into_iter().unzip()
}
