//! What closed lines leave of a floor: passages narrower than the tool, corners, rims. It gets lanes, and these are
//! dealt out among the robots so that the last one ends soon.

use super::boustrophedon_lanes;
use crate::{Instance, Plan, PlanError, PlanOptions, Route, repair_lines};
use terrain::{Point, Segment, SweptRaster};

/// Of what a plan may leave, this share is used.
const LEFT_SHARE: f64 = 0.8;

/// The routes, with lanes for what they leave where that is more than may be left. Nobody gets a lane that is out of
/// reach: side trips are for such places.
pub(super) fn with_rest(
    instance: &Instance<'_>,
    options: &PlanOptions,
    routes: Vec<Route>,
) -> Result<Plan, PlanError> {
    let incumbent_lines: Vec<Vec<Point>> = routes.iter().map(|route| route.points.clone()).collect();
    let orphan_lines = lanes_for_the_rest(instance, options, &incumbent_lines)?;
    if orphan_lines.is_empty() {
        return Ok(Plan { routes });
    }
    let dealt = repair_lines::repair(&Instance { incumbent_lines, orphan_lines, ..instance.clone() });
    Ok(dealt.unwrap_or(Plan { routes }))
}

/// Lanes over what lines leave of the samples that are to be swept; none where that is little enough.
fn lanes_for_the_rest(
    instance: &Instance<'_>,
    options: &PlanOptions,
    lines: &[Vec<Point>],
) -> Result<Vec<Vec<Point>>, PlanError> {
    let lattice = *instance.floor.lattice();
    let mut raster = SweptRaster::new(lattice);
    for pair in lines.iter().flat_map(|line| line.windows(2)) {
        raster.sweep(Segment::new(pair[0], pair[1]), instance.floor.tool_width_m() / 2.0, |_| {});
    }
    let swept = (0..lattice.len()).map(|index| raster.samples(index)).collect();
    let mut rest = Instance { swept, ..instance.clone() };
    let may_stay = LEFT_SHARE * (1.0 - instance.coverage_min) * samples_left(instance);
    let left = samples_left(&rest);
    if left <= may_stay {
        return Ok(Vec::new());
    }
    rest.coverage_min = 1.0 - may_stay / left;
    rest.visit = (0..lattice.len()).map(|index| rest.visit[index] && rest.wanted(index) != 0).collect();
    let plan = boustrophedon_lanes::plan(&rest, options)?;
    Ok(plan.routes.into_iter().map(|route| route.points).filter(|line| line.len() > 1).collect())
}

fn samples_left(instance: &Instance<'_>) -> f64 {
    let cells = (0..instance.visit.len()).filter(|&index| instance.visit[index]);
    cells.map(|index| f64::from(instance.wanted(index).count_ones())).sum()
}
