//! One robot's mind: what can happen to it, and what it does about it.

use crate::{
    lease::Lease,
    localisation::{Localisation, News},
    obstacle_watch::ObstacleWatch,
    order_book::{Answer, OrderBook},
    path_follower::{Command, PathFollower},
    sweep_log::SweepLog,
};
use protocol::{
    Bounds, Timestamp, Validate,
    v1::{self, ConnectionState, ErrorLevel, ErrorType, InstantActionType, OperatingMode},
};
use std::time::Duration;
use terrain::MotionModel;

/// The factsheet is repeated this often until a grant came.
const FACTSHEET_EVERY: Duration = Duration::from_secs(2);
/// A refused order is reported for so long.
const REFUSAL_SHOWN: Duration = Duration::from_secs(2);
/// The drive holds the last setpoint for a while; after a longer gap nobody knows what the tool did in it.
const TOOL_UNKNOWN_AFTER_NS: f64 = 150e6;
/// The least way that is asked of the drive: 0 would mean no limit, metres.
const RUN_MIN_M: f64 = 0.001;
/// Asked to move and not moving for so long means stuck.
const STUCK_AFTER: Duration = Duration::from_secs(3);

/// What can happen to an agent.
#[derive(Debug, Clone, PartialEq)]
pub enum Input {
    /// The base measured something (50 times a second).
    Base(Box<v1::BaseState>),
    /// The coordinator sent an order or an update of one.
    Order(Box<v1::Order>),
    /// The coordinator granted ground, or renewed the lease.
    Grant(v1::Grant),
    /// The coordinator asks for something at once.
    InstantActions(v1::InstantActions),
    /// The link to the coordinator came up or went down.
    Link(bool),
    /// The time asked for by `next_wakeup` has come.
    Woken,
}

/// What an agent asks its driver to do.
#[derive(Debug, Clone, PartialEq)]
pub enum Output {
    /// Send to the base.
    Setpoint(v1::Setpoint),
    /// Send to the coordinator.
    State(Box<v1::State>),
    /// Send to the coordinator.
    Factsheet(Box<v1::Factsheet>),
    /// Send to the coordinator.
    Connection(v1::Connection),
}

/// The state machine.
#[derive(Debug)]
pub struct Agent {
    serial_number: String,
    boot_id: u64,
    pid: u32,
    sheet: Option<Box<v1::Factsheet>>,
    model: MotionModel,
    order: OrderBook,
    lease: Lease,
    follower: PathFollower,
    localisation: Localisation,
    watch: ObstacleWatch,
    log: SweepLog,
    headers: [u64; 3],
    setpoints: u64,
    asked: Command,
    tool_active: bool,
    tool_since_fix: bool,
    paused: bool,
    granted: bool,
    base: Measured,
    state_at: Timestamp,
    factsheet_at: Timestamp,
    refused: Option<(ErrorType, Timestamp)>,
    moved_at: Timestamp,
    moved_from: (f64, f64, f64),
    shown: Shown,
    station_id: String,
    last_scan: Option<v1::RangeScan>,
}

/// The parts of the last `BaseState` that are reported.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Measured {
    time_ns: u64,
    charge_percent: f64,
    speed: f64,
    turning: f64,
    charging: bool,
    bumper: bool,
}

/// What the coordinator was told last; a difference makes a new state due at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Shown {
    order: (u64, u32),
    at_base_end: bool,
    charging: bool,
    paused: bool,
    obstacle: bool,
    stuck: bool,
    bumper: bool,
}

