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
