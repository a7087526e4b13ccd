//! One robot in the world: its true pose, its wheels, and everything that has befallen it.
//!
//! ```text
//!   setpoint ──▶ drive (grant? lease? watchdog?) ──▶ wheels (acceleration, slow) ──▶ odometry
//!                                                      │
//!                                                      └─ × slip ──▶ true pose ──▶ fixes, range finder
//! ```

use crate::{
    battery::{Battery, Load},
    drive::{Drive, Twist},
    localisation::{Localisation, arc},
    scenario::{RobotEntry, Scenario},
};
use protocol::{Timestamp, v1};
use std::time::Duration;
use terrain::{Point, Pose, Segment, Vector};

/// A straight piece of the tool's way is swept in one go up to this length, metres.
const SWEEP_PIECE_M: f64 = 0.5;
/// … and while its heading changes by less than this, radians.
const SWEEP_BEND_RAD: f64 = 0.004;

/// The drive cuts in only this far behind the end of the agent's run, metres.
const RUN_SLACK_M: f64 = 0.01;

/// A factor that holds for a while.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Spell {
    pub(crate) factor: f64,
    pub(crate) until: Option<Timestamp>,
}

/// What has befallen a robot.
#[derive(Debug, Clone, Default)]
pub(crate) struct Ailments {
    /// Share of the wheels' way that the body makes: 1 on good ground, 0 when it is stuck.
    pub(crate) slip: Option<Spell>,
    /// Share of the top speeds that is left.
    pub(crate) slow: Option<Spell>,
    /// How many times faster the battery drains.
    pub(crate) drain: Option<Spell>,
    /// The radio is jammed while this lasts.
    pub(crate) cut: Option<Spell>,
}

/// One robot.
#[derive(Debug, Clone)]
pub(crate) struct Body {
    pub(crate) id: String,
    pub(crate) start: Pose,
    pub(crate) pose: Pose,
    pub(crate) speed_m_per_s: f64,
    pub(crate) angular_speed_rad_per_s: f64,
    pub(crate) tool_active: bool,
    pub(crate) drive: Drive,
    pub(crate) battery: Battery,
    pub(crate) localisation: Localisation,
    pub(crate) ailments: Ailments,
    pub(crate) on_floor: bool,
    /// The station whose contacts it touches and that works.
    pub(crate) docked: Option<usize>,
    pub(crate) bumper: bool,
    pub(crate) fresh_scan: Option<v1::RangeScan>,
    /// When its agent was last heard.
    pub(crate) heard: Timestamp,
    pub(crate) carry_off_after_s: f64,
    limits: Limits,
    proposed: Pose,
    sweep_from: Option<(Point, f64)>,
}

#[derive(Debug, Clone, Copy)]
struct Limits {
    speed_m_per_s: f64,
    acceleration_m_per_s2: f64,
    angular_speed_rad_per_s: f64,
    angular_acceleration_rad_per_s2: f64,
}

impl Body {
    pub(crate) fn new(scenario: &Scenario, entry: &RobotEntry, seed: u64) -> Self {
        let robot = &scenario.file.robot;
        let start = Pose::new(Vector::new(entry.x_m, entry.y_m), entry.theta_deg.to_radians());
        Self {
            id: entry.id.clone(),
            start,
            pose: start,
            speed_m_per_s: 0.0,
            angular_speed_rad_per_s: 0.0,
            tool_active: false,
            drive: Drive::new(),
            battery: Battery::new(robot),
            localisation: Localisation::new(&scenario.file.sim, seed, &entry.id, start),
            ailments: Ailments::default(),
            on_floor: true,
            docked: None,
            bumper: false,
            fresh_scan: None,
            heard: Timestamp::ZERO,
            carry_off_after_s: scenario.file.sim.carry_off_after_s.seconds(),
            limits: Limits {
                speed_m_per_s: robot.speed_m_per_s,
                acceleration_m_per_s2: robot.acceleration_m_per_s2,
                angular_speed_rad_per_s: robot.angular_speed_rad_per_s,
                angular_acceleration_rad_per_s2: robot.angular_acceleration_rad_per_s2,
            },
            proposed: start,
            sweep_from: None,
        }
    }

