//! What is worth doing first: by what it gains for its time.

use std::cmp::Ordering;

/// A number, and samples per second that what it stands for gains.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ranked {
    pub(super) per_s: f64,
    pub(super) number: usize,
}

impl PartialEq for Ranked {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Ranked {}

impl PartialOrd for Ranked {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Of two that gain the same, the one with the smaller number comes first.
impl Ord for Ranked {
    fn cmp(&self, other: &Self) -> Ordering {
        self.per_s.total_cmp(&other.per_s).then(other.number.cmp(&self.number))
    }
}
