//! What the tool's disc has swept: 8 × 8 samples in each cell of the lattice, one bit each.
//!
//! A sample counts as swept when its point lies within the tool's radius of the line driven. Area arithmetic
//! is counting bits: one sample stands for 1/64 of a cell.

use crate::{Cell, Lattice, Point, Segment};

/// Samples in a cell: 8 × 8, one bit of a `u64` each, row by row from the lower left.
pub const SAMPLES_PER_CELL: u32 = 64;
const SIDE: u32 = 8;

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
        if radius_m.is_nan() || radius_m <= 0.0 {
            return;
        }
        let lattice = self.lattice;
        let low = Point::from(segment.from.coords.inf(&segment.to.coords).add_scalar(-radius_m));
        let high = Point::from(segment.from.coords.sup(&segment.to.coords).add_scalar(radius_m));
        for cell in lattice.cells_in_box(low, high) {
            let Some(index) = lattice.index(cell) else { continue };
            if self.swept[index] == u64::MAX {
                continue;
            }
            let gained = samples_within(&lattice, cell, segment, radius_m) & !self.swept[index];
            if gained != 0 {
                self.swept[index] |= gained;
                changed(index);
            }
        }
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

/// The samples of a cell that a disc of `radius_m` metres sweeps along a segment.
pub fn samples_swept_along(lattice: &Lattice, cell: Cell, segment: Segment, radius_m: f64) -> u64 {
    samples_within(lattice, cell, segment, radius_m)
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
