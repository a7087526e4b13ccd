//! A robot's session with the coordinator's router, as zenoh keeps it: opened when the process comes, noticed as
//! gone at once when the process dies, after a lease when it hangs or the link is cut.

use protocol::Timestamp;
use std::time::Duration;

/// A dead process closes its socket.
const DEATH_SEEN: Duration = Duration::from_millis(5);
/// zenoh's lease.
const LEASE: Duration = Duration::from_secs(1);
/// Until a session is open (again).
const OPENING: Duration = Duration::from_millis(300);

/// How a robot's process is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Process {
    Running,
    Frozen,
    Dead,
}

/// The session of one robot.
#[derive(Debug, Clone)]
pub(crate) struct Session {
    process: Process,
    cut: bool,
    open: bool,
    change_at: Option<Timestamp>,
}

impl Session {
    pub(crate) fn new() -> Self {
        Self { process: Process::Dead, cut: false, open: false, change_at: None }
    }

    pub(crate) fn is_open(&self) -> bool {
        self.open
    }

    /// Whether a message gets through now.
    pub(crate) fn carries(&self) -> bool {
        self.open && !self.cut && self.process != Process::Dead
    }

    pub(crate) fn set_process(&mut self, now: Timestamp, process: Process) {
        self.process = process;
        self.plan_change(now);
    }

    pub(crate) fn set_cut(&mut self, now: Timestamp, cut: bool) {
        if self.cut != cut {
            self.cut = cut;
            self.plan_change(now);
        }
    }

    fn plan_change(&mut self, now: Timestamp) {
        let healthy = self.process == Process::Running && !self.cut;
        let delay = match (healthy, self.process) {
            (true, _) => OPENING,
            (false, Process::Dead) => DEATH_SEEN,
            (false, _) => LEASE,
        };
        self.change_at = (healthy != self.open).then_some(now + delay);
    }

    /// Whether the session opened (`Some(true)`) or was given up (`Some(false)`) by now.
    pub(crate) fn take_change(&mut self, now: Timestamp) -> Option<bool> {
        if self.change_at.is_none_or(|at| now < at) {
            return None;
        }
        self.change_at = None;
        self.open = !self.open;
        Some(self.open)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(milliseconds: u64) -> Timestamp {
        Timestamp::from_nanos(milliseconds * 1_000_000)
    }

    fn open_session() -> Session {
        let mut session = Session::new();
        session.set_process(at(0), Process::Running);
        assert_eq!(session.take_change(at(300)), Some(true));
        session
    }

    #[test]
    fn a_death_is_seen_at_once_and_a_freeze_after_the_lease() {
        let mut session = open_session();
        session.set_process(at(1000), Process::Dead);
        assert_eq!(session.take_change(at(1005)), Some(false));
        let mut session = open_session();
        session.set_process(at(1000), Process::Frozen);
        assert_eq!((session.take_change(at(1990)), session.take_change(at(2000))), (None, Some(false)));
    }

    #[test]
    fn a_short_cut_drops_messages_but_keeps_the_session() {
        let mut session = open_session();
        session.set_cut(at(1000), true);
        assert!(!session.carries() && session.is_open());
        session.set_cut(at(1500), false);
        assert_eq!(session.take_change(at(9000)), None);
        assert!(session.carries());
    }
}
