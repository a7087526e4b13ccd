//! The right to drive, and until when: counted from the agent's own request on its own clock.

use protocol::{Timestamp, v1};
use std::time::Duration;

/// The newest grant.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Lease {
    pub(crate) term: u64,
    pub(crate) epoch: u64,
    /// The order it is for: no other may be driven under it.
    order_id: u64,
    request: Timestamp,
    until: Timestamp,
}

impl Lease {
    /// Takes in a grant; false when it is not to be obeyed: from an older coordinator or epoch, or an answer to
    /// a request that was not made.
    pub(crate) fn take(&mut self, now: Timestamp, grant: &v1::Grant) -> bool {
        let request = Timestamp::from_nanos(grant.request_ns);
        if (grant.term, grant.epoch) < (self.term, self.epoch) || request > now {
            return false;
        }
        let newer_authority = (grant.term, grant.epoch) > (self.term, self.epoch);
        self.term = grant.term;
        self.epoch = grant.epoch;
        if newer_authority || request >= self.request {
            self.order_id = grant.order_id;
            self.request = request;
            self.until = request + Duration::from_millis(u64::from(grant.lease_ms));
        }
        true
    }

    /// Time left to drive an order; zero when it has run out, or is for another order (what was granted under
    /// the old one has been taken away).
    pub(crate) fn left(&self, now: Timestamp, order_id: u64) -> Duration {
        if order_id == self.order_id { self.until.since(now) } else { Duration::ZERO }
    }

    /// Whether the robot may drive an order.
    pub(crate) fn is_valid(&self, now: Timestamp, order_id: u64) -> bool {
        !self.left(now, order_id).is_zero()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grant(epoch: u64, request_s: f64, lease_ms: u32) -> v1::Grant {
        let request_ns = Timestamp::from_secs_f64(request_s).as_nanos();
        v1::Grant { term: 1, epoch, request_ns, lease_ms, ..v1::Grant::default() }
    }

    fn at(seconds: f64) -> Timestamp {
        Timestamp::from_secs_f64(seconds)
    }

    #[test]
    fn a_lease_counts_from_the_request_and_not_from_its_receipt() {
        let mut lease = Lease::default();
        assert!(lease.take(at(12.0), &grant(1, 10.0, 3000)));
        assert!(lease.is_valid(at(12.9), 0));
        assert!(!lease.is_valid(at(13.0), 0));
    }

    #[test]
    fn a_grant_read_late_gives_nothing() {
        let mut lease = Lease::default();
        lease.take(at(60.0), &grant(1, 10.0, 3000));
        assert!(!lease.is_valid(at(60.0), 0));
    }

    #[test]
    fn older_epochs_and_answers_from_the_future_are_refused() {
        let mut lease = Lease::default();
        lease.take(at(10.0), &grant(5, 10.0, 3000));
        assert!(!lease.take(at(11.0), &grant(4, 11.0, 3000)));
        assert!(!lease.take(at(11.0), &grant(5, 99.0, 3000)));
        assert!(!lease.is_valid(at(13.5), 0));
    }

    #[test]
    fn a_lease_for_another_order_gives_no_right_to_drive_this_one() {
        let mut lease = Lease::default();
        lease.take(at(10.0), &v1::Grant { order_id: 7, ..grant(2, 10.0, 3000) });
        assert!(lease.is_valid(at(10.5), 7));
        assert!(!lease.is_valid(at(10.5), 6));
    }

    #[test]
    fn an_older_answer_does_not_shorten_the_lease() {
        let mut lease = Lease::default();
        lease.take(at(10.2), &grant(1, 10.1, 3000));
        lease.take(at(10.2), &grant(1, 10.0, 3000));
        assert!(lease.is_valid(at(13.05), 0));
        lease.take(at(10.4), &grant(1, 10.3, 0));
        assert!(!lease.is_valid(at(10.5), 0), "0 ms means stop");
    }
}
