//! One robot of the roster: who it is, whether it is there, what it does and which ground it holds.

use crate::{
    break_off::PlannedBreak,
    energy::Energy,
    ledger::RobotIndex,
    route::{Route, Waypoint},
};
use protocol::{Timestamp, v1};
use terrain::{MotionModel, Point, Segment};

/// Whether a robot is there. Three signals feed it: the liveliness token, its own heartbeat (`State`), and its
/// progress against the plan ([`Robot::stuck`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Phase {
    /// Expected, never heard of; or it left in good order.
    Offline,
    /// Talks, but has not said what it is and where.
    Joining,
    /// Takes orders.
    Ready,
    /// Silent: no new ground, its horizon is given away.
    Suspect,
    /// Silent for long: its ground becomes a quarantine when the lease has run out.
    Lost,
}

/// What a robot is out for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Errand {
    /// Covers, or stands ready for it.
    Cover,
    /// Drives to a station (by number).
    ToStation(usize),
    /// Waits until a station is free.
    Queue(usize),
    /// Charges at a station.
    Charging(usize),
    /// Goes to see whether a zone is free (by id).
    Look(u64),
    /// Drives back to where it joined.
    Home,
}

/// What keeps a robot from getting more ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Blocker {
    /// Ground of another robot.
    Robot(RobotIndex),
    /// A zone, by id.
    Zone(u64),
}

/// Since when a robot waits, and for what.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Wait {
    pub(crate) on: Blocker,
    pub(crate) since: Timestamp,
}

/// A robot that moved aside waits there until another one has passed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Hold {
    /// The node on which it waits.
    pub(crate) at: u64,
    pub(crate) for_robot: RobotIndex,
    /// Order and node of the other robot by which it is out of the way.
    pub(crate) their_order: u64,
    pub(crate) until_passed: u64,
    pub(crate) until: Timestamp,
}

/// A robot of the roster.
#[derive(Debug)]
pub(crate) struct Robot {
    pub(crate) id: String,
    pub(crate) boot_id: u64,
    pub(crate) epoch: u64,
    pub(crate) phase: Phase,
    pub(crate) token: bool,
    pub(crate) factsheet: Option<Box<v1::Factsheet>>,
    pub(crate) energy: Option<Energy>,
    pub(crate) state: Option<Box<v1::State>>,
    pub(crate) heard: Timestamp,
    pub(crate) silent_since: Timestamp,
    pub(crate) errand: Errand,
    pub(crate) stuck: bool,
    /// How often it was tried again after it was stuck, and when it is next.
    pub(crate) tries: u32,
    pub(crate) try_at: Timestamp,
    /// Where it was stuck; away from there it counts as freed.
    pub(crate) freed_from: (f64, f64),
    pub(crate) home: Option<Point>,
    pub(crate) route: Route,
    /// What it goes on with when it is charged, from where that begins; empty when nothing.
    pub(crate) resumes: Vec<Waypoint>,
    /// Where its route is best broken off to charge.
    pub(crate) break_off: Option<PlannedBreak>,
    pub(crate) order_sent: Timestamp,
    /// Ground of an order that was taken away and not yet acknowledged, and until when it may still be driven.
    pub(crate) retiring: Vec<Segment>,
    pub(crate) retiring_until: Timestamp,
    /// Its ground was given up as a quarantine: what it was granted is void.
    pub(crate) ground_taken: bool,
    /// Ground that nobody else may enter.
    pub(crate) held: Vec<Segment>,
    pub(crate) lease_until: Timestamp,
    pub(crate) wait: Option<Wait>,
    pub(crate) hold: Option<Hold>,
    /// When it last moved aside, the latest last; a few.
    pub(crate) yielded: Vec<Timestamp>,
    pub(crate) obstacle_since: Option<Timestamp>,
    pub(crate) moved_at: Timestamp,
    /// When it last passed a place of its route, or had none to go to.
    pub(crate) passed_at: Timestamp,
    pub(crate) moved_from: v1::Pose,
    pub(crate) uncharged_since: Option<Timestamp>,
    pub(crate) sweep_sequence: u64,
    pub(crate) sweep_at: Option<Point>,
    pub(crate) cells_covered: u32,
    pub(crate) remaining_s: f64,
    pub(crate) headers: u64,
    pub(crate) last_header: u64,
}

