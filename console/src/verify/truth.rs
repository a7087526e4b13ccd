//! The true motion of the bodies, step by step.

use protocol::v1;
use std::collections::BTreeMap;
use terrain::{Point, Segment};

/// Truth that is further apart proves nothing about what lies between.
pub(crate) const STEP_S_MAX: f64 = 0.5;

/// What one body did between two truths; without a `before`, it is only known where it is.
#[derive(Debug)]
pub(crate) struct Step<'a> {
    pub(crate) robot: &'a str,
    pub(crate) before: Option<&'a v1::BodyTruth>,
    pub(crate) now: &'a v1::BodyTruth,
    pub(crate) from: Point,
    pub(crate) to: Point,
    pub(crate) seconds: f64,
}

impl Step<'_> {
    pub(crate) fn segment(&self) -> Segment {
        Segment::new(self.from, self.to)
    }
}

/// The truth before the present one.
#[derive(Debug, Default)]
pub(crate) struct TruthBefore {
    pub(crate) truth: v1::GroundTruth,
    pub(crate) samples: u64,
    pub(crate) lost: u64,
    pub(crate) unseen_s: f64,
}

impl TruthBefore {
    /// Whether a truth is newer than the one before, and if so, whether it is near enough to be joined to it.
    pub(crate) fn admit(&mut self, truth: &v1::GroundTruth) -> Option<bool> {
        if self.samples == 0 {
            self.samples = 1;
            return Some(false);
        }
        if truth.sequence <= self.truth.sequence || truth.timestamp_ns < self.truth.timestamp_ns {
            return None;
        }
        self.samples += 1;
        self.lost += truth.sequence - self.truth.sequence - 1;
        let step_s = (truth.timestamp_ns - self.truth.timestamp_ns) as f64 / 1e9;
        let joined = step_s <= STEP_S_MAX;
        if !joined {
            self.unseen_s += step_s;
        }
        Some(joined)
    }

    /// The steps of all bodies whose place is known. A body that was moved further than its drive can carry it
    /// was lifted: its way is not a line on the floor.
    pub(crate) fn steps<'a>(
        &'a self,
        truth: &'a v1::GroundTruth,
        joined: bool,
        speed_max_m_per_s: &BTreeMap<String, f64>,
    ) -> Vec<Step<'a>> {
        let step_s = truth.timestamp_ns.saturating_sub(self.truth.timestamp_ns) as f64 / 1e9;
        let step_of = |now: &'a v1::BodyTruth| {
            let to = place(now)?;
            let speed = speed_max_m_per_s.get(&now.serial_number).copied().unwrap_or(SPEED_DEFAULT_M_PER_S);
            let reach_m = 1.5 * speed * step_s + 0.05;
            let before = self.truth.bodies.iter().find(|body| body.serial_number == now.serial_number);
            let known = before.filter(|_| joined).and_then(|before| Some((before, place(before)?)));
            let carried = known.filter(|(_, from)| (to - from).norm() <= reach_m);
            let from = carried.map_or(to, |(_, from)| from);
            Some(Step {
                robot: now.serial_number.as_str(),
                before: carried.map(|(before, _)| before),
                now,
                from,
                to,
                seconds: step_s,
            })
        };
        truth.bodies.iter().filter_map(step_of).collect()
    }
}

/// For bodies whose factsheet was not recorded.
const SPEED_DEFAULT_M_PER_S: f64 = 3.0;

fn place(body: &v1::BodyTruth) -> Option<Point> {
    let pose = body.pose?;
    (pose.x_m.is_finite() && pose.y_m.is_finite()).then(|| Point::new(pose.x_m, pose.y_m))
}
