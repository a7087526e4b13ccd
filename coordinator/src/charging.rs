//! Batteries: who goes to charge when, where, and when it comes back.
//!
//! One rule, in one place: a robot goes when its charge falls below `minimum_desired_charging_level`, or earlier
//! when what is left would no longer carry it over the ground it is about to be granted and from there to a
//! station with `reserve_percent` to spare. It leaves the station at `sufficient_charging_level` while there is
//! work that it can reach, at `maximum_desired_charging_level` otherwise. A station serves one robot; the others
//! queue where they stand.

use crate::{
    Coordinator,
    config::Station,
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

/// Ways on a crowded floor are longer than the shortest ones.
const DETOUR_FACTOR: f64 = 1.3;
/// A docked robot that is not charged for so long reports the station broken.
const NO_CHARGE_S: f64 = 4.0;
/// After so many tries in a row nobody waits for a station any more.
pub(crate) const FAILURES_MAX: u32 = 2;
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
        }
    }
}

impl Coordinator {
    /// The cells of the stations that work.
    pub(crate) fn station_cells(&self) -> Vec<Cell> {
        (0..self.stations.len())
            .filter(|&station| self.stations[station].broken_until.is_none())
            .filter_map(|station| self.station_cell(station))
            .collect()
    }

    fn station_cell(&self, station: usize) -> Option<Cell> {
        self.floor.nearest_drivable(&self.config.mission.map, self.stations[station].position)
    }

    pub(crate) fn measure_station_moves(&mut self) {
        let cells = self.station_cells();
        self.station_moves = way::moves_to(&self.floor, &cells, |cell| self.is_open_ground(cell));
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
        self.forget_errand(index);
        self.orphan_route(index);
        let charge = self.robots[index].charge_percent();
        let text = format!("{charge:.0} % left, {reason}");
        if self.assign_station(now, index) {
            self.need_plan(now, Cause::of(ReplanCause::CauseLowBattery, index, &text));
        }
    }

    fn must_charge(&self, index: RobotIndex) -> Option<&'static str> {
        let robot = &self.robots[index];
        let levels = robot.factsheet.as_ref()?.battery_charging?;
        let charge = robot.charge_percent();
        if charge < levels.minimum_desired_charging_level {
            return Some("below the desired minimum");
        }
        let home = self.percent_to_station(index)?;
        (charge < home + self.config.timing.reserve_percent).then_some("just enough to reach a station")
    }

    /// Share of the battery that it takes to drive the base and one more node, and on to the nearest station.
    fn percent_to_station(&self, index: RobotIndex) -> Option<f64> {
        let robot = &self.robots[index];
        let energy = robot.energy?;
        let mut points: Vec<Point> = robot.route.base().map(|node| node.point).collect();
        points.extend(robot.route.next_edge().map(|(edge, _)| edge.to));
        let moves = self.moves_to_station(*points.last()?)?;
        let cell_m = self.floor.lattice().cell_m;
        let way_m = (f64::from(moves) + 2.0) * cell_m * DETOUR_FACTOR;
        Some(energy.along_percent(&points) + energy.home_percent(way_m, cell_m))
    }

    /// Moves to the nearest station from the cell a place lies in, or from one beside it where no body stands there.
    fn moves_to_station(&self, place: Point) -> Option<u32> {
        let lattice = self.floor.lattice();
        let cell = lattice.cell_at(place)?;
        let from =
            |cell| lattice.index(cell).map(|index| self.station_moves[index]).filter(|&m| m != u32::MAX);
        let beside = || {
            let around = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| Cell::new(cell.x + dx, cell.y + dy)));
            around.filter_map(from).max().map(|moves| moves + 1)
        };
        from(cell).or_else(beside)
    }

    /// Gives a robot the best station, or a place in its queue. False when no station works.
    fn assign_station(&mut self, now: Timestamp, index: RobotIndex) -> bool {
        let Some(from) = self.start_cell(index) else { return false };
        let best = (0..self.stations.len())
            .filter(|&station| self.stations[station].broken_until.is_none())
            .filter_map(|station| Some((station, self.way_to_station(from, station)?)))
            .min_by_key(|(station, way)| {
                let state = &self.stations[*station];
                let waiting = state.queue.len() + usize::from(state.occupied_by.is_some());
                (waiting, way.len())
            });
        let Some((station, way)) = best else { return false };
        if self.stations[station].occupied_by.is_none() {
            self.send_to_station(index, station, &way);
        } else {
            self.stations[station].queue.push_back(index);
            let robot = &mut self.robots[index];
            robot.errand = Errand::Queue(station);
            robot.route.cut_horizon();
            let text = format!("for {}", self.stations[station].id);
            let id = self.robots[index].id.clone();
            self.announcer.event(now, EventLevel::EventInfo, &id, "QUEUED", &text);
        }
        true
    }

    fn way_to_station(&self, from: Cell, station: usize) -> Option<Vec<Cell>> {
        let goal = self.station_cell(station)?;
        way::nearest(&self.floor, from, |cell| cell == goal, |cell| self.is_open_ground(cell))
    }

    fn send_to_station(&mut self, index: RobotIndex, station: usize, way: &[Cell]) {
        self.stations[station].occupied_by = Some(index);
        self.robots[index].errand = Errand::ToStation(station);
        self.robots[index].uncharged_since = None;
        let begins_at_base_end = self.robots[index].route.base_end().is_some_and(|node| node.cell.is_some());
        let cells = &way[usize::from(begins_at_base_end)..];
        let ending = Ending::Charge(self.stations[station].id.clone());
        let dock = self.stations[station].position;
        self.send_along(index, cells, Some(dock), ending);
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
            self.assign_station(now, index);
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
            if !self.assign_station(now, waiting) {
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
        let Some(levels) = robot.factsheet.as_ref().and_then(|sheet| sheet.battery_charging) else { return };
        let wanted = self.has_open_work() || !self.stations[station].queue.is_empty();
        let enough =
            if wanted { levels.sufficient_charging_level } else { levels.maximum_desired_charging_level };
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
        if let Some(way) = way::nearest(&self.floor, from, far, |cell| self.is_open_ground(cell)) {
            self.send_along(index, &way, None, Ending::Stay);
        }
    }

    fn check_queue(&mut self, _now: Timestamp, index: RobotIndex, station: usize) {
        let state = &self.stations[station];
        let first = state.queue.front() == Some(&index);
        if !first || state.occupied_by.is_some() || state.broken_until.is_some() {
            return;
        }
        let Some(from) = self.start_cell(index) else { return };
        if let Some(way) = self.way_to_station(from, station) {
            self.stations[station].queue.pop_front();
            self.send_to_station(index, station, &way);
        }
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
