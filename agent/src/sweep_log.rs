//! What was swept, as a line of numbered corners, kept until the coordinator has it in its ledger.

use protocol::v1;
use std::collections::VecDeque;
use terrain::Point;

/// A new corner is noted after this way, metres; while standing still after much less.
const STEP_M: f64 = 0.03;
const STANDING_STEP_M: f64 = 0.004;
/// Corners kept; beyond that evidence is given up rather than memory.
const KEPT_MAX: usize = 4096;
/// Corners sent in one message.
const SENT_MAX: usize = 64;

/// The line.
#[derive(Debug, Clone, Default)]
pub(crate) struct SweepLog {
    kept: VecDeque<v1::SweepVertex>,
    last: Option<Point>,
    sequence: u64,
    pub(crate) swept_m: f64,
    untrusted: bool,
    tool_was_off: bool,
    deviation_m: f64,
}

impl SweepLog {
    /// Takes in a place confirmed by a fix (or not: `trusted`), and whether the tool was on all the way from the
    /// place before.
    pub(crate) fn take(
        &mut self,
        place: Point,
        tool_active: bool,
        trusted: bool,
        deviation_m: f64,
        standing: bool,
    ) {
        self.untrusted |= !trusted;
        self.tool_was_off |= !tool_active;
        self.deviation_m = self.deviation_m.max(deviation_m);
        let Some(from) = self.last else {
            self.tool_was_off = true;
            self.note(place);
            return;
        };
        let moved_m = (place - from).norm();
        if moved_m >= if standing { STANDING_STEP_M } else { STEP_M } {
            if !self.tool_was_off {
                self.swept_m += moved_m;
            }
            self.note(place);
        }
    }

    fn note(&mut self, place: Point) {
        self.sequence += 1;
        self.last = Some(place);
        if self.kept.len() < KEPT_MAX {
            self.kept.push_back(v1::SweepVertex {
                sequence: self.sequence,
                x_m: place.x,
                y_m: place.y,
                tool_active: !self.tool_was_off,
                trusted: !self.untrusted,
                deviation_m: self.deviation_m,
            });
        }
        self.untrusted = false;
        self.tool_was_off = false;
        self.deviation_m = 0.0;
    }

    /// The coordinator has everything up to this number.
    pub(crate) fn acknowledge(&mut self, sequence: u64) {
        while self.kept.front().is_some_and(|vertex| vertex.sequence <= sequence) {
            self.kept.pop_front();
        }
    }

    /// What goes into the next message: the oldest first.
    pub(crate) fn to_send(&self) -> Vec<v1::SweepVertex> {
        self.kept.iter().take(SENT_MAX).copied().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_are_kept_until_acknowledged() {
        let mut log = SweepLog::default();
        for step in 0..10 {
            log.take(Point::new(0.05 * f64::from(step), 0.0), true, true, 0.01, false);
        }
        assert_eq!(log.to_send().len(), 10);
        log.acknowledge(7);
        let left: Vec<u64> = log.to_send().iter().map(|vertex| vertex.sequence).collect();
        assert_eq!(left, [8, 9, 10]);
        assert!((log.swept_m - 0.45).abs() < 1e-9);
    }

    #[test]
    fn a_doubtful_fix_taints_the_segment_it_lies_in_and_no_other() {
        let mut log = SweepLog::default();
        log.take(Point::new(0.0, 0.0), true, true, 0.01, false);
        log.take(Point::new(0.01, 0.0), true, false, 0.01, false);
        log.take(Point::new(0.05, 0.0), true, true, 0.01, false);
        log.take(Point::new(0.10, 0.0), true, true, 0.01, false);
        let trusted: Vec<bool> = log.to_send().iter().map(|vertex| vertex.trusted).collect();
        assert_eq!(trusted, [true, false, true]);
    }

    #[test]
    fn standing_still_notes_the_last_centimetres() {
        let mut log = SweepLog::default();
        log.take(Point::new(0.0, 0.0), true, true, 0.01, false);
        log.take(Point::new(0.02, 0.0), true, true, 0.01, false);
        assert_eq!(log.to_send().len(), 1);
        log.take(Point::new(0.02, 0.0), true, true, 0.01, true);
        assert_eq!(log.to_send().len(), 2);
    }

    #[test]
    fn a_stretch_with_the_tool_off_is_not_swept() {
        let mut log = SweepLog::default();
        for (x, tool) in [(0.0, true), (0.01, false), (0.05, true), (0.10, true)] {
            log.take(Point::new(x, 0.0), tool, true, 0.01, false);
        }
        let active: Vec<bool> = log.to_send().iter().map(|vertex| vertex.tool_active).collect();
        assert_eq!(active, [false, false, true]);
    }

    #[test]
    fn memory_is_bounded() {
        let mut log = SweepLog::default();
        for step in 0..10_000 {
            log.take(Point::new(0.05 * f64::from(step), 0.0), true, true, 0.01, false);
        }
        assert_eq!(log.kept.len(), KEPT_MAX);
    }
}
