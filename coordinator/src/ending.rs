//! How a mission begins and ends: muster, residual passes, looking again at what is blocked, and an honest end.
//!
//! A mission ends COMPLETED only when every cell that a tool can reach is swept. While a robot can reach an open
//! cell, it is planned again (a residual pass). Open cells behind zones are looked at again, later and later,
//! up to `looks_max` times a zone; only then are they given up, each with its reason. Planners keep to one piece of
//! the lattice: into another one that is left, a robot is sent by a passage, and covers it from within.

use crate::{
    Coordinator, Output,
    charging::FAILURES_MAX,
    ledger::RobotIndex,
    presence::TRIES_MAX,
    replan::Cause,
    robot::{Errand, Phase},
    route::Ending,
    way,
};
use protocol::{
    Timestamp,
    v1::{EventLevel, MissionState, ReplanCause, UnreachableReason},
};
use std::{collections::BTreeMap, time::Duration};
use terrain::{Cell, Point, Segment};

/// A residual pass that covers nothing twice in a row shows that what is left cannot be swept.
const FRUITLESS_MAX: u32 = 2;
/// A robot is sent so often in vain into a piece of the lattice that has something left.
const SENT_INTO_MAX: u32 = 3;
/// First wait before a zone is looked at again; doubled after each look.
const LOOK_AGAIN_S: f64 = 15.0;
/// From so near a scan shows whether a cell is free, metres.
const LOOK_FROM_M: f64 = 1.3;
/// Robots that had this much less to do than others make the fleet be planned anew, seconds.
const IMBALANCE_S: f64 = 40.0;
/// At least this long between two such plans; doubled each time that the work turns out to be such as cannot be shared.
const REBALANCE_APART: Duration = Duration::from_secs(30);
const REBALANCE_DOUBLED_MAX: u32 = 5;
/// A mission in which nothing moves forward for so long ends.
const STALLED_S: f64 = 420.0;
/// … and one in which nothing is covered for so long, though batteries are charged.
const FRUITLESS_S: f64 = 3600.0;
/// So long may the robots take home.
const HOME_MAX_S: f64 = 300.0;

/// What the checks for the end remember.
#[derive(Debug, Default)]
pub(crate) struct IdleChecks {
    covered_before_pass: f64,
    fruitless: u32,
    rebalanced: Timestamp,
    /// How often in a row the most that a robot had to do was hardly less after such a plan, and how much it was, s.
    in_vain: u32,
    most_s: f64,
    looked: Option<Timestamp>,
    homeward: Option<Timestamp>,
    /// What was covered and charged when something last moved forward, and when that was.
    progress: (f64, f64),
    progress_at: Timestamp,
    covered_at: Timestamp,
    /// How often in a row a robot was sent into each piece of the lattice in vain, and what was covered before.
    sent_into: BTreeMap<u32, u32>,
    covered_before_sent: f64,
    /// Whether another piece to go to was looked for since something last changed.
    searched: bool,
}

impl IdleChecks {
    /// Something changed that makes another residual pass worth while.
    pub(crate) fn new_ground(&mut self) {
        self.fruitless = 0;
        self.looked = None;
        self.searched = false;
    }

    /// The planner had nothing to plan at this moment.
    pub(crate) fn look_at(&mut self, now: Timestamp) {
        self.looked = Some(now);
        self.searched = false;
    }
}

impl Coordinator {
    /// Begins when the expected fleet is there, or the wait for it is over.
    pub(crate) fn check_start(&mut self, now: Timestamp) {
        if self.mission_began.is_some() {
            return;
        }
        let timing = &self.config.timing;
        let ready = self.robots.iter().filter(|robot| robot.phase == Phase::Ready).count();
        if ready == 0 {
            let waited_s = self.started.map_or(0.0, |start| now.secs_since(start));
            if waited_s > timing.join_timeout_s {
                let text = format!(
                    "no agent has joined within {:.0} s; start agents with `oxplow agent --id … --connect …`, \
                     and check that they connect to this coordinator",
                    timing.join_timeout_s
                );
                self.fail(now, &text);
            }
            return;
        }
        let all = self.robots.iter().all(|robot| robot.phase == Phase::Ready);
        let waited_s = self.first_joined.map_or(0.0, |first| now.secs_since(first));
        if all || waited_s > timing.muster_s {
            self.mission_began = Some(now);
            self.state = MissionState::Active;
            let missing: Vec<&str> = self
                .robots
                .iter()
                .filter(|robot| robot.phase != Phase::Ready)
                .map(|robot| robot.id.as_str())
                .collect();
            let mut text = format!("{ready} robots");
            if !missing.is_empty() {
                text = format!("{text}, without {}", missing.join(", "));
            }
            self.name_what_is_out_of_reach(now);
            self.name_what_is_out_of_range(now);
            self.need_plan(now, Cause::fleet(ReplanCause::CauseStart, &text));
        }
    }