impl Agent {
    /// An agent for robot `serial_number`; `boot_id` is drawn anew at each start. It knows what its robot is from
    /// the first `BaseState.description`, and does nothing before.
    pub fn new(serial_number: &str, boot_id: u64, pid: u32) -> Self {
        Self {
            serial_number: serial_number.to_owned(),
            boot_id,
            pid,
            sheet: None,
            model: MotionModel {
                speed_m_per_s: 0.1,
                acceleration_m_per_s2: 0.1,
                angular_speed_rad_per_s: 0.1,
                angular_acceleration_rad_per_s2: 0.1,
                brakes: true,
            },
            order: OrderBook::default(),
            lease: Lease::default(),
            follower: PathFollower::default(),
            localisation: Localisation::default(),
            watch: ObstacleWatch::default(),
            log: SweepLog::default(),
            headers: [0; 3],
            setpoints: 0,
            asked: Command::default(),
            tool_active: false,
            tool_since_fix: false,
            paused: false,
            granted: false,
            base: Measured::default(),
            state_at: Timestamp::ZERO,
            factsheet_at: Timestamp::ZERO,
            refused: None,
            moved_at: Timestamp::ZERO,
            moved_from: (0.0, 0.0, 0.0),
            shown: Shown::default(),
            station_id: String::new(),
            last_scan: None,
        }
    }

    /// Takes in one input at time `now` on the agent's own clock and returns what has to be done about it.
    pub fn handle(&mut self, now: Timestamp, input: Input) -> Vec<Output> {
        let mut out = Vec::new();
        match input {
            Input::Base(base) => self.on_base(now, &base, &mut out),
            Input::Order(order) => self.on_order(now, &order),
            Input::Grant(grant) => self.on_grant(now, &grant),
            Input::InstantActions(actions) => self.on_actions(&actions),
            Input::Link(up) => self.on_link(up),
            Input::Woken => {}
        }
        if self.sheet.is_some() {
            self.report(now, &mut out);
        }
        out
    }

    /// When to be woken if nothing else happens, and why.
    pub fn next_wakeup(&self) -> Option<(Timestamp, &'static str)> {
        self.sheet.as_ref().map(|_| (self.state_at, "state due"))
    }

    /// Leaves in good order: stops the robot and says goodbye.
    pub fn shutdown(&mut self, now: Timestamp) -> Vec<Output> {
        let stop = self.setpoint(now, Command::default());
        let header = Some(self.header(now, 1));
        let connection_state = ConnectionState::Offline.into();
        vec![Output::Setpoint(stop), Output::Connection(v1::Connection { header, connection_state })]
    }

    /// How many times faster than its clock the robot's time runs is the driver's business; what the robot is,
    /// the base tells.
    fn on_description(&mut self, sheet: &v1::Factsheet) {
        if self.sheet.is_some() {
            return;
        }
        let mut sheet = Box::new(sheet.clone());
        sheet.header =
            Some(v1::Header { serial_number: self.serial_number.clone(), ..v1::Header::default() });
        if let Err(reason) = sheet.validate(&Bounds::ANYWHERE) {
            tracing::warn!(%reason, "the base's description of the robot is refused");
            return;
        }
        self.model = MotionModel {
            speed_m_per_s: sheet.speed_max_m_per_s,
            acceleration_m_per_s2: sheet.acceleration_max_m_per_s2,
            angular_speed_rad_per_s: sheet.angular_speed_max_rad_per_s,
            angular_acceleration_rad_per_s2: sheet.angular_acceleration_max_rad_per_s2,
            brakes: true,
        };
        self.sheet = Some(sheet);
    }

    fn on_base(&mut self, now: Timestamp, base: &v1::BaseState, out: &mut Vec<Output>) {
        if let Err(reason) = base.validate(&Bounds::ANYWHERE) {
            tracing::warn!(%reason, "a measurement of the base is refused");
            return;
        }
        if let Some(sheet) = &base.description {
            self.on_description(sheet);
        }
        if self.sheet.is_none() {
            return;
        }
        self.watch_tool(base);
        self.base = Measured {
            time_ns: base.time_ns,
            charge_percent: base.state_of_charge_percent,
            speed: base.speed_m_per_s,
            turning: base.angular_speed_rad_per_s,
            charging: base.charging,
            bumper: base.bumper,
        };
        self.locate(base);
        self.look(base);
        let command = self.drive(now);
        self.watch_progress(now, command);
        let setpoint = self.setpoint(now, command);
        self.station(base);
        out.push(Output::Setpoint(setpoint));
    }

