//! What the tool's disc has swept: 8 × 8 samples in each cell of the lattice, one bit each.
//!
//! A sample counts as swept when its point lies within the tool's radius of the line driven. Area arithmetic
//! is counting bits: one sample stands for 1/64 of a cell.

use crate::{Cell, Lattice, Point, Segment};
use std::ops::RangeInclusive;

/// Samples in a cell: 8 × 8, one bit of a `u64` each, row by row from the lower left.
pub const SAMPLES_PER_CELL: u32 = 64;
const SIDE: u32 = 8;
/// Ends of runs of samples are looked for so much farther away than the radius, metres.
const ROUNDING_M: f64 = 1e-7;

/// The swept samples of every cell of a lattice.
#[derive(Debug, Clone, PartialEq)]
pub struct SweptRaster {
    lattice: Lattice,
    swept: Vec<u64>,
}

impl SweptRaster {
    /// A raster with nothing swept.
    pub fn new(lattice: Lattice) -> Self {
        Self { swept: vec![0; lattice.len()], lattice }
    }

    /// The lattice it lies on.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// The swept samples of the cell with this row-major number.
    pub fn samples(&self, index: usize) -> u64 {
        self.swept[index]
    }

    /// Sweeps a disc of `radius_m` along a segment and calls `changed(index)` for each cell that gained samples.
    /// A radius of 0 or less sweeps nothing.
    pub fn sweep(&mut self, segment: Segment, radius_m: f64, mut changed: impl FnMut(usize)) {
        for_each_swept(&self.lattice, segment, radius_m, |index, samples| {
            if samples & !self.swept[index] != 0 {
                self.swept[index] |= samples;
                changed(index);
            }
        });
    }

    /// Marks samples of a cell as swept.
    pub fn mark(&mut self, index: usize, samples: u64) {
        self.swept[index] |= samples;
    }

    /// Marks samples of a cell as not swept.
    pub fn unmark(&mut self, index: usize, samples: u64) {
        self.swept[index] &= !samples;
    }

    /// Area of `samples` samples, square metres.
    pub fn area_m2(lattice: &Lattice, samples: u64) -> f64 {
        samples as f64 * lattice.cell_m * lattice.cell_m / f64::from(SAMPLES_PER_CELL)
    }
}

/// The samples of a cell that a disc of `radius_m` metres sweeps when it stands at `center`.
pub fn samples_swept_from(lattice: &Lattice, cell: Cell, center: Point, radius_m: f64) -> u64 {
    samples_within(lattice, cell, Segment::new(center, center), radius_m)
}

/// Calls `act(index, samples)` for each cell of which a disc of `radius_m` metres sweeps samples along a segment, row by row;
/// `index` is the cell's row-major number. A radius of 0 or less sweeps nothing.
pub fn for_each_swept(lattice: &Lattice, segment: Segment, radius_m: f64, mut act: impl FnMut(usize, u64)) {
    if radius_m.is_nan() || radius_m <= 0.0 {
        return;
    }
    let low = Point::from(segment.from.coords.inf(&segment.to.coords).add_scalar(-radius_m));
    let high = Point::from(segment.from.coords.sup(&segment.to.coords).add_scalar(radius_m));
    let [columns, rows] = lattice.ranges_in_box(low, high);
    if columns.is_empty() {
        return;
    }
    for y in rows {
        let runs: [Option<Run>; SIDE as usize] =
            std::array::from_fn(|row| Run::within(lattice, segment, radius_m, (y, row as u32), &columns));
        let Some(first) = runs.iter().flatten().map(|run| run.first).min() else { continue };
        let last = runs.iter().flatten().map(|run| run.last).max().unwrap_or(first);
        // From the one to the other all rows are swept.
        let all = runs.iter().all(Option::is_some).then(|| {
            let all = runs.iter().flatten();
            all.fold((first, last), |(from, to), run| (from.max(run.first), to.min(run.last)))
        });
        for x in first / SIDE as i32..=last / SIDE as i32 {
            let is_whole =
                all.is_some_and(|(from, to)| from <= x * SIDE as i32 && (x + 1) * SIDE as i32 - 1 <= to);
            let bits =
                |(row, run): (usize, &Option<Run>)| run.map_or(0, |run| run.bits(x) << (SIDE as usize * row));
            let samples = if is_whole {
                u64::MAX
            } else {
                runs.iter().enumerate().map(bits).fold(0, |all, bits| all | bits)
            };
            if let (Some(index), true) = (lattice.index(Cell::new(x, y)), samples != 0) {
                act(index, samples);
            }
        }
    }
}

/// Samples on end in a row of them, numbered from the left of the lattice.
#[derive(Debug, Clone, Copy)]
struct Run {
    first: i32,
    last: i32,
}

impl Run {
    /// The samples within `radius_m` of a segment in a row of samples of a row of cells.
    fn within(
        lattice: &Lattice,
        segment: Segment,
        radius_m: f64,
        (y, row): (i32, u32),
        columns: &RangeInclusive<i32>,
    ) -> Option<Self> {
        let point = |number: i32| {
            let (x, column) = (number.div_euclid(SIDE as i32), number.rem_euclid(SIDE as i32));
            sample_point(lattice, Cell::new(x, y), row * SIDE + column as u32)
        };
        let (low_m, high_m) = segment.within_at(radius_m + ROUNDING_M, point(0).y)?;
        let number = |x_m: f64| (x_m - lattice.origin.x) / lattice.cell_m * f64::from(SIDE) - 0.5;
        let (least, most) = (columns.start() * SIDE as i32, columns.end() * SIDE as i32 + SIDE as i32 - 1);
        let mut first = number(low_m).ceil().max(f64::from(least)) as i32;
        let mut last = number(high_m).floor().min(f64::from(most)) as i32;
        // The interval is a little too long: what a distance says of its ends holds.
        let is_beyond = |number: i32| segment.distance_to_point(point(number)) > radius_m;
        while first <= last && is_beyond(first) {
            first += 1;
        }
        while first <= last && is_beyond(last) {
            last -= 1;
        }
        (first <= last).then_some(Self { first, last })
    }

