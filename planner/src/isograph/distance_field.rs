//! Distance to the border, sampled on a lattice: positive inside, negative outside.
//!
//! ```text
//!   -  -  -  -  -  -      The lattice reaches beyond the border on all sides, so that
//!   -  +  +  +  +  -      every contour of a positive level is closed.
//!   -  +  ++ ++ +  -
//!   -  +  +  +  +  -
//!   -  -  -  -  -  -
//! ```

use super::walls::Walls;
use terrain::Point;

/// Samples of the distance to the border.
#[derive(Debug)]
pub(super) struct DistanceField {
    /// The lower left sample.
    pub(super) origin: Point,
    pub(super) pitch_m: f64,
    pub(super) columns: usize,
    pub(super) rows: usize,
    pub(super) distance_m: Vec<f64>,
}

/// Samples beyond the border on each side.
const MARGIN: f64 = 1.5;

impl DistanceField {
    pub(super) fn new(walls: &Walls, pitch_m: f64) -> Self {
        let (low, high) = walls.bounds();
        let origin = low - terrain::Vector::repeat(MARGIN * pitch_m);
        let samples = |length: f64| (length / pitch_m + 2.0 * MARGIN).ceil() as usize + 1;
        let (columns, rows) = (samples(high.x - low.x), samples(high.y - low.y));
        let mut field = Self { origin, pitch_m, columns, rows, distance_m: Vec::new() };
        field.distance_m = (0..rows).flat_map(|row| field.row(walls, row)).collect();
        field
    }

    fn row(&self, walls: &Walls, row: usize) -> Vec<f64> {
        let crossings = walls.crossings(self.place(0, row).y);
        let sample = |column| {
            let place = self.place(column, row);
            let is_inside = crossings.partition_point(|&x| x <= place.x) % 2 == 1;
            let distance_m = walls.distance_m(place);
            if is_inside { distance_m } else { -distance_m }
        };
        (0..self.columns).map(sample).collect()
    }

    /// Where a sample lies.
    pub(super) fn place(&self, column: usize, row: usize) -> Point {
        self.origin + terrain::Vector::new(column as f64, row as f64) * self.pitch_m
    }

    pub(super) fn at(&self, column: usize, row: usize) -> f64 {
        self.distance_m[row * self.columns + column]
    }

    /// The largest distance of all samples.
    pub(super) fn deepest_m(&self) -> f64 {
        self.distance_m.iter().copied().fold(0.0, f64::max)
    }
}
