//! Which stitching tuple to take where there are several.

use super::{
    graph::{Isograph, StationId, Tuple},
    weave::Weave,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How stitching tuples are selected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Selector {
    /// Any.
    Random,
    /// The one beside the stitch by which the line was reached: a staircase, as in connected Fermat spirals.
    Cfs,
    /// Minimum curvature stitching: the one after which the path turns least more than before.
    #[default]
    Mcs,
    /// Equation 3 as it is printed, with the largest difference: for comparison alone.
    McsAsPrinted,
}

/// A selector at work.
pub(super) struct Selection {
    selector: Selector,
    rng: ChaCha8Rng,
}

impl Selection {
    pub(super) fn new(selector: Selector, seed: u64) -> Self {
        Self { selector, rng: ChaCha8Rng::seed_from_u64(seed) }
    }

    /// One of the tuples that are still open; `entry` is the station of the parent line at which that was entered.
    pub(super) fn pick(
        &mut self,
        graph: &Isograph,
        weave: &Weave<'_>,
        open: &[Tuple],
        entry: Option<StationId>,
    ) -> Option<Tuple> {
        match self.selector {
            Selector::Random if open.is_empty() => None,
            Selector::Random => Some(open[self.rng.random_range(0..open.len())]),
            Selector::Cfs => {
                open.iter().copied().min_by_key(|tuple| entry.map_or(0, |entry| beyond(graph, entry, *tuple)))
            }
            Selector::Mcs | Selector::McsAsPrinted => {
                let sign = if self.selector == Selector::Mcs { 1.0 } else { -1.0 };
                let priced = open.iter().map(|&tuple| (sign * weave.added_turning_rad(tuple), tuple));
                priced.min_by(|one, other| one.0.total_cmp(&other.0)).map(|(_, tuple)| tuple)
            }
        }
    }
}

/// Stations from the entry to the tail of the tuple's step on the same line: 0 where the steps meet.
fn beyond(graph: &Isograph, entry: StationId, tuple: Tuple) -> StationId {
    let line = graph.stations(graph.line_of(entry));
    let step = tuple.steps.into_iter().find(|step| line.contains(step));
    let count = line.end - line.start;
    step.map_or(count, |step| (graph.before(step) + count - entry) % count)
}