    /// Those that lie in the cells of a column.
    fn bits(self, x: i32) -> u64 {
        let first = (self.first - x * SIDE as i32).max(0);
        let last = (self.last - x * SIDE as i32).min(SIDE as i32 - 1);
        if first > last { 0 } else { (2_u64 << last) - (1_u64 << first) }
    }
}

/// The samples of one cell that lie within `radius_m` of a segment.
pub(crate) fn samples_within(lattice: &Lattice, cell: Cell, segment: Segment, radius_m: f64) -> u64 {
    let center = lattice.center(cell);
    let to_center = segment.distance_to_point(center);
    let reach = lattice.cell_m * 0.4375 * std::f64::consts::SQRT_2;
    if to_center + reach <= radius_m {
        return u64::MAX;
    }
    if to_center - reach > radius_m {
        return 0;
    }
    let mut samples = 0;
    for bit in 0..SAMPLES_PER_CELL {
        if segment.distance_to_point(sample_point(lattice, cell, bit)) <= radius_m {
            samples |= 1 << bit;
        }
    }
    samples
}

/// Where a sample lies, metres.
pub(crate) fn sample_point(lattice: &Lattice, cell: Cell, bit: u32) -> Point {
    let step = lattice.cell_m / f64::from(SIDE);
    Point::new(
        lattice.origin.x + f64::from(cell.x) * lattice.cell_m + (f64::from(bit % SIDE) + 0.5) * step,
        lattice.origin.y + f64::from(cell.y) * lattice.cell_m + (f64::from(bit / SIDE) + 0.5) * step,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn swept_area_agrees_with_a_hundred_times_finer_count() {
        let lattice = Lattice { origin: Point::new(-1.0, -2.0), cell_m: 0.25, columns: 40, rows: 40 };
        let segment = Segment::new(Point::new(1.1, 0.7), Point::new(5.3, 4.9));
        let radius_m = 0.61;
        let mut raster = SweptRaster::new(lattice);
        raster.sweep(segment, radius_m, |_| {});
        let samples = (0..lattice.len()).map(|index| u64::from(raster.samples(index).count_ones())).sum();
        let fine_m = lattice.cell_m / 80.0;
        let points = (0..3200).flat_map(|y| (0..3200).map(move |x| (f64::from(x) + 0.5, f64::from(y) + 0.5)));
        let inside = points
            .filter(|(x, y)| {
                segment.distance_to_point(Point::new(x * fine_m - 1.0, y * fine_m - 2.0)) <= radius_m
            })
            .count();
        let counted_m2 = inside as f64 * fine_m * fine_m;
        let swept_m2 = SweptRaster::area_m2(&lattice, samples);
        assert!((swept_m2 / counted_m2 - 1.0).abs() < 0.005, "{swept_m2} {counted_m2}");
    }

    proptest! {
        #[test]
        fn the_samples_swept_are_just_those_within_the_radius(
            ends in prop::array::uniform4(-60..160_i32), radius in 0..60_i32, flat in any::<bool>(), fine in any::<bool>()
        ) {
            // On whole steps samples lie just at the rim as often as not.
            let step_m = if fine { 0.0137 } else { 0.025 };
            let lattice = Lattice { origin: Point::new(-0.3, 0.2), cell_m: 0.2, columns: 11, rows: 9 };
            let [from_x, from_y, to_x, to_y] = ends.map(|end| f64::from(end) * step_m);
            let segment = Segment::new(Point::new(from_x, from_y), Point::new(to_x, if flat { from_y } else { to_y }));
            let radius_m = f64::from(radius) * step_m;
            let mut swept = vec![0; lattice.len()];
            for_each_swept(&lattice, segment, radius_m, |index, samples| swept[index] |= samples);
            for cell in lattice.cells() {
                let is_within = |&bit: &u32| {
                    radius_m > 0.0 && segment.distance_to_point(sample_point(&lattice, cell, bit)) <= radius_m
                };
                let within = (0..SAMPLES_PER_CELL).filter(is_within).fold(0, |all, bit| all | 1 << bit);
                prop_assert_eq!(swept[lattice.index(cell).unwrap()], within, "{}", cell);
            }
        }
    }

    #[test]
    fn a_cell_gains_its_samples_once() {
        let lattice = Lattice { origin: Point::origin(), cell_m: 1.0, columns: 3, rows: 3 };
        let stand = Segment::new(Point::new(1.5, 1.5), Point::new(1.5, 1.5));
        let mut raster = SweptRaster::new(lattice);
        let mut gained = Vec::new();
        raster.sweep(stand, 0.7, |index| gained.push(index));
        assert_eq!(gained, [1, 3, 4, 5, 7]);
        raster.sweep(stand, 0.7, |index| panic!("cell {index} gained again"));
    }
}
