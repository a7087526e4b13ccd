//! Who is there: three signals, three answers.
//!
//! | Signal | Means | Answer |
//! |---|---|---|
//! | token dropped and no state | the process or its link is gone | SUSPECT at once, LOST later |
//! | state late, token there | the loop hangs | SUSPECT after `suspect_after_s`, LOST after `lost_after_s` |
//! | state fresh, no progress | stuck | its work goes to others, it stays an obstacle |
//!
//! SUSPECT gives the horizon away at once; the base stays locked until the lease has run out on the robot's own
//! clock (R3 of the reliability rules), and is a quarantine then, until another robot sees it free.

use crate::{
    Coordinator, Output,
    energy::Energy,
    ledger::RobotIndex,
    replan::Cause,
    robot::{Errand, Phase},
};
use protocol::{
    Timestamp,
    v1::{self, ConnectionState, ErrorType, EventLevel, MissionState, ReplanCause, ZoneType},
};
use std::time::Duration;
use terrain::{Cell, Point, Segment, angle_between};

/// Assumed bound on the rate error of a robot's clock.
const CLOCK_RATE_ERROR: f64 = 0.01;
/// Handling of a reply, and stopping, on top of the lease.
const LEASE_MARGIN: Duration = Duration::from_millis(700);
/// A robot that moves but passes no place of its route for so long is stuck, seconds.
const NOWHERE_S: f64 = 30.0;
/// A stuck robot is tried again after this, and so often; the wait doubles each time.
const TRY_AGAIN_S: u64 = 10;
pub(crate) const TRIES_MAX: u32 = 4;
/// A token that drops counts after this share of the silence that makes a robot SUSPECT (a blink is normal).
const TOKEN_GRACE: f64 = 0.4;

impl Coordinator {
    pub(crate) fn on_alive(&mut self, now: Timestamp, id: &str, boot_id: u64) {
        let index = self.enrol(id);
        let robot = &mut self.robots[index];
        robot.token = true;
        if robot.phase == Phase::Offline {
            robot.phase = Phase::Joining;
            robot.heard = now;
        }
        if robot.boot_id == 0 {
            robot.boot_id = boot_id;
        }
    }

    pub(crate) fn on_gone(&mut self, _now: Timestamp, id: &str, boot_id: u64) {
        if let Some(&index) = self.by_id.get(id) {
            let robot = &mut self.robots[index];
            if robot.boot_id == boot_id {
                robot.token = false;
            }
        }
    }

    pub(crate) fn on_factsheet(&mut self, now: Timestamp, sheet: Box<v1::Factsheet>) {
        let Some(header) = sheet.header.clone() else { return };
        let index = self.enrol(&header.serial_number);
        if let Some(misfit) = self.misfit(&sheet) {
            if self.robots[index].factsheet.is_none() {
                self.announcer.event(now, EventLevel::EventError, &header.serial_number, "REFUSED", &misfit);
                self.robots[index].phase = Phase::Offline;
            }
            return;
        }
        let robot = &mut self.robots[index];
        robot.factsheet = Some(sheet);
        robot.energy = match (robot.factsheet.as_ref().and_then(|sheet| sheet.energy_model), robot.motion()) {
            (Some(model), Some(motion)) => Some(Energy::new(&model, motion)),
            _ => None,
        };
    }

    /// Why a robot cannot do this mission's work.
    fn misfit(&self, sheet: &v1::Factsheet) -> Option<String> {
        let mission = &self.config.mission;
        if sheet.body_radius_m > mission.body_radius_m + 1e-6 {
            return Some(format!(
                "its body has a radius of {} m; the mission is planned for at most {} m",
                sheet.body_radius_m, mission.body_radius_m
            ));
        }
        if sheet.tool_width_m < mission.tool_width_m - 1e-6 {
            return Some(format!(
                "its tool is {} m wide; the mission is planned for {} m",
                sheet.tool_width_m, mission.tool_width_m
            ));
        }
        None
    }

