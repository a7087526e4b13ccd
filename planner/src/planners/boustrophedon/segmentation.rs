//! From what a robot reaches to the cells that are swept.

use super::{
    cell_path::Widths,
    directions::{candidates, main_direction, pieces, turn},
    fragments::Fragments,
    line_sweep::Least,
    merging::merged,
    msa::{Altitudes, Region, Sweep, exact, parts},
    raster::{Frame, NONE, Raster},
};
use crate::configuration_space::ConfigurationSpace;
use std::f64::consts::FRAC_PI_2;
use terrain::{Cell, Point, Vector};

/// Fragments that are solved exactly at once: the paper's K.
const EXACT: usize = 10;
/// Hull edges shorter than so many tool widths give no direction.
const EDGE: f64 = 3.0;
/// Directions that are looked for, and those that cells may have beside the main ones.
const DIRECTIONS: usize = 5;
const MORE: usize = 2;
/// Directions nearer than this to the main ones are none of their own.
const SLANTED_RAD: f64 = 5.0 * std::f64::consts::PI / 180.0;
/// Pockets thinner than this share of the tool's width are no cells.
const THIN: f64 = 0.35;
/// Least area of a cell, as a share of a square as wide as the tool.
const LEAST_AREA: f64 = 1.0;

/// Which cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in super::super) enum Segmentation {
    /// Boustrophedon cells of lanes along x.
    Horizontal,
    /// Boustrophedon cells of lanes along y.
    Vertical,
    /// Minimum sum of altitudes: each cell with a direction of its own.
    MinimumSumOfAltitudes,
}

/// The cells of the ground that is to be swept.
pub(super) fn segment(
    space: &ConfigurationSpace<'_>,
    widths: Widths,
    segmentation: Segmentation,
) -> (Fragments, Vec<Region>) {
    let ground = ground(space);
    let (tool_m, tool) = (space.instance().floor.tool_width_m(), widths.tool);
    let least = Least { area: (LEAST_AREA * tool * tool) as u32, rows: (THIN * tool) as u32 + 1 };
    let found = candidates(&ground, EDGE * tool_m, DIRECTIONS);
    let main = main_direction(&ground, &found);
    let cut = Cut { ground: &ground, least, widths };
    match segmentation {
        Segmentation::Horizontal => cut.one_way(nearest_main(main, 0.0)),
        Segmentation::Vertical => cut.one_way(nearest_main(main, FRAC_PI_2)),
        Segmentation::MinimumSumOfAltitudes => {
            let square = main + FRAC_PI_2;
            let slanted = |&angle: &f64| turn(main, angle).abs().min(turn(square, angle).abs()) > SLANTED_RAD;
            let others: Vec<f64> = found.into_iter().filter(slanted).take(MORE).collect();
            cut.with_least_altitude(main, &others)
        }
    }
}

/// Of the main direction and the one square to it, the one nearer to `towards`.
fn nearest_main(main: f64, towards: f64) -> f64 {
    let square = main + FRAC_PI_2;
    if turn(main, towards).abs() <= turn(square, towards).abs() { main } else { square }
}

/// How ground is cut.
#[derive(Clone, Copy)]
struct Cut<'a> {
    ground: &'a Raster,
    least: Least,
    widths: Widths,
}

impl Cut<'_> {
    /// The cells of one sweep, as they are.
    fn one_way(self, angle: f64) -> (Fragments, Vec<Region>) {
        let fragments = Fragments::of_one_sweep(&self.ground.turned(angle), &[angle], self.least);
        let altitudes = self.altitudes(&fragments);
        let alone = |fragment| Region { members: vec![fragment], sweep: altitudes.alone(fragment) };
        let regions = (0..fragments.len() as u32).map(alone).collect();
        (fragments, regions)
    }

    /// The least sum of altitudes from the fragments of two sweeps, or of either one alone: with larger fragments,
    /// more ground is solved exactly at once.
    fn with_least_altitude(self, main: f64, others: &[f64]) -> (Fragments, Vec<Region>) {
        let square = main + FRAC_PI_2;
        let angles = |first: f64, second: f64| [&[first, second], others].concat();
        let along = (self.ground.turned(main), angles(main, square));
        let across = (self.ground.turned(square), angles(square, main));
        let cuts = [
            Fragments::of_one_sweep(&along.0, &along.1, self.least),
            Fragments::of_one_sweep(&across.0, &across.1, self.least),
            Fragments::of_two_sweeps(&along.0, &along.1, self.least),
        ];
        let solved = cuts.into_iter().map(|fragments| {
            let regions = minimum_sum(&self.altitudes(&fragments));
            (regions.iter().map(|region| region.sweep.altitude).sum::<f64>(), fragments, regions)
        });
        let best = solved.min_by(|a, b| a.0.total_cmp(&b.0)).expect("there are three");
        (best.1, best.2)
    }

    fn altitudes<'f>(&self, fragments: &'f Fragments) -> Altitudes<'f> {
        Altitudes { fragments, tolerance: self.widths.tolerance(), tool: self.widths.tool }
    }
}

