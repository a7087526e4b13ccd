//! The drive: the last one who can say no. Space cannot refuse a robot that came back from a long pause; the drive
//! can.
//!
//! A setpoint moves the wheels only when it
//! - carries a grant that is not older than the newest one seen, by (term, epoch);
//! - comes from the boot of the agent that the newest grant was for;
//! - is younger than its own lease end, and than the watchdog.
//!
//! A setpoint's authority ends in space, too: it says how far the robot may still roll until it must stand, and the
//! drive brakes in time for that by itself. So an agent that dies just before a corner leaves no robot in the wall.
//!
//! A setpoint that asks to stand is obeyed from whoever holds the newest grant, lease or not: stopping is always
//! allowed.

use protocol::{Timestamp, v1};
use std::time::Duration;

/// No fresh setpoint for so long: stop.
pub const WATCHDOG: Duration = Duration::from_millis(200);

/// Speeds asked of the wheels.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Twist {
    pub(crate) speed_m_per_s: f64,
    pub(crate) angular_speed_rad_per_s: f64,
    pub(crate) tool_active: bool,
    /// It must stand after rolling so far, metres.
    pub(crate) run_m: f64,
}

/// Why a setpoint was dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refusal {
    /// Its grant is older than one seen before.
    OldGrant,
    /// It comes from another start of the agent than the newest grant is for.
    OtherBoot,
    /// Its lease is over, or there was none.
    LeaseOver,
    /// It is no number.
    NotFinite,
}

impl Refusal {
    /// For the agent's log.
    pub const fn text(self) -> &'static str {
        match self {
            Self::OldGrant => "its grant is older than one seen before",
            Self::OtherBoot => "the newest grant is for another start of the agent",
            Self::LeaseOver => "its lease is over",
            Self::NotFinite => "it is not a finite speed",
        }
    }
}

/// The gate before the wheels of one robot.
#[derive(Debug, Clone)]
pub(crate) struct Drive {
    newest: (u64, u64),
    boot_id: u64,
    asked: Twist,
    received: Timestamp,
    valid_until: Timestamp,
    refusal: Option<Refusal>,
}

impl Drive {
    pub(crate) fn new() -> Self {
        Self {
            newest: (0, 0),
            boot_id: 0,
            asked: Twist::default(),
            received: Timestamp::ZERO,
            valid_until: Timestamp::ZERO,
            refusal: None,
        }
    }

    /// Takes or drops a setpoint.
    pub(crate) fn take(&mut self, now: Timestamp, setpoint: &v1::Setpoint) {
        self.refusal = self.judge(now, setpoint).err();
        if self.refusal.is_none() {
            self.newest = (setpoint.term, setpoint.epoch);
            self.boot_id = setpoint.boot_id;
            self.asked = Twist {
                speed_m_per_s: setpoint.speed_m_per_s,
                angular_speed_rad_per_s: setpoint.angular_speed_rad_per_s,
                tool_active: setpoint.tool_active,
                run_m: if setpoint.run_m > 0.0 { setpoint.run_m } else { f64::INFINITY },
            };
            self.received = now;
            self.valid_until = Timestamp::from_nanos(setpoint.valid_until_ns);
        } else if stands(setpoint) {
            self.refusal = None; // nothing was refused that anybody asked for
        }
    }

    fn judge(&self, now: Timestamp, setpoint: &v1::Setpoint) -> Result<(), Refusal> {
        let grant = (setpoint.term, setpoint.epoch);
        if !(setpoint.speed_m_per_s.is_finite() && setpoint.angular_speed_rad_per_s.is_finite()) {
            Err(Refusal::NotFinite)
        } else if grant < self.newest {
            Err(Refusal::OldGrant)
        } else if grant == self.newest && self.boot_id != 0 && setpoint.boot_id != self.boot_id {
            Err(Refusal::OtherBoot)
        } else if now.as_nanos() > setpoint.valid_until_ns && !stands(setpoint) {
            Err(Refusal::LeaseOver)
        } else {
            Ok(())
        }
    }

    /// What the wheels are to do now: stand, when the last good setpoint is too old or its lease is over.
    pub(crate) fn asked(&self, now: Timestamp, watchdog: Duration) -> Twist {
        let fresh = now.since(self.received) <= watchdog;
        let leased = now <= self.valid_until;
        if fresh && leased { self.asked } else { Twist::default() }
    }

