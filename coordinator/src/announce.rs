//! What is said to those who watch: events as they come, coverage changes, and once a second how it all stands.

use crate::{
    Config, Coordinator, Output, Publication,
    robot::{Blocker, Errand, Phase, Robot},
};
use protocol::{
    Timestamp,
    v1::{self, EventLevel, MissionState, RobotRole},
};
use std::time::Duration;

const STATUS_EVERY: Duration = Duration::from_secs(1);
const COVERAGE_EVERY: Duration = Duration::from_millis(500);

/// Gathers events until they are sent, and knows what is due.
#[derive(Debug)]
pub(crate) struct Announcer {
    events: Vec<v1::Event>,
    next_event: u64,
    next_status: Timestamp,
    next_coverage: Timestamp,
    conclusion: Option<String>,
}

impl Announcer {
    pub(crate) fn new(_config: &Config) -> Self {
        Self {
            events: Vec::new(),
            next_event: 1,
            next_status: Timestamp::ZERO,
            next_coverage: Timestamp::ZERO,
            conclusion: None,
        }
    }

    /// Notes an event and returns its number.
    pub(crate) fn event(
        &mut self,
        now: Timestamp,
        level: EventLevel,
        robot: &str,
        event: &str,
        text: &str,
    ) -> u64 {
        let event_id = self.next_event;
        self.next_event += 1;
        self.events.push(v1::Event {
            event_id,
            timestamp_ns: now.as_nanos(),
            level: level.into(),
            serial_number: robot.to_owned(),
            event: event.to_owned(),
            text: text.to_owned(),
        });
        event_id
    }

    /// Hands out the events.
    pub(crate) fn drain(&mut self, out: &mut Vec<Output>) {
        out.extend(self.events.drain(..).map(|event| Output::Publish(Publication::Event(event))));
    }

    /// Notes that the mission has ended.
    pub(crate) fn conclude(&mut self, _now: Timestamp, _state: MissionState, cause: &str) {
        self.conclusion = Some(cause.to_owned());
    }

    pub(crate) fn take_conclusion(&mut self) -> Option<String> {
        self.conclusion.take()
    }

    pub(crate) fn status_due(&mut self, now: Timestamp) -> bool {
        due(&mut self.next_status, now, STATUS_EVERY)
    }

    pub(crate) fn coverage_due(&mut self, now: Timestamp) -> bool {
        due(&mut self.next_coverage, now, COVERAGE_EVERY)
    }

    pub(crate) fn result_event(&mut self, now: Timestamp, result: &v1::MissionResult) {
        let covered = result.progress.as_ref().map_or(0.0, |progress| progress.covered_percent);
        let mut text = format!(
            "{covered:.1} % covered in {:.0} s, {} replans, {} robots lost",
            result.duration_s, result.replans, result.robots_lost
        );
        if !result.gaps.is_empty() {
            text = format!("{text}, {} gaps", result.gaps.len());
        }
        if !result.out_of_reach.is_empty() {
            text = format!("{text}, {} parts out of reach", result.out_of_reach.len());
        }
        if !result.cause.is_empty() {
            text = format!("{}; {text}", result.cause);
        }
        let level = match result.mission_state() {
            MissionState::Failed => EventLevel::EventError,
            MissionState::CompletedWithGaps => EventLevel::EventWarning,
            _ => EventLevel::EventInfo,
        };
        self.event(now, level, "", result.mission_state().as_str_name(), &text);
    }
}

fn due(next: &mut Timestamp, now: Timestamp, every: Duration) -> bool {
    let is_due = now >= *next;
    if is_due {
        *next = now + every;
    }
    is_due
}

impl Coordinator {
    /// Publishes what changed, and once a second how everything stands.
    pub(crate) fn announce(&mut self, now: Timestamp, out: &mut Vec<Output>) {
        let ends = self.announcer.take_conclusion();
        if ends.is_some() || self.announcer.coverage_due(now) {
            let names: Vec<&str> = self.robots.iter().map(|robot| robot.id.as_str()).collect();
            if let Some(delta) = self.ledger.take_delta(now, &names) {
                Self::publish(out, Publication::Coverage(delta));
            }
            Self::publish(out, Publication::Reservations(self.reservations(now)));
        }
        if ends.is_some() || self.announcer.status_due(now) {
            self.estimate_remaining();
            Self::publish(out, Publication::Status(Box::new(self.status(now))));
        }
        if let Some(cause) = ends {
            let result = self.result(now, &cause);
            self.announcer.result_event(now, &result);
            self.announcer.drain(out);
            Self::publish(out, Publication::Result(result));
        }
    }

