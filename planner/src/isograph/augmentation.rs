//! Isograph augmentation: edges between lines that are several layers apart.
//!
//! Stitching tuples follow each other across the layers, p1 to p2, p2 to p3, …; p1 and p3 can be stitched directly, over
//! the line between. A tree that goes this way need not cover the line it passes.

use super::{
    graph::{Isograph, StationId, Tuple},
    walls::Walls,
};

/// Adds edges over 2 … `hops_max` layers (equation 6). Such an edge costs what its two connections add: twice the
/// layers in between, in tool widths; the paper charges the layers.
pub(super) fn augment(graph: &mut Isograph, walls: &Walls, hops_max: u32) {
    let above = stations_above(graph);
    for first in 0..graph.station_count() as StationId {
        let Some(mut last) = above[first as usize] else { continue };
        for hops in 2..=hops_max {
            let Some(next) = above[last as usize] else { break };
            last = next;
            let tuple = Tuple { steps: [first, last], faces: false };
            if graph.is_sound(tuple, walls, hops) {
                let weight_m = 2.0 * f64::from(hops - 1) * graph.tool_m;
                graph.add(tuple.sorted(graph), hops, weight_m);
            }
        }
    }
}

/// Per station, its partner on the layer above: no station has two.
fn stations_above(graph: &Isograph) -> Vec<Option<StationId>> {
    let mut above = vec![None; graph.station_count()];
    for tuple in graph.edges.iter().flat_map(|edge| &edge.tuples).filter(|tuple| !tuple.faces) {
        let [p, q] = tuple.steps;
        let layer = |station| graph.lines[graph.line_of(station) as usize].layer;
        let (low, high) = if layer(p) < layer(q) { (p, q) } else { (q, p) };
        above[low as usize] = Some(high);
    }
    above
}