    /// Only what the tool truly did counts, not what was asked of it.
    fn watch_tool(&mut self, base: &v1::BaseState) {
        let gap_ns = base.time_ns.saturating_sub(self.base.time_ns) as f64;
        let unknown = gap_ns > TOOL_UNKNOWN_AFTER_NS * base.time_factor.max(1.0);
        self.tool_since_fix &= base.tool_active && !unknown;
    }

    fn locate(&mut self, base: &v1::BaseState) {
        if let News::Fixed { trusted } = self.localisation.take(base) {
            let standing = base.speed_m_per_s.abs() < 0.02;
            let tool = std::mem::replace(&mut self.tool_since_fix, self.tool_active);
            // Evidence is the fix itself: its error is bounded, that of the estimate between fixes is not.
            let place = self.localisation.fix.point();
            self.log.take(place, tool, trusted, self.localisation.deviation_m, standing);
        }
    }

    fn look(&mut self, base: &v1::BaseState) {
        let Some(sheet) = &self.sheet else { return };
        if let Some(scan) = &base.scan {
            let stopping_m = self.model.stopping_distance_m(base.speed_m_per_s);
            let place = self.localisation.place;
            self.watch.take(scan, place, &self.order, sheet.body_radius_m, stopping_m);
            self.last_scan = Some(scan.clone());
        }
        if !self.order.has_base() {
            self.watch.clear();
        }
    }

    /// What to ask of the wheels, by the order, the lease and what is in the way.
    fn drive(&mut self, now: Timestamp) -> Command {
        let moving = Command {
            speed_m_per_s: self.base.speed,
            angular_speed_rad_per_s: self.base.turning,
            ..Command::default()
        };
        let stopping_s = moving.speed_m_per_s.abs() / self.model.acceleration_m_per_s2;
        let lease_ends = self.lease.left(now, self.order.order_id).as_secs_f64() < stopping_s + 0.1;
        let stop = self.paused
            || lease_ends
            || self.base.bumper
            || self.base.charging && !self.order.has_base()
            || self.watch.sees_something();
        let place = self.localisation.place;
        let asked = Command {
            speed_m_per_s: nearest_of(moving.speed_m_per_s, self.asked.speed_m_per_s),
            angular_speed_rad_per_s: nearest_of(
                moving.angular_speed_rad_per_s,
                self.asked.angular_speed_rad_per_s,
            ),
            ..Command::default()
        };
        let command = self.follower.follow(&mut self.order, place, asked, &self.model, stop);
        self.tool_active =
            !stop && self.order.base().nth(1).is_some_and(|next| next.tool_active) || self.ends_covering();
        self.tool_since_fix &= self.tool_active;
        self.asked = command;
        command
    }

    /// While braking into the last node the tool stays on.
    fn ends_covering(&self) -> bool {
        self.tool_active && !self.order.has_base() && self.base.speed.abs() > 0.005
    }

    fn setpoint(&mut self, now: Timestamp, command: Command) -> v1::Setpoint {
        self.setpoints += 1;
        let left_ns = self.lease.left(now, self.order.order_id).as_nanos() as u64;
        v1::Setpoint {
            sequence: self.setpoints,
            speed_m_per_s: command.speed_m_per_s,
            angular_speed_rad_per_s: command.angular_speed_rad_per_s,
            tool_active: self.tool_active,
            term: self.lease.term,
            epoch: self.lease.epoch,
            boot_id: self.boot_id,
            valid_until_ns: self.base.time_ns + left_ns,
            pid: self.pid,
            run_m: command.run_m.max(RUN_MIN_M),
        }
    }

    fn watch_progress(&mut self, now: Timestamp, command: Command) {
        let place = self.localisation.fix;
        let (x, y, theta) = self.moved_from;
        let moved = (place.x - x).hypot(place.y - y) > 0.03
            || terrain::angle_between(theta, place.theta).abs() > 0.05;
        let asked_to_move = command.speed_m_per_s.abs() > 0.02 || command.angular_speed_rad_per_s.abs() > 0.1;
        if moved || !asked_to_move && !self.is_stuck(now) {
            self.moved_at = now;
            self.moved_from = (place.x, place.y, place.theta);
        }
    }

    fn is_stuck(&self, now: Timestamp) -> bool {
        now.since(self.moved_at) >= STUCK_AFTER
    }

