//! Batteries: who goes to charge when, where, and when it comes back.
//!
//! One rule, in one place: before each piece of ground is granted, the battery must carry the robot over it and from
//! its end to a station, by the way that is open now, with `reserve_percent` to spare (and the wait for the station,
//! when others are before it); where it would not, the robot breaks off, anywhere in a lane. It also goes when its
//! charge falls below `minimum_desired_charging_level`. It leaves the station when it has enough for what is left of its
//! work, at the latest at `sufficient_charging_level` while there is work that it can reach, at
//! `maximum_desired_charging_level` otherwise. A station serves one robot; the
//! others queue where they stand. A robot whose way to every station is blocked drives up to what is in the way, and
//! goes on when that is seen free.
//!
//! The rule is safe because what home costs never rises faster along a way than driving it costs; the reserve pays
//! for detours around people and other robots, and for errors of the energy model.

use crate::{
    Coordinator,
    config::Station,
    energy::Energy,
    ledger::RobotIndex,
    replan::Cause,
    robot::{Errand, Phase},
    route::Ending,
    way,
};
use protocol::{
    Timestamp,
    v1::{EventLevel, ReplanCause},
};
use std::{collections::VecDeque, time::Duration};
use terrain::{Cell, Point};

/// A docked robot that is not charged for so long reports the station broken.
const NO_CHARGE_S: f64 = 4.0;
/// After so many tries in a row nobody waits for a station any more.
pub(crate) const FAILURES_MAX: u32 = 2;
/// How long a charge takes until one was seen, seconds.
const CHARGE_S: f64 = 300.0;
/// A broken station is tried again after this.
const TRY_AGAIN: Duration = Duration::from_mins(2);

/// A station as the coordinator sees it.
#[derive(Debug)]
pub(crate) struct StationState {
    pub(crate) id: String,
    pub(crate) position: Point,
    pub(crate) occupied_by: Option<RobotIndex>,
    pub(crate) queue: VecDeque<RobotIndex>,
    pub(crate) broken_until: Option<Timestamp>,
    /// How often in a row it gave no power.
    pub(crate) failures: u32,
    /// Moves from each cell to it over ground that is open now.
    moves: Vec<u32>,
    /// When its robot began to charge, and with how much, percent.
    charge_began: Option<(Timestamp, f64)>,
    /// What it gives, percent of a battery a second, as seen last.
    rate_percent_per_s: Option<f64>,
}

impl StationState {
    pub(crate) fn new(station: &Station) -> Self {
        Self {
            id: station.id.clone(),
            position: station.position,
            occupied_by: None,
            queue: VecDeque::new(),
            broken_until: None,
            failures: 0,
            moves: Vec::new(),
            charge_began: None,
            rate_percent_per_s: None,
        }
    }

    /// Takes in how much its robot has by now.
    fn note_rate(&mut self, now: Timestamp, charge_percent: f64) {
        let Some((began, from_percent)) = self.charge_began else { return };
        let (seconds, percent) = (now.secs_since(began), charge_percent - from_percent);
        if seconds > NO_CHARGE_S && percent > 0.0 {
            self.rate_percent_per_s = Some(percent / seconds);
        }
    }

    fn works(&self) -> bool {
        self.broken_until.is_none()
    }
}

/// What it takes to get charged at a station.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Trip {
    station: usize,
    /// The way there, and standing until the station is free, share of a full battery.
    percent: f64,
    /// Until it can charge.
    seconds: f64,
}

impl Coordinator {
    /// The cells of the stations that work.
    pub(crate) fn station_cells(&self) -> Vec<Cell> {
        (0..self.stations.len())
            .filter(|&station| self.stations[station].works())
            .filter_map(|station| self.station_cell(station))
            .collect()
    }

    pub(crate) fn station_cell(&self, station: usize) -> Option<Cell> {
        self.floor.nearest_drivable(&self.config.mission.map, self.stations[station].position)
    }