    /// Looks whether there is anything left to do, and what.
    pub(crate) fn check_end(&mut self, now: Timestamp, _out: &mut Vec<Output>) {
        let undecided = self.replanning.is_busy() || self.sightings.is_pending();
        if self.mission_began.is_none() || self.state == MissionState::Paused || undecided {
            return;
        }
        self.check_abandoned(now);
        if self.ended() {
            return;
        }
        if self.ledger.open_cells().next().is_none() {
            self.go_home_or_finish(now);
        } else if self.has_stalled(now) {
            self.give_up_the_rest(now);
        } else if self.all_routes_done() && !self.work_waits() {
            self.continue_with_what_is_left(now);
        } else {
            self.check_balance(now);
        }
    }

    /// Nothing was covered and nothing charged for very long: whatever holds the fleet up, the mission ends, and
    /// says what is left.
    fn has_stalled(&mut self, now: Timestamp) -> bool {
        let charge: f64 = self.robots.iter().map(crate::robot::Robot::charge_percent).sum();
        let covered = self.ledger.progress().covered_m2;
        let (covered_before, charge_before) = self.idle_checks.progress;
        let forward = covered > covered_before + 1e-9 || charge > charge_before + 1.0;
        if forward || charge < charge_before {
            self.idle_checks.progress = (covered, charge);
        }
        let first = self.idle_checks.progress_at == Timestamp::ZERO;
        if forward || first {
            self.idle_checks.progress_at = now;
        }
        if covered > covered_before + 1e-9 || first {
            self.idle_checks.covered_at = now;
        }
        now.secs_since(self.idle_checks.progress_at) > STALLED_S
            || now.secs_since(self.idle_checks.covered_at) > FRUITLESS_S
    }

    fn check_abandoned(&mut self, now: Timestamp) {
        let alone_s = now.secs_since(self.last_healthy);
        if !self.has_healthy_robot() && alone_s > self.config.timing.abandoned_after_s {
            let open = self.ledger.open_cells().count();
            if open == 0 {
                self.finish(now);
            } else {
                let text = format!("no robot is left for {alone_s:.0} s; {open} cells are not covered");
                self.give_up_all(UnreachableReason::NoRobotCapable);
                self.fail(now, &text);
            }
        }
    }

    fn all_routes_done(&self) -> bool {
        self.robots.iter().filter(|robot| robot.phase == Phase::Ready && !robot.stuck).all(|robot| {
            let waits_for_ever =
                robot.wait.is_some_and(|wait| matches!(wait.on, crate::robot::Blocker::Zone(_)));
            robot.route.is_done() && robot.hold.is_none()
                || matches!(robot.errand, Errand::Charging(_) | Errand::Queue(_))
                || waits_for_ever
        })
    }

    /// Every route is driven and something is left.
    fn continue_with_what_is_left(&mut self, now: Timestamp) {
        self.count_finished_looks(now);
        let tried = self.idle_checks.looked.is_some_and(|at| now.secs_since(at) < 5.0);
        if !tried && !self.coverers().is_empty() && self.residual_may_help() {
            let text = format!("{} cells left", self.ledger.open_cells().count());
            self.need_plan(now, Cause::fleet(ReplanCause::CauseResidual, &text));
        } else if self.go_where_work_is_left(now) {
            // It covers that when it is there.
        } else if self.somebody_comes_back() {
            // Charging robots take up the rest.
        } else if self.look_at_zones(now) || self.zones_still_wait(now) {
            // A robot is on its way to look, or will go again.
        } else if self.has_healthy_robot() {
            self.give_up_the_rest(now);
        }
    }