    /// The wheels rolled; so much less is left.
    pub(crate) fn rolled(&mut self, way_m: f64) {
        self.asked.run_m -= way_m.abs();
    }

    /// Why the last setpoint was dropped, if it was.
    pub(crate) fn refusal(&self) -> Option<Refusal> {
        self.refusal
    }
}

fn stands(setpoint: &v1::Setpoint) -> bool {
    setpoint.speed_m_per_s == 0.0 && setpoint.angular_speed_rad_per_s == 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(milliseconds: u64) -> Timestamp {
        Timestamp::from_nanos(milliseconds * 1_000_000)
    }

    fn setpoint(term: u64, epoch: u64, boot_id: u64, valid_until_ms: u64) -> v1::Setpoint {
        v1::Setpoint {
            speed_m_per_s: 0.5,
            term,
            epoch,
            boot_id,
            valid_until_ns: valid_until_ms * 1_000_000,
            ..v1::Setpoint::default()
        }
    }

    fn speed(drive: &Drive, now: Timestamp) -> f64 {
        drive.asked(now, WATCHDOG).speed_m_per_s
    }

    #[test]
    fn a_fresh_setpoint_with_a_lease_is_driven() {
        let mut drive = Drive::new();
        drive.take(at(0), &setpoint(1, 1, 9, 3000));
        assert_eq!((drive.refusal(), speed(&drive, at(20))), (None, 0.5));
    }

    #[test]
    fn the_watchdog_stops_a_silent_agent_after_200_ms() {
        let mut drive = Drive::new();
        drive.take(at(0), &setpoint(1, 1, 9, 3000));
        assert_eq!((speed(&drive, at(200)), speed(&drive, at(220))), (0.5, 0.0));
    }

    #[test]
    fn the_end_of_the_lease_stops_it_even_when_setpoints_keep_coming() {
        let mut drive = Drive::new();
        drive.take(at(0), &setpoint(1, 1, 9, 100));
        assert!(speed(&drive, at(120)).abs() < 1e-12);
        drive.take(at(120), &setpoint(1, 1, 9, 100));
        assert_eq!(drive.refusal(), Some(Refusal::LeaseOver));
    }

    #[test]
    fn an_older_epoch_or_term_is_refused_and_a_newer_one_taken() {
        let mut drive = Drive::new();
        drive.take(at(0), &setpoint(2, 5, 9, 3000));
        drive.take(at(20), &setpoint(2, 4, 9, 3000));
        assert_eq!(drive.refusal(), Some(Refusal::OldGrant));
        drive.take(at(40), &setpoint(1, 9, 9, 3000));
        assert_eq!(drive.refusal(), Some(Refusal::OldGrant));
        drive.take(at(60), &setpoint(3, 0, 9, 3000));
        assert_eq!(drive.refusal(), None);
    }

    #[test]
    fn a_grant_belongs_to_one_start_of_the_agent() {
        let mut drive = Drive::new();
        drive.take(at(0), &setpoint(1, 1, 9, 3000));
        drive.take(at(20), &setpoint(1, 1, 8, 3000));
        assert_eq!(drive.refusal(), Some(Refusal::OtherBoot));
        drive.take(at(40), &setpoint(1, 2, 8, 3000));
        assert_eq!(drive.refusal(), None);
    }

    #[test]
    fn without_any_grant_nothing_moves() {
        let mut drive = Drive::new();
        drive.take(at(20), &setpoint(0, 0, 9, 0));
        assert_eq!((drive.refusal(), speed(&drive, at(40))), (Some(Refusal::LeaseOver), 0.0));
    }

    #[test]
    fn standing_is_always_allowed_and_never_reported_as_refused() {
        let mut drive = Drive::new();
        drive.take(at(0), &setpoint(1, 1, 9, 3000));
        let stop = v1::Setpoint { speed_m_per_s: 0.0, ..setpoint(1, 1, 9, 0) };
        drive.take(at(20), &stop);
        assert_eq!((drive.refusal(), speed(&drive, at(20))), (None, 0.0));
    }
}
