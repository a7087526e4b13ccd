//! What the robots said they swept, each corner of the line once (rule R4: evidence, not plan).

use protocol::v1;
use std::collections::BTreeMap;
use terrain::{Point, Segment, SweptRaster};

/// The last corner taken from each start of each robot.
#[derive(Debug, Default)]
pub(crate) struct ReportedSweep {
    last: BTreeMap<String, BTreeMap<u64, v1::SweepVertex>>,
}

impl ReportedSweep {
    /// Sweeps along the corners that are new in a state, with the tool made smaller by the pose's error.
    pub(crate) fn take(&mut self, raster: &mut SweptRaster, state: &v1::State, tool_radius_m: f64) {
        let Some(header) = &state.header else { return };
        if !self.last.contains_key(&header.serial_number) {
            self.last.insert(header.serial_number.clone(), BTreeMap::new());
        }
        let Some(boots) = self.last.get_mut(&header.serial_number) else { return };
        for vertex in &state.sweep {
            let before = boots.get(&header.boot_id);
            if before.is_some_and(|before| vertex.sequence <= before.sequence) || !is_finite(vertex) {
                continue;
            }
            if let Some(before) = before.filter(|before| vertex.sequence == before.sequence + 1) {
                sweep_to(raster, before, vertex, tool_radius_m);
            }
            boots.insert(header.boot_id, *vertex);
        }
    }
}

fn sweep_to(raster: &mut SweptRaster, from: &v1::SweepVertex, to: &v1::SweepVertex, tool_radius_m: f64) {
    if to.tool_active && to.trusted {
        let way = Segment::new(Point::new(from.x_m, from.y_m), Point::new(to.x_m, to.y_m));
        raster.sweep(way, tool_radius_m - to.deviation_m, |_| {});
    }
}

fn is_finite(vertex: &v1::SweepVertex) -> bool {
    vertex.x_m.is_finite() && vertex.y_m.is_finite() && vertex.deviation_m >= 0.0
}