    /// Sends a robot into another piece of the lattice where something is left, the nearest one; whether one is on its way.
    fn go_where_work_is_left(&mut self, now: Timestamp) -> bool {
        let idle = self.idle_coverers();
        if self.passages.is_empty() || idle.is_empty() || self.idle_checks.searched {
            return false;
        }
        self.idle_checks.searched = true;
        self.forget_sent_if_covered();
        let best = idle
            .into_iter()
            .filter_map(|robot| Some((robot, self.way_to_other_work(robot)?)))
            .min_by_key(|(_, way)| way.len());
        let Some((robot, way)) = best else { return false };
        let goal = way[way.len() - 1];
        let piece = self.floor.lattice().index(goal).map(|index| self.pieces[index]);
        *self.idle_checks.sent_into.entry(piece.expect("a way keeps to the lattice")).or_default() += 1;
        self.send_along(robot, &way, None, Ending::Stay);
        self.idle_checks.new_ground();
        let text = format!("to cell {goal}, where no plan leads");
        let id = self.robots[robot].id.clone();
        self.announcer.event(now, EventLevel::EventInfo, &id, "GOES", &text);
        true
    }

    /// Something was covered since a robot was last sent: it was not in vain.
    fn forget_sent_if_covered(&mut self) {
        let covered = self.ledger.progress().covered_m2;
        if covered > self.idle_checks.covered_before_sent + 1e-9 {
            self.idle_checks.sent_into.clear();
        }
        self.idle_checks.covered_before_sent = covered;
    }

    /// The way to the nearest cell that must be visited in a piece of the lattice other than the robot's.
    fn way_to_other_work(&self, robot: RobotIndex) -> Option<Vec<Cell>> {
        let from = self.start_cell(robot)?;
        let (lattice, pieces) = (self.floor.lattice(), &self.pieces);
        let here = pieces[lattice.index(from)?];
        let sent = |piece: u32| self.idle_checks.sent_into.get(&piece).copied().unwrap_or(0);
        let moves = way::moves_to(self.roads(), &[from], |cell| self.is_open_ground(cell));
        let elsewhere: Vec<bool> = (0..pieces.len())
            .map(|index| {
                moves[index] != u32::MAX && pieces[index] != here && sent(pieces[index]) < SENT_INTO_MAX
            })
            .collect();
        let wanted = self.stands_for_all(&elsewhere);
        let is_wanted = |cell: Cell| lattice.index(cell).is_some_and(|index| wanted[index]);
        way::nearest(self.roads(), from, is_wanted, |cell| self.is_open_ground(cell))
    }

    /// Robots that can cover and have nothing to do.
    fn idle_coverers(&self) -> Vec<RobotIndex> {
        let is_idle = |&robot: &RobotIndex| {
            self.robots[robot].errand == Errand::Cover && self.robots[robot].route.is_done()
        };
        self.coverers().into_iter().filter(is_idle).collect()
    }

    fn residual_may_help(&mut self) -> bool {
        let covered = self.ledger.progress().covered_m2;
        if covered > self.idle_checks.covered_before_pass + 1e-9 {
            self.idle_checks.fruitless = 0;
        }
        self.idle_checks.covered_before_pass = covered;
        self.idle_checks.fruitless += 1;
        self.idle_checks.fruitless <= FRUITLESS_MAX
    }

    /// Whether robots that cannot work now will be able to later, by themselves.
    fn somebody_comes_back(&self) -> bool {
        let charges = |robot: &crate::robot::Robot| {
            let will_charge = match robot.errand {
                Errand::Charging(_) => true,
                Errand::Queue(station) | Errand::ToStation(station) => {
                    self.stations[station].failures < FAILURES_MAX
                }
                Errand::Cover | Errand::Look(_) | Errand::Home => false,
            };
            robot.phase == Phase::Ready && (will_charge || robot.stuck && robot.tries < TRIES_MAX)
        };
        let waits = |robot: &crate::robot::Robot| {
            robot.phase == Phase::Suspect || robot.phase == Phase::Lost && !robot.held.is_empty()
        };
        self.robots.iter().any(|robot| charges(robot) || waits(robot))
    }