    pub(crate) fn on_connection(
        &mut self,
        now: Timestamp,
        connection: &v1::Connection,
        _out: &mut Vec<Output>,
    ) {
        let Some(header) = &connection.header else { return };
        let index = self.enrol(&header.serial_number);
        let robot = &self.robots[index];
        if connection.connection_state() == ConnectionState::Offline
            && robot.boot_id == header.boot_id
            && robot.phase == Phase::Ready
        {
            self.announcer.event(now, EventLevel::EventInfo, &header.serial_number, "LEFT", "in good order");
            self.suspect(now, index, ReplanCause::CauseRobotLost, "left in good order");
        }
    }

    /// The heartbeat of a robot: presence, evidence, progress, and a request for ground.
    pub(crate) fn on_state(&mut self, now: Timestamp, state: Box<v1::State>, out: &mut Vec<Output>) {
        let Some(header) = state.header.clone() else { return };
        let index = self.enrol(&header.serial_number);
        if !self.is_current(index, &header) {
            return;
        }
        let restarted = self.robots[index].boot_id != header.boot_id || self.robots[index].state.is_none();
        let robot = &mut self.robots[index];
        robot.last_header = header.header_id;
        robot.heard = now;
        let was = robot.phase;
        if restarted {
            self.begin_boot(now, index, header.boot_id);
        }
        self.robots[index].state = Some(state);
        self.take_sweep(index);
        self.take_progress(now, index);
        self.robots[index].refresh_held();
        if self.robots[index].factsheet.is_some() && self.robots[index].phase != Phase::Ready {
            self.join(now, index, was, restarted);
        }
        if self.robots[index].phase == Phase::Ready {
            self.take_scan(now, index);
            self.watch_battery(now, index);
            self.extend_base(now, index);
            self.grant(now, index, out);
        }
    }

    /// Whether a state is newer than the last one and of the newest start of the agent.
    fn is_current(&self, index: RobotIndex, header: &v1::Header) -> bool {
        let robot = &self.robots[index];
        robot.boot_id != header.boot_id || robot.state.is_none() || header.header_id > robot.last_header
    }

    /// A new start of the agent: it knows nothing of what was granted before. What the old one was granted stays
    /// locked until that lease has run out.
    fn begin_boot(&mut self, now: Timestamp, index: RobotIndex, boot_id: u64) {
        self.orphan_route(index);
        let robot = &mut self.robots[index];
        if robot.boot_id != 0 && robot.boot_id != boot_id {
            robot.retire_base();
            robot.epoch += 1;
            self.announcer.event(
                now,
                EventLevel::EventInfo,
                &robot.id,
                "RESTARTED",
                "its agent started anew",
            );
        }
        let robot = &mut self.robots[index];
        robot.boot_id = boot_id;
        robot.token = true;
        robot.sweep_sequence = 0;
        robot.sweep_at = None;
        robot.phase = Phase::Joining;
        robot.route = crate::route::Route::default();
    }

    /// A robot becomes READY: for the first time, after silence, or after a restart.
    fn join(&mut self, now: Timestamp, index: RobotIndex, was: Phase, restarted: bool) {
        let Some(position) = self.robots[index].position() else { return };
        self.zones.forget_quarantine_of(&self.robots[index].id.clone());
        let lost_its_ground = std::mem::take(&mut self.robots[index].ground_taken);
        let fresh = restarted || lost_its_ground || self.robots[index].route.order_id() == 0;
        if fresh {
            self.restart_route(now, index);
        }
        let robot = &mut self.robots[index];
        robot.phase = Phase::Ready;
        robot.stuck = false;
        robot.moved_at = now;
        robot.passed_at = now;
        robot.home.get_or_insert(position);
        if !matches!(robot.errand, Errand::Cover) {
            self.forget_errand(index);
        }
        self.robots[index].refresh_held();
        self.first_joined.get_or_insert(now);
        let id = self.robots[index].id.clone();
        let text = match (was, restarted) {
            (Phase::Suspect | Phase::Lost, false) => "is back",
            _ => "joined",
        };
        if self.mission_began.is_some() {
            self.look_who_gets_where(now, index);
            self.need_plan(now, Cause::of(ReplanCause::CauseRobotJoined, index, text));
        } else {
            let at = format!("at ({:.1}, {:.1}) m", position.x, position.y);
            self.announcer.event(now, EventLevel::EventInfo, &id, "JOINED", &at);
        }
    }