    pub(crate) fn position(&self) -> Point {
        Point::from(self.pose.translation.vector)
    }

    pub(crate) fn is_dead(&self) -> bool {
        self.battery.is_empty()
    }

    pub(crate) fn is_radio_jammed(&self) -> bool {
        self.ailments.cut.is_some()
    }

    /// Room it needs to stop, metres.
    pub(crate) fn stopping_m(&self) -> f64 {
        self.speed_m_per_s * self.speed_m_per_s / (2.0 * self.limits.acceleration_m_per_s2)
    }

    /// Where it drives to: a vector of length 1, zero when it stands.
    pub(crate) fn direction_of_motion(&self) -> Vector {
        if self.speed_m_per_s.abs() < 0.02 {
            return Vector::zeros();
        }
        self.pose.rotation * Vector::new(self.speed_m_per_s.signum(), 0.0)
    }

    /// Turns the wheels for one step; where the body would go is in [`Self::way`].
    pub(crate) fn turn_wheels(&mut self, now: Timestamp, step_s: f64, watchdog: Duration) {
        let asked =
            if self.is_dead() || !self.on_floor { Twist::default() } else { self.drive.asked(now, watchdog) };
        self.tool_active = asked.tool_active;
        let (slow, limits) = (factor(self.ailments.slow), self.limits);
        let top = limits.speed_m_per_s * slow;
        let top_turn = limits.angular_speed_rad_per_s * slow;
        let top =
            top.min(stoppable_m_per_s(asked.run_m, self.speed_m_per_s, limits.acceleration_m_per_s2, step_s));
        let was = (self.speed_m_per_s, self.angular_speed_rad_per_s);
        let asked = if stands(asked) {
            braked_on_its_bend(asked, was, limits.acceleration_m_per_s2 * step_s)
        } else {
            cut_alike(asked, top, top_turn)
        };
        self.speed_m_per_s = towards(was.0, asked.speed_m_per_s, limits.acceleration_m_per_s2 * step_s);
        self.angular_speed_rad_per_s =
            towards(was.1, asked.angular_speed_rad_per_s, limits.angular_acceleration_rad_per_s2 * step_s);
        let way_m = f64::midpoint(was.0, self.speed_m_per_s) * step_s;
        let turn_rad = f64::midpoint(was.1, self.angular_speed_rad_per_s) * step_s;
        if way_m == 0.0 && turn_rad == 0.0 {
            self.proposed = self.pose;
            return;
        }
        self.drive.rolled(way_m);
        self.localisation.roll(way_m, turn_rad);
        let grip = factor(self.ailments.slip);
        self.proposed = self.pose * arc(way_m * grip, turn_rad * grip);
        self.proposed.rotation.renormalize_fast();
    }

    /// The way of this step, unless something is in it.
    pub(crate) fn way(&self) -> Segment {
        Segment::new(self.position(), Point::from(self.proposed.translation.vector))
    }

    /// Something solid is in the way: the body stays where it is.
    pub(crate) fn bump(&mut self) {
        self.proposed.translation = self.pose.translation;
        self.speed_m_per_s = 0.0;
        self.bumper = true;
    }

    /// Goes where nothing stopped it, and pays for it.
    pub(crate) fn move_on(&mut self, step_s: f64) {
        self.pose = self.proposed;
        let load = Load {
            speed_m_per_s: self.speed_m_per_s,
            angular_speed_rad_per_s: self.angular_speed_rad_per_s,
            tool_active: self.tool_active,
        };
        self.battery.drain(load, factor(self.ailments.drain), step_s);
    }