    /// Works out anew how far each cell is from each station; to be called when ground was closed or opened.
    pub(crate) fn measure_station_moves(&mut self) {
        for station in 0..self.stations.len() {
            let cell: Vec<Cell> = self.station_cell(station).into_iter().collect();
            self.stations[station].moves =
                way::moves_to(self.roads(), &cell, |cell| self.is_open_ground(cell));
        }
    }

    /// Sends a robot to charge in time.
    pub(crate) fn watch_battery(&mut self, now: Timestamp, index: RobotIndex) {
        let works = matches!(self.robots[index].errand, Errand::Cover | Errand::Look(_) | Errand::Home);
        if !works
            || self.stations.is_empty()
            || !self.is_running()
            || self.robots[index].route.order_id() == 0
        {
            return;
        }
        let Some(reason) = self.must_charge(index) else { return };
        let planned = self.comes_to_break(index).map(|planned| planned.station);
        let covers = self.robots[index].errand == Errand::Cover;
        self.forget_errand(index);
        if covers {
            self.keep_for_later(index);
        }
        let charge = self.robots[index].charge_percent();
        let text = format!("{charge:.0} % left, {reason}");
        if self.assign_station(now, index, planned) {
            self.need_plan(now, Cause::of(ReplanCause::CauseLowBattery, index, &text));
        } else {
            self.give_rest_away(index);
        }
    }