    /// How everything stands.
    pub(crate) fn status(&self, now: Timestamp) -> v1::FleetStatus {
        let mut progress = self.ledger.progress();
        progress.remaining_s = self.robots.iter().map(|robot| robot.remaining_s).fold(0.0, f64::max);
        let mut assigned = vec![0_u32; self.robots.len()];
        for index in 0..self.floor.lattice().len() {
            if let crate::ledger::Status::Assigned(robot) = self.ledger.status(index) {
                assigned[robot] += 1;
            }
        }
        v1::FleetStatus {
            timestamp_ns: now.as_nanos(),
            mission_id: self.config.mission.id.clone(),
            mission_state: self.state.into(),
            plan_revision: self.replanning.revision(),
            progress: Some(progress),
            robots: self
                .robots
                .iter()
                .zip(assigned)
                .map(|(robot, cells_assigned)| self.robot_status(robot, cells_assigned))
                .collect(),
            zones: self.zones.to_wire(&self.floor),
            term: self.config.term,
            stations: self.station_statuses(),
        }
    }

    fn robot_status(&self, robot: &Robot, cells_assigned: u32) -> v1::RobotStatus {
        let state = robot.state.as_ref();
        v1::RobotStatus {
            serial_number: robot.id.clone(),
            role: self.role(robot).into(),
            pose: state.and_then(|state| state.pose),
            state_of_charge_percent: state.map_or(0.0, |state| state.state_of_charge_percent),
            order_id: robot.route.order_id(),
            order_update_id: robot.route.update_id(),
            cells_assigned,
            cells_covered: robot.cells_covered,
            swept_distance_m: state.map_or(0.0, |state| state.swept_distance_m),
            remaining_s: robot.remaining_s,
            waits_for: self.waits_for(robot),
            boot_id: robot.boot_id,
            body_radius_m: self.config.mission.body_radius_m,
            errors: state.map_or_else(Vec::new, |state| {
                state.errors.iter().map(|error| error.error_type().as_str_name().to_owned()).collect()
            }),
        }
    }

    fn waits_for(&self, robot: &Robot) -> String {
        match robot.wait.map(|wait| wait.on) {
            Some(Blocker::Robot(other)) => self.robots[other].id.clone(),
            Some(Blocker::Zone(zone)) => format!("zone {zone}"),
            None => robot.hold.map_or_else(String::new, |hold| self.robots[hold.for_robot].id.clone()),
        }
    }

    fn role(&self, robot: &Robot) -> RobotRole {
        match (robot.phase, robot.errand) {
            (Phase::Offline | Phase::Joining, _) => RobotRole::RoleOffline,
            (Phase::Suspect, _) => RobotRole::RoleSuspect,
            (Phase::Lost, _) => RobotRole::RoleLost,
            (Phase::Ready, _) if robot.stuck => RobotRole::RoleError,
            (Phase::Ready, _) if self.state == MissionState::Paused => RobotRole::RolePaused,
            (Phase::Ready, _) if robot.obstacle_since.is_some() => RobotRole::RoleBlocked,
            (Phase::Ready, Errand::Charging(_)) => RobotRole::RoleCharging,
            (Phase::Ready, Errand::Queue(_)) => RobotRole::RoleQueuedForDock,
            (Phase::Ready, Errand::ToStation(_) | Errand::Home) => RobotRole::RoleReturning,
            (Phase::Ready, _) if robot.route.is_done() => RobotRole::RoleIdle,
            (Phase::Ready, _) if robot.wait.is_some() && robot.stands_at_base_end() => RobotRole::RoleWaiting,
            (Phase::Ready, _) => match robot.route.ahead().nth(1) {
                Some(next) if next.tool_active => RobotRole::RoleCovering,
                _ => RobotRole::RoleTransit,
            },
        }
    }

    fn station_statuses(&self) -> Vec<v1::StationStatus> {
        let name = |robot: usize| self.robots[robot].id.clone();
        self.stations
            .iter()
            .map(|station| v1::StationStatus {
                station_id: station.id.clone(),
                occupied_by: station.occupied_by.map_or_else(String::new, name),
                queue: station.queue.iter().map(|&robot| name(robot)).collect(),
                out_of_order: station.broken_until.is_some(),
                position: Some(v1::Point { x_m: station.position.x, y_m: station.position.y }),
            })
            .collect()
    }

    /// Who holds which ground.
    pub(crate) fn reservations(&self, now: Timestamp) -> v1::Reservations {
        let point = |p: terrain::Point| v1::Point { x_m: p.x, y_m: p.y };
        let reservations = self
            .robots
            .iter()
            .filter(|robot| !robot.held.is_empty())
            .map(|robot| v1::Reservation {
                serial_number: robot.id.clone(),
                epoch: robot.epoch,
                line: robot.route.base().map(|node| point(node.point)).collect(),
                half_width_m: self.separation_m() / 2.0,
            })
            .collect();
        v1::Reservations { timestamp_ns: now.as_nanos(), reservations }
    }
}