impl Robot {
    pub(crate) fn new(id: &str) -> Self {
        Self {
            id: id.to_owned(),
            boot_id: 0,
            epoch: 1,
            phase: Phase::Offline,
            token: false,
            factsheet: None,
            energy: None,
            state: None,
            heard: Timestamp::ZERO,
            silent_since: Timestamp::ZERO,
            errand: Errand::Cover,
            stuck: false,
            tries: 0,
            try_at: Timestamp::ZERO,
            freed_from: (0.0, 0.0),
            home: None,
            route: Route::default(),
            resumes: Vec::new(),
            break_off: None,
            order_sent: Timestamp::ZERO,
            retiring: Vec::new(),
            retiring_until: Timestamp::ZERO,
            ground_taken: false,
            held: Vec::new(),
            lease_until: Timestamp::ZERO,
            wait: None,
            hold: None,
            yielded: Vec::new(),
            obstacle_since: None,
            moved_at: Timestamp::ZERO,
            passed_at: Timestamp::ZERO,
            moved_from: v1::Pose::default(),
            uncharged_since: None,
            sweep_sequence: 0,
            sweep_at: None,
            cells_covered: 0,
            remaining_s: 0.0,
            headers: 0,
            last_header: 0,
        }
    }

    /// Where it says it is.
    pub(crate) fn position(&self) -> Option<Point> {
        let pose = self.state.as_ref()?.pose.as_ref()?;
        Some(Point::new(pose.x_m, pose.y_m))
    }

    /// The heading it says it has.
    pub(crate) fn heading_rad(&self) -> Option<f64> {
        self.state.as_ref()?.pose.as_ref().map(|pose| pose.theta_rad)
    }

    /// Charge of its battery, percent.
    pub(crate) fn charge_percent(&self) -> f64 {
        self.state.as_ref().map_or(100.0, |state| state.state_of_charge_percent)
    }

    /// Whether it takes part in coverage now.
    pub(crate) fn can_cover(&self) -> bool {
        self.phase == Phase::Ready && !self.stuck && matches!(self.errand, Errand::Cover | Errand::Look(_))
    }

    /// Whether the agent has the order as it stands.
    pub(crate) fn has_acknowledged(&self) -> bool {
        self.state.as_ref().is_some_and(|state| {
            state.order_id == self.route.order_id() && state.order_update_id == self.route.update_id()
        })
    }

    /// Whether it has driven all the ground it was granted.
    pub(crate) fn stands_at_base_end(&self) -> bool {
        self.route.passed() >= self.route.released()
    }

    /// Number for the next message to it.
    pub(crate) fn next_header(&mut self) -> u64 {
        self.headers += 1;
        self.headers
    }

    /// Way still to be driven on granted ground, metres.
    pub(crate) fn base_ahead_m(&self) -> f64 {
        let mut places = self.route.base().map(|node| node.point);
        let Some(first) = places.next() else { return 0.0 };
        let mut at = first;
        let mut total = 0.0;
        for place in places {
            total += (place - at).norm();
            at = place;
        }
        let driven = self.position().map_or(0.0, |position| (position - first).norm());
        (total - driven).max(0.0)
    }

    /// Works out anew which ground it holds: its base, where it stands, and what it may still believe to hold.
    pub(crate) fn refresh_held(&mut self) {
        self.held.clear();
        self.held.extend_from_slice(&self.retiring);
        if let Some(position) = self.position() {
            self.held.push(Segment::new(position, position));
        }
        let mut before: Option<Point> = None;
        for node in self.route.base() {
            self.held.push(Segment::new(before.unwrap_or(node.point), node.point));
            before = Some(node.point);
        }
    }

    /// How it drives, by its factsheet.
    pub(crate) fn motion(&self) -> Option<MotionModel> {
        let sheet = self.factsheet.as_ref()?;
        Some(MotionModel {
            speed_m_per_s: sheet.speed_max_m_per_s,
            acceleration_m_per_s2: sheet.acceleration_max_m_per_s2,
            angular_speed_rad_per_s: sheet.angular_speed_max_rad_per_s,
            angular_acceleration_rad_per_s2: sheet.angular_acceleration_max_rad_per_s2,
            brakes: true,
        })
    }
}