    /// Takes a robot's ground away and begins a new order where it stands.
    pub(crate) fn restart_route(&mut self, _now: Timestamp, index: RobotIndex) {
        self.orphan_route(index);
        self.robots[index].break_off = None;
        self.begin_order_where_it_stands(index);
    }

    /// The same, but what it was to drive is given to nobody.
    pub(crate) fn begin_order_where_it_stands(&mut self, index: RobotIndex) {
        let order_id = self.fresh_order_id();
        let robot = &mut self.robots[index];
        let Some(position) = robot.position() else { return };
        if robot.route.order_id() != 0 {
            robot.retire_base();
            robot.epoch += 1;
        }
        robot.route.restart(order_id, position);
        robot.wait = None;
        robot.hold = None;
        robot.order_sent = Timestamp::ZERO;
        robot.refresh_held();
    }

    fn take_sweep(&mut self, index: RobotIndex) {
        let Some(state) = self.robots[index].state.take() else { return };
        let tool_radius_m = self.robots[index]
            .factsheet
            .as_ref()
            .map_or(self.config.mission.tool_width_m, |sheet| sheet.tool_width_m)
            / 2.0;
        for vertex in &state.sweep {
            self.take_vertex(index, vertex, tool_radius_m);
        }
        self.robots[index].state = Some(state);
    }

    /// One corner of the swept line; each number counts once, and a gap gives no credit.
    fn take_vertex(&mut self, index: RobotIndex, vertex: &v1::SweepVertex, tool_radius_m: f64) {
        let robot = &mut self.robots[index];
        if vertex.sequence <= robot.sweep_sequence {
            return;
        }
        let follows = vertex.sequence == robot.sweep_sequence + 1;
        let here = Point::new(vertex.x_m, vertex.y_m);
        let before = robot.sweep_at.replace(here);
        robot.sweep_sequence = vertex.sequence;
        let Some(from) = before.filter(|_| follows && vertex.tool_active) else { return };
        let segment = Segment::new(from, here);
        if vertex.trusted {
            let covered = self.ledger.sweep(index, segment, tool_radius_m - vertex.deviation_m);
            self.robots[index].cells_covered += covered;
        } else {
            self.ledger.lose(segment, tool_radius_m);
        }
    }

    fn take_progress(&mut self, now: Timestamp, index: RobotIndex) {
        let robot = &mut self.robots[index];
        let passed = robot.route.passed();
        let Some(state) = robot.state.as_ref() else { return };
        if state.order_id == robot.route.order_id() && robot.route.order_id() != 0 {
            let reached = state.last_node_sequence_id;
            robot.route.pass(reached);
            robot.retiring.clear();
        }
        if now >= robot.retiring_until {
            robot.retiring.clear();
        }
        if robot.route.passed() != passed {
            robot.passed_at = now;
        }
        let Some(pose) = state.pose else { return };
        let moved = (pose.x_m - robot.moved_from.x_m).hypot(pose.y_m - robot.moved_from.y_m) > 0.05
            || angle_between(robot.moved_from.theta_rad, pose.theta_rad).abs() > 0.1;
        if moved || robot.stands_at_base_end() {
            robot.moved_at = now;
            robot.moved_from = pose;
        }
        let far = (pose.x_m - robot.freed_from.0).hypot(pose.y_m - robot.freed_from.1) > 1.0;
        if robot.tries > 0 && !robot.stuck && far {
            robot.tries = 0;
            robot.freed_from = (pose.x_m, pose.y_m);
        }
    }

    /// Looks at all robots for silence and lack of progress.
    pub(crate) fn check_presence(&mut self, now: Timestamp) {
        for index in 0..self.robots.len() {
            match self.robots[index].phase {
                Phase::Ready => {
                    self.check_silence(now, index);
                    self.check_progress(now, index);
                }
                Phase::Suspect => self.check_lost(now, index),
                Phase::Lost => self.check_quarantine(now, index),
                // It said where it stands before it could join: there is somebody on the floor.
                Phase::Joining if self.robots[index].state.is_some() => self.check_silence(now, index),
                Phase::Offline | Phase::Joining => {}
            }
        }
        if self.has_healthy_robot() {
            self.last_healthy = now;
        }
    }