/// Exact in parts, then merged.
fn minimum_sum(altitudes: &Altitudes<'_>) -> Vec<Region> {
    let adjacency = &altitudes.fragments.adjacency;
    let mut cost = |members: &[u32]| -> Option<Sweep> {
        match members {
            &[alone] => Some(altitudes.alone(alone)),
            _ => altitudes.least(members),
        }
    };
    let parts = parts(adjacency, EXACT);
    let regions = parts.iter().flat_map(|part| exact(adjacency, part, &mut cost)).collect();
    merged(adjacency, regions, &mut cost)
}

/// The places to be swept, labelled 0: those that robots reach in cells to visit, and beside them.
fn ground(space: &ConfigurationSpace<'_>) -> Raster {
    let places = space.places();
    let wanted = wanted_cells(space);
    let size = Vector::new(f64::from(places.columns), f64::from(places.rows)) * places.cell_m;
    let frame = Frame::around(places.origin, Point::from(places.origin.coords + size), places.cell_m, 0.0);
    let mut ground = Raster::new(frame, |point| {
        let place = places.cell_at(point).and_then(|cell| places.index(cell));
        let wanted = place.is_some_and(|place| space.is_reached(place) && wanted[space.cell_index(place)]);
        if wanted { 0 } else { NONE }
    });
    let floor = space.instance().floor;
    let speck_m = 2.0 * floor.body_radius_m() + 0.5 * floor.tool_width_m();
    fill_specks(&mut ground, (speck_m / places.cell_m) as usize);
    ground
}

/// Row-major: cells to visit, and the ground beside them on which no body can stand in the middle of a cell.
fn wanted_cells(space: &ConfigurationSpace<'_>) -> Vec<bool> {
    let instance = space.instance();
    let lattice = instance.floor.lattice();
    let mut wanted = instance.visit.clone();
    for (index, _) in instance.visit.iter().enumerate().filter(|&(_, &visit)| visit) {
        let cell = lattice.cell(index);
        let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
        for beside in around.filter_map(|(dx, dy)| lattice.index(Cell::new(cell.x + dx, cell.y + dy))) {
            wanted[beside] |= !instance.floor.is_drivable(beside);
        }
    }
    wanted
}

/// Takes obstacles out that are at most `most` squares wide and high: they cut lanes, but make no cells.
fn fill_specks(ground: &mut Raster, most: usize) {
    let (piece, count) = pieces(ground);
    let columns = ground.columns();
    let mut boxes = vec![(usize::MAX, 0, usize::MAX, 0); count];
    for (square, &piece) in piece.iter().enumerate() {
        let (column, row) = (square % columns, square / columns);
        let (left, right, low, high) = &mut boxes[piece as usize];
        (*left, *right) = ((*left).min(column), (*right).max(column));
        (*low, *high) = ((*low).min(row), (*high).max(row));
    }
    let (last_column, last_row) = (columns - 1, ground.rows() - 1);
    let is_speck: Vec<bool> = boxes
        .into_iter()
        .map(|(left, right, low, high)| {
            let inside = left > 0 && low > 0 && right < last_column && high < last_row;
            inside && right - left < most && high - low < most
        })
        .collect();
    for (label, &piece) in ground.labels_mut().iter_mut().zip(&piece) {
        if *label == NONE && is_speck[piece as usize] {
            *label = 0;
        }
    }
}