    fn count_finished_looks(&mut self, now: Timestamp) {
        for robot in &mut self.robots {
            let Errand::Look(zone) = robot.errand else { continue };
            if !robot.route.is_done() {
                continue;
            }
            robot.errand = Errand::Cover;
            if let Some(zone) = self.zones.get_mut(zone) {
                zone.looks += 1;
                let wait_s = LOOK_AGAIN_S * f64::from(1_u32 << zone.looks.min(10)) / 2.0;
                zone.next_look = now + Duration::from_secs_f64(wait_s);
            }
            self.idle_checks.fruitless = 0;
        }
    }

    /// Sends robots to see whether zones are free that keep cells from being covered.
    fn look_at_zones(&mut self, now: Timestamp) -> bool {
        let looks_max = self.config.timing.looks_max;
        let due: Vec<u64> = self
            .zones
            .iter()
            .filter(|zone| zone.looks < looks_max && now >= zone.next_look)
            .map(|zone| zone.id)
            .collect();
        let mut sent = self.robots.iter().any(|robot| matches!(robot.errand, Errand::Look(_)));
        for zone in due {
            let taken = self.robots.iter().any(|robot| robot.errand == Errand::Look(zone));
            if !taken {
                sent |= self.send_to_look(now, zone);
            }
        }
        sent
    }

    fn send_to_look(&mut self, now: Timestamp, zone: u64) -> bool {
        let best = self
            .idle_coverers()
            .into_iter()
            .filter_map(|robot| Some((robot, self.way_to_look(robot, zone)?)))
            .min_by_key(|(_, way)| way.len());
        let Some((robot, way)) = best else {
            if let Some(zone) = self.zones.get_mut(zone) {
                zone.looks += 1; // nobody gets near enough
                zone.next_look = now + Duration::from_secs_f64(LOOK_AGAIN_S);
            }
            return false;
        };
        self.send_along(robot, &way, None, Ending::Stay);
        self.robots[robot].errand = Errand::Look(zone);
        let id = self.robots[robot].id.clone();
        self.announcer.event(
            now,
            EventLevel::EventInfo,
            &id,
            "LOOKS",
            &format!("whether zone {zone} is free"),
        );
        true
    }

    /// The way to the nearest cell from which a cell of a zone can be seen; none at all where there is no such cell
    /// and the robot sees one from where it stands, as in a passage.
    fn way_to_look(&self, robot: RobotIndex, zone: u64) -> Option<Vec<Cell>> {
        let from = self.start_cell(robot)?;
        let lattice = self.floor.lattice();
        let zone = self.zones.iter().find(|other| other.id == zone)?;
        let centers: Vec<_> = zone.cells.iter().map(|&index| lattice.center(lattice.cell(index))).collect();
        let sees = |eye: Point, reach_m: f64| {
            centers.iter().any(|&center| {
                (center - eye).norm() <= reach_m
                    && self.config.mission.map.capsule_is_free(Segment::new(eye, center), 0.02)
            })
        };
        let is_lookout = |cell: Cell| sees(lattice.center(cell), LOOK_FROM_M);
        let way = way::nearest(self.roads(), from, is_lookout, |cell| self.is_open_ground(cell));
        let scan = self.robots[robot].state.as_ref().and_then(|state| state.scan.as_ref());
        let reach_m = scan.map_or(0.0, |scan| scan.range_max_m - self.floor.body_radius_m());
        way.or_else(|| self.robots[robot].position().filter(|&eye| sees(eye, reach_m)).map(|_| Vec::new()))
    }

    fn zones_still_wait(&self, _now: Timestamp) -> bool {
        let looks_max = self.config.timing.looks_max;
        self.zones.iter().any(|zone| zone.looks < looks_max)
    }

    fn give_up_the_rest(&mut self, now: Timestamp) {
        let open: Vec<usize> = self.ledger.open_cells().collect();
        for index in open {
            let reason = self.why_not(index);
            self.ledger.give_up(index, reason);
        }
        self.go_home_or_finish(now);
    }