    fn station(&mut self, base: &v1::BaseState) {
        if self.station_id != base.station_id {
            self.station_id.clone_from(&base.station_id);
        }
    }

    fn on_order(&mut self, now: Timestamp, order: &v1::Order) {
        if let Err(reason) = order.validate(&Bounds::ANYWHERE) {
            tracing::warn!(%reason, "an order is refused");
            self.refused = Some((ErrorType::ValidationFailure, now));
            return;
        }
        if order.boot_id != self.boot_id {
            return;
        }
        let before = self.order.order_id;
        match self.order.take(order) {
            Answer::Accepted => {
                if self.order.order_id != before {
                    self.follower.reset();
                    self.watch.clear();
                }
            }
            Answer::Known => {}
            Answer::Outdated => self.refused = Some((ErrorType::OutdatedOrderUpdate, now)),
            Answer::DoesNotFit => {
                tracing::warn!(
                    order.order_id,
                    order.order_update_id,
                    "an order does not join on to the base"
                );
                self.refused = Some((ErrorType::ValidationFailure, now));
            }
        }
    }

    fn on_grant(&mut self, now: Timestamp, grant: &v1::Grant) {
        if grant.boot_id != self.boot_id || grant.validate(&Bounds::ANYWHERE).is_err() {
            return;
        }
        if self.lease.take(now, grant) {
            self.granted = true;
            self.log.acknowledge(grant.sweep_acknowledged);
            self.order.release(grant.order_id, grant.order_update_id, grant.released_sequence_id);
        }
    }

    fn on_actions(&mut self, actions: &v1::InstantActions) {
        if actions.boot_id != self.boot_id
            || actions.term < self.lease.term
            || actions.validate(&Bounds::ANYWHERE).is_err()
        {
            return;
        }
        for action in actions.actions() {
            match action {
                InstantActionType::StartPause => self.paused = true,
                InstantActionType::StopPause => self.paused = false,
                InstantActionType::CancelOrder => self.order.cancel(),
                InstantActionType::StateRequest => self.state_at = Timestamp::ZERO,
                InstantActionType::FactsheetRequest => self.factsheet_at = Timestamp::ZERO,
                InstantActionType::Unspecified => {}
            }
        }
    }

    fn on_link(&mut self, up: bool) {
        if up {
            self.granted = false;
            self.factsheet_at = Timestamp::ZERO;
            self.state_at = Timestamp::ZERO;
        }
    }

    /// Sends what is due.
    fn report(&mut self, now: Timestamp, out: &mut Vec<Output>) {
        if !self.granted && now >= self.factsheet_at {
            self.factsheet_at = now + FACTSHEET_EVERY;
            self.send_factsheet(now, out);
        }
        let shows = self.shows(now);
        if now >= self.state_at || shows != self.shown {
            self.shown = shows;
            let every_ms = self.sheet.as_ref().map_or(100, |sheet| sheet.state_interval_ms.max(10));
            self.state_at = now + Duration::from_millis(u64::from(every_ms));
            let state = self.state(now);
            out.push(Output::State(Box::new(state)));
        }
    }

    fn send_factsheet(&mut self, now: Timestamp, out: &mut Vec<Output>) {
        let Some(sheet) = &self.sheet else { return };
        let mut sheet = sheet.clone();
        sheet.header = Some(self.header(now, 0));
        sheet.pid = self.pid;
        out.push(Output::Factsheet(sheet));
        let header = Some(self.header(now, 1));
        let connection_state = ConnectionState::Online.into();
        out.push(Output::Connection(v1::Connection { header, connection_state }));
    }

    fn shows(&self, now: Timestamp) -> Shown {
        Shown {
            order: (self.order.order_id, self.order.update_id),
            at_base_end: !self.order.has_base(),
            charging: self.base.charging,
            paused: self.paused,
            obstacle: self.watch.sees_something(),
            stuck: self.is_stuck(now),
            bumper: self.base.bumper,
        }
    }

    fn header(&mut self, now: Timestamp, topic: usize) -> v1::Header {
        self.headers[topic] += 1;
        v1::Header {
            header_id: self.headers[topic],
            timestamp_ns: now.as_nanos(),
            serial_number: self.serial_number.clone(),
            boot_id: self.boot_id,
        }
    }

