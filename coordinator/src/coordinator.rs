//! One match over everything that can happen.

use crate::{
    Config, Input, Output, PlanRequest, Publication,
    announce::Announcer,
    charging::StationState,
    ledger::{Ledger, RobotIndex},
    replan::Replanning,
    robot::{Phase, Robot},
    way::Roads,
    zones::Zones,
};
use protocol::{
    Timestamp,
    v1::{self, MissionState},
};
use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
    time::Duration,
};
use terrain::{Cell, Floor, FloorError, Passages, Point};

/// Pose error and tracking error that a sweep may have and still count, metres: what can be swept is reckoned
/// with a tool that is smaller by this on all sides.
pub(crate) const COVERAGE_TOLERANCE_M: f64 = 0.04;
/// Routes keep bodies so far from walls, metres: tracking and pose error, and the 2 cm beside its body in which a robot
/// stops for whatever its range finder sees.
pub const WALL_MARGIN_M: f64 = 0.05;
/// How often the coordinator looks around by itself.
const TICK: Duration = Duration::from_millis(100);

/// The state machine. Its parts: the roster ([`Robot`]), the [`Ledger`] of the floor, the [`Zones`] not to be
/// entered, and what is decided about them (`presence.rs`, `traffic.rs`, `replan.rs`, `charging.rs`,
/// `blockage.rs`, `ending.rs`, `operator.rs`).
#[derive(Debug)]
pub struct Coordinator {
    pub(crate) config: Config,
    pub(crate) floor: Arc<Floor>,
    pub(crate) passages: Passages,
    /// Row-major: the piece of the lattice that a cell belongs to.
    pub(crate) pieces: Vec<u32>,
    pub(crate) ledger: Ledger,
    pub(crate) zones: Zones,
    pub(crate) robots: Vec<Robot>,
    pub(crate) by_id: BTreeMap<String, RobotIndex>,
    pub(crate) stations: Vec<StationState>,
    /// By cell: no battery lasts from a station there and back. Empty before the start.
    pub(crate) out_of_range: Vec<bool>,
    /// Cells beside which robots have joined: what can be got to from there is within reach.
    pub(crate) joined_in: BTreeSet<Cell>,
    pub(crate) state: MissionState,
    pub(crate) replanning: Replanning,
    pub(crate) announcer: Announcer,
    pub(crate) started: Option<Timestamp>,
    pub(crate) first_joined: Option<Timestamp>,
    pub(crate) last_healthy: Timestamp,
    pub(crate) mission_began: Option<Timestamp>,
    pub(crate) robots_lost: u32,
    pub(crate) next_order_id: u64,
    /// Routes that have lost their robot since the last plan.
    pub(crate) orphans: Vec<Vec<Cell>>,
    /// The same as lines of points.
    pub(crate) orphan_lines: Vec<Vec<Point>>,
    pub(crate) sightings: crate::blockage::Sightings,
    pub(crate) idle_checks: crate::ending::IdleChecks,
    next_tick: Timestamp,
    next_waits: Timestamp,
}

impl Coordinator {
    /// A coordinator for one mission.
    ///
    /// # Errors
    ///
    /// [`FloorError`] when the robots of the mission fit nowhere on its map.
    pub fn new(config: Config) -> Result<Self, FloorError> {
        let mission = &config.mission;
        let tool_width_m = mission.tool_width_m - 2.0 * COVERAGE_TOLERANCE_M;
        let floor = Arc::new(Floor::new(
            &mission.map,
            mission.cell_m,
            mission.body_radius_m + WALL_MARGIN_M,
            tool_width_m,
        )?);
        let required = (0..floor.lattice().len()).map(|index| floor.required(index)).collect();
        let robots: Vec<Robot> = mission.robots.iter().map(|id| Robot::new(id)).collect();
        let by_id = mission.robots.iter().enumerate().map(|(index, id)| (id.clone(), index)).collect();
        let stations = mission.stations.iter().map(StationState::new).collect();
        let mut coordinator = Self {
            ledger: Ledger::new(Arc::clone(&floor), required),
            zones: Zones::new(floor.lattice().len()),
            passages: Passages::new(&floor),
            pieces: floor.pieces(),
            announcer: Announcer::new(&config),
            floor,
            robots,
            by_id,
            stations,
            out_of_range: Vec::new(),
            joined_in: BTreeSet::new(),
            state: MissionState::Created,
            replanning: Replanning::default(),
            started: None,
            first_joined: None,
            last_healthy: Timestamp::ZERO,
            mission_began: None,
            robots_lost: 0,
            next_order_id: 1,
            orphans: Vec::new(),
            orphan_lines: Vec::new(),
            sightings: crate::blockage::Sightings::default(),
            idle_checks: crate::ending::IdleChecks::default(),
            next_tick: Timestamp::ZERO,
            next_waits: Timestamp::ZERO,
            config,
        };
        coordinator.measure_station_moves();
        Ok(coordinator)
    }