    /// The tool's way since the last call, when it is time to sweep it; `now_or_never` sweeps whatever there is.
    pub(crate) fn take_sweep(&mut self, now_or_never: bool) -> Option<Segment> {
        let here = self.position();
        let heading_rad = self.pose.rotation.angle();
        let Some((from, heading)) = self.sweep_from else {
            if self.tool_active {
                self.sweep_from = Some((here, heading_rad));
            }
            return None;
        };
        if self.tool_active && (here - from).norm() < 0.002 && !now_or_never {
            self.sweep_from = Some((from, heading_rad)); // turns in place
            return None;
        }
        let bent = terrain::angle_between(heading, heading_rad).abs() > SWEEP_BEND_RAD;
        let long = (here - from).norm() > SWEEP_PIECE_M;
        if self.tool_active && !bent && !long && !now_or_never {
            return None;
        }
        self.sweep_from = self.tool_active.then_some((here, heading_rad));
        Some(Segment::new(from, here))
    }

    /// The floor crew takes it away, and keeps it by its start.
    pub(crate) fn carry_off(&mut self, scenario: &Scenario, seed: u64) {
        self.on_floor = false;
        self.pose = self.start;
        self.proposed = self.start;
        self.sweep_from = None;
        (self.speed_m_per_s, self.angular_speed_rad_per_s, self.tool_active) = (0.0, 0.0, false);
        self.docked = None;
        self.localisation = Localisation::new(&scenario.file.sim, seed, &self.id, self.start);
    }

    /// Ends what has lasted long enough.
    pub(crate) fn recover(&mut self, now: Timestamp) {
        let ailments = &mut self.ailments;
        for spell in [&mut ailments.slip, &mut ailments.slow, &mut ailments.drain, &mut ailments.cut] {
            if spell.is_some_and(|spell| spell.until.is_some_and(|until| now >= until)) {
                *spell = None;
            }
        }
    }

    pub(crate) fn truth(&self) -> v1::BodyTruth {
        v1::BodyTruth {
            serial_number: self.id.clone(),
            pose: Some(crate::localisation::pose_message(&self.pose)),
            speed_m_per_s: self.speed_m_per_s * factor(self.ailments.slip),
            tool_active: self.tool_active,
            state_of_charge_percent: self.battery.percent(),
            on_floor: self.on_floor,
            charging: self.docked.is_some(),
        }
    }
}

fn factor(spell: Option<Spell>) -> f64 {
    spell.map_or(1.0, |spell| spell.factor)
}

/// The highest speed after this step from which the drive can stop within `run_m` and the slack it allows the agent.
fn stoppable_m_per_s(run_m: f64, speed_m_per_s: f64, acceleration_m_per_s2: f64, step_s: f64) -> f64 {
    let half = acceleration_m_per_s2 * step_s / 2.0;
    let left_m = run_m + RUN_SLACK_M - speed_m_per_s.abs() * step_s / 2.0;
    ((half * half + 2.0 * acceleration_m_per_s2 * left_m).max(0.0).sqrt() - half).max(0.0)
}

fn stands(asked: Twist) -> bool {
    asked.speed_m_per_s == 0.0 && asked.angular_speed_rad_per_s == 0.0
}

/// A robot that is to stand stays on its bend while it brakes: it turns as much less as it drives less.
fn braked_on_its_bend(asked: Twist, was: (f64, f64), slower_m_per_s: f64) -> Twist {
    if was.0.abs() < 0.02 {
        return asked;
    }
    let share = (1.0 - slower_m_per_s / was.0.abs()).max(0.0);
    Twist { angular_speed_rad_per_s: was.1 * share, ..asked }
}

/// What the wheels can do of what is asked: both speeds are cut by the same share, so that a slow robot stays on its
/// bend.
fn cut_alike(asked: Twist, top: f64, top_turn: f64) -> Twist {
    let share = |value: f64, most: f64| if value.abs() > most { most / value.abs() } else { 1.0 };
    let both = share(asked.speed_m_per_s, top).min(share(asked.angular_speed_rad_per_s, top_turn));
    Twist {
        speed_m_per_s: asked.speed_m_per_s * both,
        angular_speed_rad_per_s: asked.angular_speed_rad_per_s * both,
        ..asked
    }
}

fn towards(value: f64, target: f64, most: f64) -> f64 {
    value + (target - value).clamp(-most, most)
}
