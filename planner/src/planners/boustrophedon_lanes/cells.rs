//! The last resort for the coverage that was asked for: the centres of cells from which something that lanes leave out can be
//! swept.

use crate::{configuration_space::ConfigurationSpace, lane_tour::Lane};
use terrain::{Cell, Segment, SweptRaster, samples_swept_from};

/// Places to visit so that, with some lanes, all samples are swept that cells to visit require.
pub(super) fn left_out(space: &ConfigurationSpace<'_>, lanes: &[Lane]) -> Vec<Lane> {
    let (instance, floor) = (space.instance(), space.instance().floor);
    let (lattice, radius_m) = (*floor.lattice(), floor.tool_width_m() / 2.0);
    let mut raster = SweptRaster::new(lattice);
    for lane in lanes {
        raster.sweep(Segment::new(lane.from, lane.to), radius_m, |_| {});
    }
    let reach = (radius_m / lattice.cell_m + 0.5).ceil() as i32;
    let mut added = Vec::new();
    for (index, cell) in lattice.cells().enumerate().filter(|&(index, _)| instance.visit[index]) {
        loop {
            let left = floor.required(index) & !raster.samples(index);
            let around = (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy)));
            let gain = |stand: Cell| {
                (left & samples_swept_from(&lattice, cell, lattice.center(stand), radius_m)).count_ones()
            };
            let best = around
                .map(|(dx, dy)| Cell::new(cell.x + dx, cell.y + dy))
                .filter(|&stand| left != 0 && floor.cell_is_drivable(stand))
                .filter(|&stand| space.place_in_middle(stand).is_some_and(|place| space.is_reached(place)))
                .max_by_key(|&stand| gain(stand));
            let Some(stand) = best.filter(|&stand| gain(stand) > 0) else { break };
            let center = lattice.center(stand);
            raster.sweep(Segment::new(center, center), radius_m, |_| {});
            added.push(Lane { from: center, to: center });
        }
    }
    added
}