    /// Why an open cell stays uncovered: zones hide it, or no body fits there.
    fn why_not(&self, index: usize) -> UnreachableReason {
        let lattice = self.floor.lattice();
        let from = lattice.cell(index);
        if self.zones.holds(index) {
            return UnreachableReason::Obstacle;
        }
        if !self.is_in_range(index) {
            return UnreachableReason::OutOfRange;
        }
        let starts: Vec<Cell> =
            self.robots.iter().filter_map(|robot| lattice.cell_at(robot.position()?)).collect();
        let at_all = way::moves_to(self.roads_as_if_open(), &starts, |_| true);
        let neighbours_reached = |cell: Cell| {
            (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy))).any(|(dx, dy)| {
                let near = Cell::new(cell.x + dx, cell.y + dy);
                lattice.index(near).is_some_and(|near| at_all[near] != u32::MAX)
            })
        };
        let in_the_way = self.zones.iter().next().is_some() || self.robots.iter().any(|robot| robot.stuck);
        if neighbours_reached(from) && in_the_way {
            UnreachableReason::Obstacle
        } else {
            UnreachableReason::TooNarrow
        }
    }

    fn give_up_all(&mut self, reason: UnreachableReason) {
        let open: Vec<usize> = self.ledger.open_cells().collect();
        for index in open {
            self.ledger.give_up(index, reason);
        }
    }

    /// A robot stands idle while others have long to go: plan anew, if that is worth it.
    fn check_balance(&mut self, now: Timestamp) {
        if now.since(self.idle_checks.rebalanced) < REBALANCE_APART * (1 << self.idle_checks.in_vain) {
            return;
        }
        let Some(idle) = self.coverers().into_iter().find(|&robot| self.robots[robot].route.is_done()) else {
            return;
        };
        let works = |&robot: &RobotIndex| self.robots[robot].can_cover() || self.will_resume(robot);
        let most_s = (0..self.robots.len()).filter(works).map(|robot| self.robots[robot].remaining_s);
        let most_s = most_s.fold(0.0, f64::max);
        if most_s > IMBALANCE_S {
            let shared = most_s < 0.6 * self.idle_checks.most_s;
            let doubled = (self.idle_checks.in_vain + 1).min(REBALANCE_DOUBLED_MAX);
            self.idle_checks.in_vain = if shared || self.idle_checks.most_s == 0.0 { 0 } else { doubled };
            self.idle_checks.most_s = most_s;
            self.idle_checks.rebalanced = now;
            let text = format!("is done while another has {most_s:.0} s to go");
            self.need_plan(now, Cause::of(ReplanCause::CauseFinishedEarly, idle, &text));
        }
    }

    fn go_home_or_finish(&mut self, now: Timestamp) {
        if self.config.mission.return_to_start && self.send_home(now) {
            return;
        }
        self.finish(now);
    }

    /// Sends all robots to where they joined; false when they are there, or the time for it is over.
    fn send_home(&mut self, now: Timestamp) -> bool {
        let began = *self.idle_checks.homeward.get_or_insert(now);
        if now.secs_since(began) > HOME_MAX_S {
            return false;
        }
        let mut away = false;
        for index in 0..self.robots.len() {
            away |= self.robots[index].phase == Phase::Ready
                && !self.robots[index].stuck
                && self.keep_heading_home(index);
        }
        away
    }

    fn keep_heading_home(&mut self, index: RobotIndex) -> bool {
        let robot = &self.robots[index];
        let (Some(home), Some(position)) = (robot.home, robot.position()) else { return false };
        if (home - position).norm() < 0.1 && robot.route.is_done() {
            return false;
        }
        match robot.errand {
            Errand::Home => !robot.route.is_done(),
            Errand::Cover | Errand::Look(_) => {
                let goal = self.floor.nearest_drivable(&self.config.mission.map, home);
                let from = self.start_cell(index);
                let (Some(from), Some(goal)) = (from, goal) else { return false };
                let open = |cell| self.is_open_ground(cell);
                let Some(way) = way::nearest(self.roads(), from, |cell| cell == goal, open) else {
                    return false;
                };
                self.send_along(index, &way, Some(home), Ending::Stay);
                self.robots[index].errand = Errand::Home;
                true
            }
            Errand::ToStation(_) | Errand::Queue(_) | Errand::Charging(_) => true,
        }
    }

    fn finish(&mut self, now: Timestamp) {
        self.state = if self.missed_cells().is_empty() {
            MissionState::Completed
        } else {
            MissionState::CompletedWithGaps
        };
        self.conclude(now, "");
    }

    /// Ends the mission as FAILED.
    pub(crate) fn fail(&mut self, now: Timestamp, cause: &str) {
        self.state = MissionState::Failed;
        self.conclude(now, cause);
    }

    pub(crate) fn conclude(&mut self, now: Timestamp, cause: &str) {
        self.announcer.conclude(now, self.state, cause);
    }
}
