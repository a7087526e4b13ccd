//! What the tools truly swept: a disc carried along the true poses, tool on.

use crate::verify::truth::Step;
use terrain::{Point, Segment, SweptRaster};

/// A tool that was switched off within a step this short was on for nearly all of it.
const SWITCH_S_MAX: f64 = 0.05;

/// Sweeps along one step of a body.
pub(crate) fn sweep_step(raster: &mut SweptRaster, step: &Step<'_>, tool_radius_m: f64) {
    if let Some(from) = swept_from(step) {
        raster.sweep(Segment::new(from, step.to), tool_radius_m, |_| {});
    }
}

/// Where the sweep of a step began: where the tool was on all along, the whole step counts; where it was switched on
/// on the way, the end alone.
fn swept_from(step: &Step<'_>) -> Option<Point> {
    let was_on = step.before.is_some_and(|before| before.tool_active && before.on_floor);
    let is_on = step.now.tool_active && step.now.on_floor;
    match (was_on, is_on) {
        (true, true) => Some(step.from),
        (true, false) if step.now.on_floor && step.seconds <= SWITCH_S_MAX => Some(step.from),
        (false, true) => Some(step.to),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::v1::BodyTruth;

    fn swept(was_on: Option<bool>, is_on: bool, seconds: f64) -> Option<f64> {
        let body = |tool_active| BodyTruth { tool_active, on_floor: true, ..Default::default() };
        let (before, now) = (was_on.map(body), body(is_on));
        let step = Step {
            robot: "r1",
            before: before.as_ref(),
            now: &now,
            from: Point::new(1.0, 0.0),
            to: Point::new(2.0, 0.0),
            seconds,
        };
        swept_from(&step).map(|from| from.x)
    }

    #[test]
    fn a_step_counts_where_the_tool_was_on_and_no_further() {
        assert_eq!(swept(Some(true), true, 0.1), Some(1.0));
        assert_eq!(swept(Some(false), true, 0.1), Some(2.0));
        assert_eq!(swept(None, true, 0.1), Some(2.0));
        assert_eq!(swept(Some(true), false, 0.1), None);
        assert_eq!(swept(Some(true), false, 0.02), Some(1.0));
        assert_eq!(swept(Some(false), false, 0.02), None);
    }
}