    fn state(&mut self, now: Timestamp) -> v1::State {
        let place = self.localisation.place;
        v1::State {
            header: Some(self.header(now, 2)),
            request_ns: now.as_nanos(),
            order_id: self.order.order_id,
            order_update_id: self.order.update_id,
            last_node_sequence_id: self.order.passed(),
            pose: Some(v1::Pose { x_m: place.x, y_m: place.y, theta_rad: place.theta }),
            deviation_m: self.localisation.deviation_m,
            speed_m_per_s: self.base.speed,
            angular_speed_rad_per_s: self.base.turning,
            driving: self.base.speed.abs() > 0.01 || self.base.turning.abs() > 0.02,
            paused: self.paused,
            new_base_request: !self.order.has_base() && self.order.has_horizon(),
            state_of_charge_percent: self.base.charge_percent,
            charging: self.base.charging,
            station_id: self.station_id.clone(),
            swept_distance_m: self.log.swept_m,
            operating_mode: OperatingMode::Automatic.into(),
            errors: self.errors(now),
            sweep: self.log.to_send(),
            scan: self.last_scan.take(),
            term: self.lease.term,
            epoch: self.lease.epoch,
            released_sequence_id: self.order.released(),
        }
    }

    fn errors(&mut self, now: Timestamp) -> Vec<v1::Error> {
        let mut errors = Vec::new();
        if self.watch.sees_something() {
            let mut error = error(
                ErrorType::NodeUnreachable,
                ErrorLevel::Warning,
                "something stands on the granted ground",
                "waits; the coordinator plans around it when it stays",
            );
            error.points = self.watch.points();
            errors.push(error);
        }
        if self.is_stuck(now) {
            errors.push(error(
                ErrorType::Stuck,
                ErrorLevel::Critical,
                "the wheels are told to move and the pose does not change",
                "free the robot",
            ));
        }
        if self.localisation.slips() {
            errors.push(error(
                ErrorType::LocalizationError,
                ErrorLevel::Warning,
                "wheels and fixes disagree: slip",
                "what was swept meanwhile is not counted",
            ));
        }
        if self.base.bumper {
            errors.push(error(
                ErrorType::Bumper,
                ErrorLevel::Critical,
                "the bumper is pressed",
                "free the robot",
            ));
        }
        self.add_battery_error(&mut errors);
        if self.order.has_base() && !self.lease.is_valid(now, self.order.order_id) && self.granted {
            errors.push(error(
                ErrorType::ReleaseLost,
                ErrorLevel::Warning,
                "the lease ran out on the way",
                "stands until the coordinator renews it",
            ));
        }
        if let Some((kind, since)) = self.refused {
            if now.since(since) < REFUSAL_SHOWN {
                errors.push(error(kind, ErrorLevel::Warning, "an order was refused", "see the agent's log"));
            } else {
                self.refused = None;
            }
        }
        errors
    }

    fn add_battery_error(&self, errors: &mut Vec<v1::Error>) {
        let Some(levels) = self.sheet.as_ref().and_then(|sheet| sheet.battery_charging) else { return };
        if self.base.charging || self.base.charge_percent >= levels.minimum_desired_charging_level {
            return;
        }
        let critical = self.base.charge_percent < levels.critical_low_charging_level;
        let level = if critical { ErrorLevel::Critical } else { ErrorLevel::Urgent };
        errors.push(error(ErrorType::BatteryLow, level, "the battery is low", "charge"));
    }
}

/// The base's speeds are those of the last tick; what was asked since counts when it is near.
fn nearest_of(measured: f64, asked: f64) -> f64 {
    if (measured - asked).abs() < 0.05 { asked } else { measured }
}

fn error(kind: ErrorType, level: ErrorLevel, description: &str, hint: &str) -> v1::Error {
    v1::Error {
        error_type: kind.into(),
        error_level: level.into(),
        error_description: description.to_owned(),
        error_hint: hint.to_owned(),
        points: Vec::new(),
    }
}
