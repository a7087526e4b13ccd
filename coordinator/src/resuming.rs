//! Work that waits for its robot: a robot that goes to charge keeps what is left of its route, and takes part in plans as one
//! that begins beside its station once it is charged.
//!
//! ```text
//!   route  ══════╪═══════════        breaks off at ╪: the rest becomes what it resumes
//!                └──▶ station ──▶ CHARGED: a plan with the rest as what it drives already
//! ```
//!
//! Others take the rest, or parts of it, when that makes the mission shorter: the planner knows when the robot is back
//! ([`planner::Start::available_in_s`]). What a robot resumes that will not come back has lost its robot, like any route.

use crate::{
    Coordinator,
    ledger::RobotIndex,
    robot::{Errand, Phase},
    route::Waypoint,
    way,
};
use planner::Start;
use terrain::{Cell, Point};

/// Charged beyond what a robot's rest takes by the energy model, percent: detours are not part of that.
const SPARE_PERCENT: f64 = 10.0;

impl Coordinator {
    /// Keeps a robot's route from the end of its base on.
    pub(crate) fn keep_for_later(&mut self, index: RobotIndex) {
        let route = &self.robots[index].route;
        let rest: Vec<Waypoint> = route.base_end().into_iter().chain(route.horizon()).copied().collect();
        self.robots[index].resumes = if rest.len() > 1 { rest } else { Vec::new() };
    }

    /// What a robot was to resume is given away.
    pub(crate) fn give_rest_away(&mut self, index: RobotIndex) {
        let rest = std::mem::take(&mut self.robots[index].resumes);
        self.orphan(&rest);
    }

    /// Whether a robot that charges, or is about to, will cover again.
    pub(crate) fn will_resume(&self, index: RobotIndex) -> bool {
        self.back_in_s(index).is_some()
    }

    /// Robots that plans count on: those that can cover, and those that will when they are charged.
    pub(crate) fn team(&self, blocked: &[bool]) -> Vec<RobotIndex> {
        let takes_part = |&index: &RobotIndex| {
            if self.robots[index].can_cover() {
                self.start_cell(index).is_some()
            } else {
                self.back_at(index, blocked).is_some()
            }
        };
        (0..self.robots.len()).filter(takes_part).collect()
    }

    /// Where a robot that charges begins again, and when: the nearest cell to its station that is not `blocked`.
    pub(crate) fn back_at(&self, index: RobotIndex, blocked: &[bool]) -> Option<Start> {
        let available_in_s = self.back_in_s(index)?;
        let lattice = self.floor.lattice();
        let free = |cell: Cell| lattice.index(cell).is_some_and(|at| !blocked[at]);
        let out = way::nearest(self.roads(), self.station_cell(self.station_of(index)?)?, free, |cell| {
            self.is_open_ground(cell)
        })?;
        Some(Start { available_in_s, ..Start::at(*out.last()?) })
    }

    fn station_of(&self, index: RobotIndex) -> Option<usize> {
        match self.robots[index].errand {
            Errand::ToStation(station) | Errand::Charging(station) | Errand::Queue(station) => Some(station),
            Errand::Cover | Errand::Look(_) | Errand::Home => None,
        }
    }

    /// How long until a robot that charges can cover again, seconds; `None` for one that does not, or may never.
    pub(crate) fn back_in_s(&self, index: RobotIndex) -> Option<f64> {
        let robot = &self.robots[index];
        let station = self.station_of(index)?;
        if robot.phase != Phase::Ready || robot.stuck || !self.station_works(station) {
            return None;
        }
        let waits_s =
            if matches!(robot.errand, Errand::Queue(_)) { self.wait_before_s(station, index) } else { 0.0 };
        let way: Vec<Point> = robot.route.ahead().map(|node| node.point).collect();
        Some(waits_s + robot.motion()?.path_s(&way, None) + self.charge_s(station, index))
    }

    /// What all of the work that waits for a robot takes, and the way to a station from its end, with the reserve, percent.
    pub(crate) fn percent_for_rest(&self, index: RobotIndex) -> Option<f64> {
        let robot = &self.robots[index];
        let (energy, levels) = (robot.energy?, robot.factsheet.as_ref()?.battery_charging?);
        let rest = robot.position().into_iter().chain(robot.resumes.iter().map(|place| place.point));
        let rest: Vec<Point> = rest.collect();
        let &last = rest.get(2..)?.last()?;
        let home = self.home_at_most_percent(&energy, last)?;
        let kept_back = self.config.timing.reserve_percent.max(levels.minimum_desired_charging_level);
        Some(energy.along_percent(&rest, robot.heading_rad(), true) + home + kept_back + SPARE_PERCENT)
    }

    /// The places at which a robot will cover: of its route, or of what it resumes.
    pub(crate) fn places_ahead(&self, index: RobotIndex) -> Vec<Waypoint> {
        let robot = &self.robots[index];
        if !robot.resumes.is_empty() {
            return robot.resumes.clone();
        }
        if robot.can_cover() {
            robot.route.base_end().into_iter().chain(robot.route.horizon()).copied().collect()
        } else {
            Vec::new()
        }
    }

    /// Whether work waits for a robot that charges.
    pub(crate) fn work_waits(&self) -> bool {
        (0..self.robots.len()).any(|index| !self.robots[index].resumes.is_empty() && self.will_resume(index))
    }
}