    fn check_silence(&mut self, now: Timestamp, index: RobotIndex) {
        let robot = &self.robots[index];
        let silence_s = now.secs_since(robot.heard);
        let limit_s = self.config.timing.suspect_after_s;
        if !robot.token && silence_s > limit_s * TOKEN_GRACE {
            let text = format!("its session is gone, no state for {silence_s:.1} s");
            self.suspect(now, index, ReplanCause::CauseRobotLost, &text);
        } else if silence_s > limit_s {
            let text = format!("no state for {silence_s:.1} s");
            self.suspect(now, index, ReplanCause::CauseRobotHung, &text);
        }
    }

    /// No new ground, and the horizon goes to others.
    fn suspect(&mut self, now: Timestamp, index: RobotIndex, cause: ReplanCause, text: &str) {
        self.forget_errand(index);
        self.orphan_route(index);
        let robot = &mut self.robots[index];
        robot.phase = Phase::Suspect;
        robot.silent_since = robot.heard;
        robot.route.cut_horizon();
        robot.wait = None;
        robot.hold = None;
        let id = robot.id.clone();
        self.announcer.event(now, EventLevel::EventWarning, &id, "SUSPECT", text);
        self.need_plan(now, Cause::of(cause, index, text));
    }

    fn check_lost(&mut self, now: Timestamp, index: RobotIndex) {
        let robot = &self.robots[index];
        let silence_s = now.secs_since(robot.silent_since);
        if silence_s <= self.config.timing.lost_after_s {
            return;
        }
        let id = robot.id.clone();
        self.robots[index].phase = Phase::Lost;
        self.robots_lost += 1;
        let text =
            format!("no state for {silence_s:.1} s; its ground stays locked until its lease has run out");
        self.announcer.event(now, EventLevel::EventWarning, &id, "LOCKED", &text);
        self.check_quarantine(now, index);
    }

    /// When the lease of a lost robot has run out, its ground becomes a quarantine zone.
    fn check_quarantine(&mut self, now: Timestamp, index: RobotIndex) {
        let robot = &mut self.robots[index];
        if robot.held.is_empty() || now < robot.lease_until {
            return;
        }
        let held = std::mem::take(&mut robot.held);
        robot.ground_taken = true;
        robot.retiring.clear();
        let id = robot.id.clone();
        let cells = self.cells_near(&held);
        if let Some(zone) = self.zones.add(ZoneType::ZoneQuarantine, cells, &id, now, now) {
            self.zones.set_ground(zone, held);
            self.zones_changed();
            let text = format!("zone {zone}: where it may stand, until somebody sees it free");
            self.announcer.event(now, EventLevel::EventInfo, &id, "QUARANTINE", &text);
        }
    }

    /// Numbers of the drivable cells in which a body would come too near to some ground.
    pub(crate) fn cells_near(&self, ground: &[Segment]) -> Vec<usize> {
        self.cells_within(ground, self.separation_m())
    }

    /// Numbers of the drivable cells whose centre is nearer than `reach` metres to some ground.
    pub(crate) fn cells_within(&self, ground: &[Segment], reach: f64) -> Vec<usize> {
        let lattice = self.floor.lattice();
        let mut cells: Vec<usize> = ground
            .iter()
            .flat_map(|segment| {
                let low = Point::from(segment.from.coords.inf(&segment.to.coords).add_scalar(-reach));
                let high = Point::from(segment.from.coords.sup(&segment.to.coords).add_scalar(reach));
                lattice
                    .cells_in_box(low, high)
                    .filter(move |&cell| segment.distance_to_point(lattice.center(cell)) < reach)
            })
            .filter(|&cell| self.floor.cell_is_drivable(cell))
            .filter_map(|cell| lattice.index(cell))
            .collect();
        cells.sort_unstable();
        cells.dedup();
        cells
    }

