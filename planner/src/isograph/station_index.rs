//! Stations by place, and which of them are each other's nearest: the connecting sets of the isograph.

use super::graph::{Isograph, LineId, REACH, StationId, Tuple};
use rstar::{RTree, primitives::GeomWithData};

/// Stations by place; and of each, the nearest on the layer below, on the layer above, and on another line of its own.
pub(super) struct StationIndex {
    tree: RTree<Entry>,
    nearest: Vec<[Option<StationId>; 3]>,
}

type Entry = GeomWithData<[f64; 2], StationId>;

/// Stations farther apart than this many tool widths are not joined by a bridge.
const BRIDGE_REACH: f64 = 12.0;

const BELOW: usize = 0;
const ABOVE: usize = 1;
const BESIDE: usize = 2;

impl StationIndex {
    pub(super) fn new(graph: &Isograph) -> Self {
        let all = 0..graph.station_count() as StationId;
        let entries = all.clone().map(|station| GeomWithData::new(graph.point(station).into(), station));
        let tree = RTree::bulk_load(entries.collect());
        let nearest = all.map(|station| nearest(graph, &tree, station)).collect();
        Self { tree, nearest }
    }

    /// Pairs of stations on adjacent layers that are nearest to each other (equation 2). `O(u → v)` of equation 1 is
    /// read as: no other line of v's layer is nearer.
    pub(super) fn stitches(&self, graph: &Isograph) -> Vec<Tuple> {
        let mutual = |p: StationId| {
            let q = self.nearest[p as usize][ABOVE]?;
            (self.nearest[q as usize][BELOW] == Some(p)).then_some([p, q])
        };
        let pairs = (0..graph.station_count() as StationId).filter_map(mutual);
        pairs.map(|steps| Tuple { steps, faces: false }.sorted(graph)).collect()
    }

    /// Pairs on two lines of one layer that are nearest to each other. The other line runs the opposite way: the step
    /// away from q lies beside the step to p.
    pub(super) fn facing(&self, graph: &Isograph) -> Vec<Tuple> {
        let mutual = |p: StationId| {
            let q = self.nearest[p as usize][BESIDE]?;
            (p < q && self.nearest[q as usize][BESIDE] == Some(p)).then_some([p, graph.after(q)])
        };
        let pairs = (0..graph.station_count() as StationId).filter_map(mutual);
        pairs.map(|steps| Tuple { steps, faces: true }.sorted(graph)).collect()
    }

    /// Pairs of stations in different pieces of the graph, the nearest pairs first.
    pub(super) fn bridges(&self, graph: &Isograph, pieces: &[LineId]) -> Vec<[StationId; 2]> {
        let piece = |station: StationId| pieces[graph.line_of(station) as usize];
        let reach2 = (BRIDGE_REACH * graph.tool_m).powi(2);
        let mut found: Vec<(f64, [StationId; 2])> = Vec::new();
        for from in 0..graph.station_count() as StationId {
            let place = graph.point(from);
            let near = self.tree.locate_within_distance(place.into(), reach2);
            let others = near.map(|entry| entry.data).filter(|&to| from < to && piece(from) != piece(to));
            found.extend(others.map(|to| ((graph.point(to) - place).norm(), [from, to])));
        }
        found.sort_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
        found.into_iter().map(|(_, ends)| ends).collect()
    }
}

fn nearest(graph: &Isograph, tree: &RTree<Entry>, station: StationId) -> [Option<StationId>; 3] {
    let own = graph.line_of(station);
    let layer = graph.lines[own as usize].layer;
    let reach2 = (REACH * graph.tool_m).powi(2);
    let mut found = [(f64::INFINITY, StationId::MAX); 3];
    for other in tree.locate_within_distance(graph.point(station).into(), reach2) {
        let line = graph.line_of(other.data);
        let side = match graph.lines[line as usize].layer {
            other if other + 1 == layer => BELOW,
            other if other == layer + 1 => ABOVE,
            other if other == layer && line != own => BESIDE,
            _ => continue,
        };
        let distance2 = (graph.point(other.data) - graph.point(station)).norm_squared();
        // Equal distances: the lower number, whatever the order of the tree.
        if (distance2, other.data) < found[side] {
            found[side] = (distance2, other.data);
        }
    }
    found.map(|(distance2, station)| distance2.is_finite().then_some(station))
}