    /// Takes in one input at time `now` and returns what has to be done about it.
    pub fn handle(&mut self, now: Timestamp, input: Input) -> Vec<Output> {
        let mut out = Vec::new();
        self.started.get_or_insert(now);
        match input {
            Input::Alive { robot, boot_id } => self.on_alive(now, &robot, boot_id),
            Input::Gone { robot, boot_id } => self.on_gone(now, &robot, boot_id),
            Input::Factsheet(sheet) => self.on_factsheet(now, sheet),
            Input::Connection(connection) => self.on_connection(now, &connection, &mut out),
            Input::State(state) => self.on_state(now, state, &mut out),
            Input::Planned { revision, result, planning_s } => {
                self.on_planned(now, revision, result, planning_s, &mut out);
            }
            Input::BrokenOff { revision, breaks } => self.on_broken_off(revision, &breaks),
            Input::Operator(command) => self.on_operator(now, &command, &mut out),
            Input::Woken => {}
        }
        if now >= self.next_tick {
            self.next_tick = now + TICK;
            self.tick(now, &mut out);
        }
        self.send_plan_request(now, &mut out);
        self.announcer.drain(&mut out);
        out
    }

    /// When to be woken if nothing else happens, and why.
    pub fn next_wakeup(&self) -> Option<(Timestamp, &'static str)> {
        let look_around = (self.next_tick, "look around");
        match self.replanning.due() {
            Some(due) if due < self.next_tick => Some((due, "replan")),
            _ => Some(look_around),
        }
    }

    /// Whether the mission has ended.
    pub fn ended(&self) -> bool {
        matches!(
            self.state,
            MissionState::Completed
                | MissionState::CompletedWithGaps
                | MissionState::Cancelled
                | MissionState::Failed
        )
    }

    /// How the mission stands.
    pub fn mission_state(&self) -> MissionState {
        self.state
    }

    fn tick(&mut self, now: Timestamp, out: &mut Vec<Output>) {
        if !self.ended() {
            self.check_presence(now);
            self.check_obstacles(now);
            self.check_stations(now);
            self.check_sightings(now);
            if now >= self.next_waits {
                self.next_waits = now + Duration::from_millis(500);
                self.resolve_waits(now);
            }
            self.check_start(now);
            self.check_end(now, out);
        }
        self.resend(now, out);
        self.announce(now, out);
    }

    /// The number of a robot; one that was not expected is added to the roster.
    pub(crate) fn enrol(&mut self, id: &str) -> RobotIndex {
        if let Some(&index) = self.by_id.get(id) {
            return index;
        }
        self.robots.push(Robot::new(id));
        self.by_id.insert(id.to_owned(), self.robots.len() - 1);
        self.robots.len() - 1
    }

    pub(crate) fn fresh_order_id(&mut self) -> u64 {
        self.next_order_id += 1;
        self.next_order_id
    }

    /// Numbers of the robots that can cover now.
    pub(crate) fn coverers(&self) -> Vec<RobotIndex> {
        (0..self.robots.len()).filter(|&robot| self.robots[robot].can_cover()).collect()
    }

    /// Whether a cell may be entered as far as zones are concerned.
    pub(crate) fn is_open_ground(&self, cell: Cell) -> bool {
        self.floor
            .lattice()
            .index(cell)
            .is_some_and(|index| self.floor.is_drivable(index) && !self.zones.holds(index))
    }

    /// What ways lead over now.
    pub(crate) fn roads(&self) -> Roads<'_> {
        Roads { floor: &self.floor, passages: &self.passages, zones: Some(&self.zones) }
    }

    /// The same, as if no ground were closed.
    pub(crate) fn roads_as_if_open(&self) -> Roads<'_> {
        Roads { zones: None, ..self.roads() }
    }

    pub(crate) fn publish(out: &mut Vec<Output>, publication: Publication) {
        out.push(Output::Publish(publication));
    }

    pub(crate) fn ask_planner(out: &mut Vec<Output>, request: PlanRequest) {
        out.push(Output::Plan(Box::new(request)));
    }

    /// Whether robots may be given ground at all.
    pub(crate) fn is_running(&self) -> bool {
        matches!(self.state, MissionState::Active | MissionState::Replanning)
    }

    /// Whether any robot could still do something, now or after charging.
    pub(crate) fn has_healthy_robot(&self) -> bool {
        self.robots.iter().any(|robot| robot.phase == Phase::Ready && !robot.stuck)
    }

    /// The reply of the mission to a person.
    pub(crate) fn reply(out: &mut Vec<Output>, command: &v1::OperatorCommand, accepted: bool, reason: &str) {
        out.push(Output::Reply(v1::OperatorReply {
            command_id: command.command_id,
            accepted,
            reason: reason.to_owned(),
        }));
    }
}