    fn must_charge(&self, index: RobotIndex) -> Option<&'static str> {
        let robot = &self.robots[index];
        let levels = robot.factsheet.as_ref()?.battery_charging?;
        if robot.charge_percent() < levels.minimum_desired_charging_level {
            return Some("below the desired minimum");
        }
        if self.comes_to_break(index).is_some() {
            return Some("at the place where the plan goes to charge");
        }
        (!self.lasts_for_next(index)).then_some("just enough to reach a station")
    }

    /// Whether a robot that works may be granted one more piece of ground: whether its battery would carry it over
    /// that, and from there to a station, with the reserve to spare.
    pub(crate) fn lasts_for_next(&self, index: RobotIndex) -> bool {
        let robot = &self.robots[index];
        let works = matches!(robot.errand, Errand::Cover | Errand::Look(_) | Errand::Home);
        let Some(energy) = robot.energy.filter(|_| works && !self.stations.is_empty()) else { return true };
        let points = self.points_to_next(index);
        let Some(&last) = points.last() else { return true };
        let spare = robot.charge_percent()
            - energy.along_percent(&points, robot.heading_rad(), true)
            - self.config.timing.reserve_percent;
        spare >= 0.0 && (self.surely_gets_home(&energy, last, spare) || self.gets_home(index, &points, spare))
    }

    /// From where the robot is, over its base, to the end of the next edge.
    fn points_to_next(&self, index: RobotIndex) -> Vec<Point> {
        let robot = &self.robots[index];
        let base = robot.route.base().skip(1).map(|node| node.point);
        let next = robot.route.next_edge().map(|(edge, _)| edge.to);
        robot.position().into_iter().chain(base).chain(next).collect()
    }

    /// The quick answer, from a bound; it may be no where the truth is yes.
    pub(crate) fn surely_gets_home(&self, energy: &Energy, from: Point, spare_percent: f64) -> bool {
        self.home_at_most_percent(energy, from).is_some_and(|percent| percent <= spare_percent)
    }

    /// No more than this is needed to get to some station and until that is free, percent; `None` when none is known to be
    /// within reach.
    pub(crate) fn home_at_most_percent(&self, energy: &Energy, from: Point) -> Option<f64> {
        let cell_m = self.floor.lattice().cell_m;
        let at =
            self.floor.lattice().index(self.station_road(from)?).expect("a road's cells are on the lattice");
        let known = self
            .stations
            .iter()
            .enumerate()
            .filter(|(_, station)| station.works() && station.moves[at] != u32::MAX);
        let percent = known.map(|(number, station)| {
            let way_m = (f64::from(station.moves[at]) + 3.0) * cell_m;
            energy.at_most_percent(way_m, cell_m) + energy.standing_percent(self.wait_s(number))
        });
        percent.reduce(f64::min)
    }

    fn gets_home(&self, index: RobotIndex, points: &[Point], spare_percent: f64) -> bool {
        let trips = self.trips(index, points);
        if trips.is_empty() {
            return self.may_go_on_without_way_home(index, spare_percent);
        }
        trips.iter().any(|trip| trip.percent <= spare_percent)
    }

    /// No way to a station is open. As long as the battery would last for the way as it is without zones, there is
    /// time for that to change.
    fn may_go_on_without_way_home(&self, index: RobotIndex, spare_percent: f64) -> bool {
        let robot = &self.robots[index];
        let (Some(energy), Some(from)) = (robot.energy, self.start_cell(index)) else { return true };
        let cell_m = self.floor.lattice().cell_m;
        let Some(way) = self.way_as_if_open(from) else { return true };
        let way_m: f64 = self.points_along(&way).windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
        energy.at_most_percent(way_m + 3.0 * cell_m, cell_m) <= spare_percent
    }

    /// The way to the nearest station that works, as if no ground were closed.
    fn way_as_if_open(&self, from: Cell) -> Option<Vec<Cell>> {
        let stations = self.station_cells();
        way::nearest(self.roads_as_if_open(), from, |cell| stations.contains(&cell), |_| true)
    }

    /// The cell near a point from which a way to a station is known.
    fn station_road(&self, from: Point) -> Option<Cell> {
        let lattice = self.floor.lattice();
        let own = lattice.cell_at(from)?;
        let known = |cell: Cell| {
            lattice
                .index(cell)
                .is_some_and(|at| self.stations.iter().any(|station| station.moves[at] != u32::MAX))
        };
        let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| Cell::new(own.x + dx, own.y + dy)));
        std::iter::once(own).chain(around).find(|&cell| known(cell))
    }

    /// What it takes to each station that works and can be reached, from the end of some points.
    fn trips(&self, index: RobotIndex, points: &[Point]) -> Vec<Trip> {
        let robot = &self.robots[index];
        let heading_rad = heading_after(points).or(robot.heading_rad());
        let (Some(energy), Some(motion), Some(&last)) = (robot.energy, robot.motion(), points.last()) else {
            return Vec::new();
        };
        let Some(road) = self.station_road(last) else { return Vec::new() };
        let trip = |station: usize| {
            let way = way::down(self.roads(), &self.stations[station].moves, road)?;
            let dock = std::iter::once(self.stations[station].position);
            let places: Vec<Point> =
                std::iter::once(last).chain(self.points_along(&way)).chain(dock).collect();
            let way_s = motion.path_s(&places, heading_rad);
            let stands_s = (self.wait_s(station) - way_s).max(0.0);
            let percent =
                energy.along_percent(&places, heading_rad, false) + energy.standing_percent(stands_s);
            Some(Trip { station, percent, seconds: way_s + stands_s })
        };
        (0..self.stations.len()).filter(|&station| self.stations[station].works()).filter_map(trip).collect()
    }

    /// How long until a station is free for one more robot, seconds.
    pub(crate) fn wait_s(&self, station: usize) -> f64 {
        self.wait_before_s(station, RobotIndex::MAX)
    }

    /// How long until a station is free for a robot of its queue, seconds; for one that is not in it, as for one more.
    pub(crate) fn wait_before_s(&self, station: usize, index: RobotIndex) -> f64 {
        let state = &self.stations[station];
        let before = state.occupied_by.iter().chain(&state.queue).take_while(|&&robot| robot != index);
        before.map(|&robot| self.charge_s(station, robot)).sum()
    }

    /// How long a charge of so much takes at a station as seen so far, seconds.
    pub(crate) fn usual_charge_s(&self, percent: f64) -> f64 {
        let rates = self.stations.iter().filter_map(|station| station.rate_percent_per_s);
        rates.reduce(f64::max).map_or(CHARGE_S, |rate| percent / rate)
    }

    /// Whether a station works, and nobody is at it or waits for it.
    pub(crate) fn is_vacant(&self, station: usize) -> bool {
        let state = &self.stations[station];
        state.works() && state.occupied_by.is_none() && state.queue.is_empty()
    }

    pub(crate) fn station_works(&self, station: usize) -> bool {
        self.stations[station].works()
    }

    /// How long a robot still charges, seconds.
    pub(crate) fn charge_s(&self, station: usize, index: RobotIndex) -> f64 {
        let robot = &self.robots[index];
        let levels = robot.factsheet.as_ref().and_then(|sheet| sheet.battery_charging);
        let enough = levels.map_or(100.0, |levels| levels.sufficient_charging_level);
        let missing = (enough - robot.charge_percent()).max(0.0);
        self.stations[station].rate_percent_per_s.map_or(CHARGE_S, |rate| missing / rate)
    }

    /// Gives a robot the planned station, if it lasts to that, or the best one, or a place in its queue. False when no
    /// station works.
    fn assign_station(&mut self, now: Timestamp, index: RobotIndex, planned: Option<usize>) -> bool {
        let Some(trip) = self.best_trip(index, planned) else { return self.wait_for_a_way(now, index) };
        let station = trip.station;
        if self.stations[station].occupied_by.is_none() {
            if let Some(way) = self.start_cell(index).and_then(|from| self.way_to_station(from, station)) {
                self.send_to_station(index, station, &way);
                return true;
            }
            return self.wait_for_a_way(now, index);
        }
        self.robots[index].route.cut_horizon();
        self.queue_for(now, index, station, "");
        true
    }

    /// The station at which a robot can charge first, of those that its battery carries it to; the planned one if it is
    /// one of these.
    fn best_trip(&self, index: RobotIndex, planned: Option<usize>) -> Option<Trip> {
        let from = self.robots[index].route.base().map(|node| node.point).collect::<Vec<Point>>();
        let trips = self.trips(index, &from);
        let charge = self.robots[index].charge_percent() - self.config.timing.reserve_percent;
        let in_reach = trips.iter().filter(|trip| trip.percent <= charge);
        let rank = |trip: &Trip| (Some(trip.station) != planned, trip.seconds);
        in_reach
            .min_by(|a, b| rank(a).0.cmp(&rank(b).0).then(rank(a).1.total_cmp(&rank(b).1)))
            .or_else(|| trips.iter().min_by(|a, b| a.percent.total_cmp(&b.percent)))
            .copied()
    }

    fn queue_for(&mut self, now: Timestamp, index: RobotIndex, station: usize, why: &str) {
        self.stations[station].queue.push_back(index);
        self.robots[index].errand = Errand::Queue(station);
        let text = format!("for {}{why}", self.stations[station].id);
        let id = self.robots[index].id.clone();
        self.announcer.event(now, EventLevel::EventInfo, &id, "QUEUED", &text);
    }

    /// No way to a station is open: the robot drives up to what is in the way, where it sees when that is gone.
    fn wait_for_a_way(&mut self, now: Timestamp, index: RobotIndex) -> bool {
        let Some(from) = self.start_cell(index) else { return false };
        let Some(way) = self.way_as_if_open(from) else { return false };
        let goal = way.last().copied();
        let nearest = (0..self.stations.len())
            .find(|&station| self.stations[station].works() && self.station_cell(station) == goal);
        let Some(station) = nearest else { return false };
        let open = way.iter().skip(1).take_while(|&&cell| self.is_open_ground(cell)).count();
        let begins_at_base_end = self.robots[index].route.base_end().is_some_and(|node| node.cell.is_some());
        let up_to = open.saturating_sub(1).max(usize::from(!begins_at_base_end)) + 1;
        self.send_along(index, &way[..up_to.min(way.len())], None, Ending::Stay);
        self.queue_for(now, index, station, ", its way there is blocked");
        true
    }

    fn way_to_station(&self, from: Cell, station: usize) -> Option<Vec<Cell>> {
        way::down(self.roads(), &self.stations[station].moves, from)
    }

    fn send_to_station(&mut self, index: RobotIndex, station: usize, way: &[Cell]) {
        self.stations[station].occupied_by = Some(index);
        self.robots[index].errand = Errand::ToStation(station);
        self.robots[index].uncharged_since = None;
        let ending = Ending::Charge(self.stations[station].id.clone());
        let dock = self.stations[station].position;
        self.send_along(index, way, Some(dock), ending);
    }

    /// A robot's errand is void; whatever it had reserved for it is free again.
    pub(crate) fn forget_errand(&mut self, index: RobotIndex) {
        for station in &mut self.stations {
            station.queue.retain(|&waiting| waiting != index);
            if station.occupied_by == Some(index) {
                station.occupied_by = None;
            }
        }
        self.robots[index].errand = Errand::Cover;
    }

    /// A robot's route was taken away: one that was to charge gets a new way, any other is free for work.
    pub(crate) fn resume_errand(&mut self, now: Timestamp, index: RobotIndex) {
        let charges = matches!(self.robots[index].errand, Errand::ToStation(_) | Errand::Queue(_));
        self.forget_errand(index);
        if charges {
            self.assign_station(now, index, None);
        }
    }

    /// Looks at all robots that charge, wait for it, or have done with it.
    pub(crate) fn check_stations(&mut self, now: Timestamp) {
        self.mend_stations(now);
        for index in 0..self.robots.len() {
            if self.robots[index].phase != Phase::Ready {
                continue;
            }
            match self.robots[index].errand {
                Errand::ToStation(station) => self.check_docking(now, index, station),
                Errand::Charging(station) => self.check_charging(now, index, station),
                Errand::Queue(station) => self.check_queue(now, index, station),
                Errand::Cover | Errand::Look(_) | Errand::Home => {}
            }
        }
        self.free_left_stations();
    }

    fn mend_stations(&mut self, now: Timestamp) {
        let mut changed = false;
        for station in &mut self.stations {
            if station.broken_until.is_some_and(|until| now >= until) {
                station.broken_until = None;
                changed = true;
            }
        }
        if changed {
            self.measure_station_moves();
        }
    }

    fn check_docking(&mut self, now: Timestamp, index: RobotIndex, station: usize) {
        let robot = &self.robots[index];
        if !robot.route.is_done() {
            return;
        }
        let dock = self.stations[station].position;
        if robot.position().is_some_and(|position| (position - dock).norm() > 0.3) {
            self.resume_errand(now, index);
            return;
        }
        let robot = &self.robots[index];
        if robot.state.as_ref().is_some_and(|state| state.charging) {
            self.robots[index].errand = Errand::Charging(station);
            self.robots[index].uncharged_since = None;
            self.stations[station].failures = 0;
            self.stations[station].charge_began = Some((now, self.robots[index].charge_percent()));
            let id = self.robots[index].id.clone();
            let text =
                format!("at {}, {:.0} %", self.stations[station].id, self.robots[index].charge_percent());
            self.announcer.event(now, EventLevel::EventInfo, &id, "CHARGING", &text);
        } else {
            self.watch_dead_station(now, index, station);
        }
    }

    fn watch_dead_station(&mut self, now: Timestamp, index: RobotIndex, station: usize) {
        let since = *self.robots[index].uncharged_since.get_or_insert(now);
        if now.secs_since(since) < NO_CHARGE_S {
            return;
        }
        self.robots[index].uncharged_since = None;
        self.stations[station].broken_until = Some(now + TRY_AGAIN);
        self.stations[station].failures += 1;
        self.measure_station_moves();
        let id = self.robots[index].id.clone();
        let text = format!("{} gives no power; tried again in 120 s", self.stations[station].id);
        self.announcer.event(now, EventLevel::EventWarning, &id, "STATION OUT OF ORDER", &text);
        let queue = std::mem::take(&mut self.stations[station].queue);
        self.forget_errand(index);
        for waiting in std::iter::once(index).chain(queue) {
            self.forget_errand(waiting);
            if !self.assign_station(now, waiting, None) {
                // Stay: the station is tried again.
                self.stations[station].queue.push_back(waiting);
                self.robots[waiting].errand = Errand::Queue(station);
            }
        }
    }

    fn check_charging(&mut self, now: Timestamp, index: RobotIndex, station: usize) {
        let robot = &self.robots[index];
        if robot.state.as_ref().is_some_and(|state| !state.charging) {
            let full = robot.charge_percent() >= 99.5;
            if !full {
                self.watch_dead_station(now, index, station);
                return;
            }
        }
        let robot = &mut self.robots[index];
        robot.uncharged_since = None;
        let charge = robot.charge_percent();
        self.stations[station].note_rate(now, charge);
        let robot = &self.robots[index];
        let Some(levels) = robot.factsheet.as_ref().and_then(|sheet| sheet.battery_charging) else { return };
        let wanted = self.has_open_work() || !self.stations[station].queue.is_empty();
        let enough =
            if wanted { levels.sufficient_charging_level } else { levels.maximum_desired_charging_level };
        let enough = self.percent_for_rest(index).map_or(enough, |rest| rest.min(enough));
        if charge >= enough {
            self.robots[index].errand = Errand::Cover;
            let text = format!("{charge:.0} % at {}", self.stations[station].id);
            self.need_plan(now, Cause::of(ReplanCause::CauseCharged, index, &text));
            if !self.stations[station].queue.is_empty() {
                self.leave_station(index, station);
            }
        }
    }

    fn has_open_work(&self) -> bool {
        self.ledger.progress().cells_unassigned
            + self.ledger.progress().cells_assigned
            + self.ledger.progress().cells_lost
            > 0
    }

    /// Drives off a station that others wait for.
    fn leave_station(&mut self, index: RobotIndex, station: usize) {
        let Some(from) = self.start_cell(index) else { return };
        let dock = self.stations[station].position;
        let lattice = *self.floor.lattice();
        let far = |cell: Cell| (lattice.center(cell) - dock).norm() > 3.0 * self.separation_m();
        if let Some(way) = way::nearest(self.roads(), from, far, |cell| self.is_open_ground(cell)) {
            self.send_along(index, &way, None, Ending::Stay);
        }
    }

    /// The first in the queue whose way is open gets the station.
    fn check_queue(&mut self, _now: Timestamp, index: RobotIndex, station: usize) {
        let state = &self.stations[station];
        if state.occupied_by.is_some() || !state.works() {
            return;
        }
        let way =
            |robot: RobotIndex| self.start_cell(robot).and_then(|from| self.way_to_station(from, station));
        let next = state.queue.iter().find(|&&robot| self.is_open_for(robot, station));
        if next != Some(&index) {
            return;
        }
        if let Some(way) = way(index) {
            self.stations[station].queue.retain(|&waiting| waiting != index);
            self.send_to_station(index, station, &way);
        }
    }

    fn is_open_for(&self, index: RobotIndex, station: usize) -> bool {
        let at = self.start_cell(index).and_then(|from| self.floor.lattice().index(from));
        at.is_some_and(|at| self.stations[station].moves[at] != u32::MAX)
    }

    /// A station is free when its robot has another errand and has driven off.
    fn free_left_stations(&mut self) {
        let separation = self.separation_m();
        for station in 0..self.stations.len() {
            let Some(index) = self.stations[station].occupied_by else { continue };
            let here = self.stations[station].position;
            let robot = &self.robots[index];
            let bound = matches!(robot.errand, Errand::ToStation(at) | Errand::Charging(at) if at == station);
            let away = robot.position().is_none_or(|position| (position - here).norm() > separation);
            if !bound && away {
                self.stations[station].occupied_by = None;
            }
        }
    }
}

/// The heading in which the last of some points is reached.
fn heading_after(points: &[Point]) -> Option<f64> {
    let steps = points.windows(2).rev().map(|pair| pair[1] - pair[0]);
    steps.filter(|step| step.norm() > 1e-9).map(|step| step.y.atan2(step.x)).next()
}
