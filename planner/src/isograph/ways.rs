//! Shortest ways along isolines and across stitching tuples: over ground that is known to be clear.

use super::graph::{Isograph, StationId};
use std::{cmp::Reverse, collections::BinaryHeap};

/// Stations and who can be driven to from them.
pub(super) struct Ways<'a> {
    graph: &'a Isograph,
    /// Per station: stations of other lines.
    across: Vec<Vec<StationId>>,
}

/// Distance in steps of a micrometre: ordered and exact.
type Distance = u64;
const STEPS_PER_M: f64 = 1e6;

impl<'a> Ways<'a> {
    pub(super) fn new(graph: &'a Isograph) -> Self {
        let mut across = vec![Vec::new(); graph.station_count()];
        let stitches = graph.edges.iter().flat_map(|edge| &edge.tuples);
        let connections = stitches.flat_map(|&tuple| graph.connections(tuple));
        for [one, other] in connections.chain(graph.edges.iter().filter_map(|edge| edge.bridge)) {
            across[one as usize].push(other);
            across[other as usize].push(one);
        }
        Self { graph, across }
    }

    /// The shortest way from one of some stations to one that is wanted, both ends included.
    pub(super) fn shortest(
        &self,
        from: impl IntoIterator<Item = StationId>,
        wanted: impl Fn(StationId) -> bool,
    ) -> Option<Vec<StationId>> {
        let count = self.graph.station_count();
        let mut reached = vec![Distance::MAX; count];
        let mut before = vec![StationId::MAX; count];
        let mut open = BinaryHeap::new();
        for station in from {
            reached[station as usize] = 0;
            open.push(Reverse((0, station)));
        }
        while let Some(Reverse((distance, at))) = open.pop() {
            if distance > reached[at as usize] {
                continue;
            }
            if wanted(at) {
                return Some(traced(&before, at));
            }
            for (next, length_m) in self.steps(at) {
                let there = distance + (length_m * STEPS_PER_M) as Distance;
                if there < reached[next as usize] {
                    reached[next as usize] = there;
                    before[next as usize] = at;
                    open.push(Reverse((there, next)));
                }
            }
        }
        None
    }

    fn steps(&self, at: StationId) -> impl Iterator<Item = (StationId, f64)> {
        let graph = self.graph;
        let along = [(graph.before(at), graph.step_m(at)), (graph.after(at), graph.step_m(graph.after(at)))];
        let across = self.across[at as usize].iter();
        along.into_iter().chain(across.map(move |&next| (next, (graph.point(next) - graph.point(at)).norm())))
    }
}

fn traced(before: &[StationId], end: StationId) -> Vec<StationId> {
    let mut way = vec![end];
    while let Some(&at) = before.get(way[way.len() - 1] as usize).filter(|&&at| at != StationId::MAX) {
        way.push(at);
    }
    way.reverse();
    way
}
