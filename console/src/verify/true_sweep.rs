//! What the tools truly swept: a disc carried along the true poses, tool on.

use crate::verify::truth::Step;
use terrain::{Segment, SweptRaster};

/// Sweeps along one step of a body. A step counts as a line only when the tool was on at both of its ends;
/// where it was on at the second end alone, the place counts.
pub(crate) fn sweep_step(raster: &mut SweptRaster, step: &Step<'_>, tool_radius_m: f64) {
    if !step.now.tool_active || !step.now.on_floor {
        return;
    }
    let here = step.to;
    let from = match step.before {
        Some(before) if before.tool_active && before.on_floor => step.from,
        _ => here,
    };
    raster.sweep(Segment::new(from, here), tool_radius_m, |_| {});
}