    fn check_progress(&mut self, now: Timestamp, index: RobotIndex) {
        let robot = &self.robots[index];
        let says_stuck = robot
            .state
            .as_ref()
            .is_some_and(|state| state.errors.iter().any(|error| error.error_type() == ErrorType::Stuck));
        let waits = robot.obstacle_since.is_some() || self.state == MissionState::Paused;
        let still_s = now.secs_since(robot.moved_at);
        if robot.stuck {
            self.try_again(now, index);
            return;
        }
        if waits || robot.stands_at_base_end() {
            self.robots[index].passed_at = now;
            return;
        }
        // Wheels that slip make a pose wander to and fro: it moves, and gets nowhere.
        let nowhere_s = now.secs_since(robot.passed_at);
        let stays = still_s > self.config.timing.stuck_after_s || (says_stuck && still_s > 3.0);
        if stays || nowhere_s > NOWHERE_S {
            let text = if stays {
                format!("has not moved for {still_s:.1} s on free ground")
            } else {
                format!("has passed no place of its route for {nowhere_s:.0} s on free ground")
            };
            self.forget_errand(index);
            self.restart_route(now, index);
            let robot = &mut self.robots[index];
            robot.stuck = true;
            robot.freed_from = robot.position().map_or((0.0, 0.0), |p| (p.x, p.y));
            robot.try_at = now + Duration::from_secs(TRY_AGAIN_S << robot.tries.min(TRIES_MAX));
            self.need_plan(now, Cause::of(ReplanCause::CauseRobotStuck, index, &text));
        }
    }

    /// A stuck robot may have been freed: it is given work again, a few times, to find out.
    fn try_again(&mut self, now: Timestamp, index: RobotIndex) {
        let robot = &mut self.robots[index];
        if robot.tries >= TRIES_MAX || now < robot.try_at {
            return;
        }
        robot.tries += 1;
        robot.stuck = false;
        robot.moved_at = now;
        robot.passed_at = now;
        self.idle_checks.new_ground();
        self.need_plan(now, Cause::of(ReplanCause::CauseRobotJoined, index, "is tried again"));
    }

    /// The lease that a grant sent now gives, as long as the coordinator must reckon with it.
    pub(crate) fn lease_end(&self, now: Timestamp) -> Timestamp {
        now + Duration::from_secs_f64(self.config.timing.lease_s * (1.0 + 2.0 * CLOCK_RATE_ERROR))
            + LEASE_MARGIN
    }

    /// The drivable, open cell from which a robot's next route can begin: where its base ends, or near where it
    /// stands.
    pub(crate) fn start_cell(&self, index: RobotIndex) -> Option<Cell> {
        let end = self.robots[index].route.base_end()?;
        if let Some(cell) = end.cell {
            return Some(cell);
        }
        self.nearest_open_cell(index, end.point)
    }

    fn nearest_open_cell(&self, index: RobotIndex, point: Point) -> Option<Cell> {
        let map = &self.config.mission.map;
        self.cell_beside(point, |way| self.conflict(index, way).is_none())
            .or_else(|| self.floor.nearest_drivable(map, point))
            .or_else(|| self.end_of_passage(point))
    }

    /// The open cell nearest to a point to which a body can drive straight from there on an `allowed` way: with the
    /// room that routes have where there is such a cell, else with as much as there is.
    pub(crate) fn cell_beside(&self, point: Point, allowed: impl Fn(Segment) -> bool) -> Option<Cell> {
        let lattice = self.floor.lattice();
        let reach = 1.5 * lattice.cell_m;
        let corner = terrain::Vector::repeat(reach);
        let way = |cell: Cell| Segment::new(point, lattice.center(cell));
        let mut near: Vec<Cell> = lattice
            .cells_in_box(point - corner, point + corner)
            .filter(|&cell| self.is_open_ground(cell) && way(cell).length() <= reach && allowed(way(cell)))
            .collect();
        near.sort_by(|&a, &b| way(a).length().total_cmp(&way(b).length()));
        let body_m = self.config.mission.body_radius_m;
        let rooms_m = [self.floor.body_radius_m() - 1e-6, body_m + 0.01, body_m - 0.02];
        rooms_m.into_iter().find_map(|room_m| {
            near.iter().copied().find(|&cell| self.config.mission.map.capsule_is_free(way(cell), room_m))
        })
    }
}
