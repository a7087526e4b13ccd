//! What lies near a place: numbers filed in square bins.

use terrain::Point;

/// The most bins along one side.
const BINS_MAX: f64 = 2000.0;

/// Numbers by place.
#[derive(Clone)]
pub(super) struct Near {
    low: Point,
    bin_m: f64,
    columns: usize,
    rows: usize,
    bins: Vec<Vec<u32>>,
}

impl Near {
    /// Empty bins of about `bin_m` over all `places`.
    pub(super) fn new(places: impl Iterator<Item = Point> + Clone, bin_m: f64) -> Self {
        let low = places.clone().fold(Point::new(f64::MAX, f64::MAX), |low, place| low.inf(&place));
        let high = places.fold(low, |high, place| high.sup(&place));
        let size = high - low;
        let bin_m = bin_m.max(size.max() / BINS_MAX);
        let count = |length: f64| (length / bin_m) as usize + 1;
        let (columns, rows) = (count(size.x), count(size.y));
        Self { low, bin_m, columns, rows, bins: vec![Vec::new(); columns * rows] }
    }

    pub(super) fn insert(&mut self, place: Point, number: u32) {
        self.insert_box(place, place, number);
    }

    /// Files a number in every bin that the box over two corners touches.
    pub(super) fn insert_box(&mut self, one: Point, other: Point, number: u32) {
        for bin in self.bins_over(one.inf(&other), one.sup(&other)) {
            self.bins[bin].push(number);
        }
    }

    /// The numbers in the bins that a box touches; those filed in several come several times.
    pub(super) fn in_box(&self, low: Point, high: Point) -> impl Iterator<Item = u32> + '_ {
        self.bins_over(low, high).flat_map(|bin| self.bins[bin].iter().copied())
    }

    /// The numbers in the bins within `reach_m` of a place.
    pub(super) fn around(&self, place: Point, reach_m: f64) -> impl Iterator<Item = u32> + '_ {
        let reach = terrain::Vector::repeat(reach_m);
        self.in_box(place - reach, place + reach)
    }

    fn bins_over(&self, low: Point, high: Point) -> impl Iterator<Item = usize> + use<> {
        let bin = |value: f64, count: usize| ((value / self.bin_m).max(0.0) as usize).min(count - 1);
        let (x0, x1) = (bin(low.x - self.low.x, self.columns), bin(high.x - self.low.x, self.columns));
        let (y0, y1) = (bin(low.y - self.low.y, self.rows), bin(high.y - self.low.y, self.rows));
        let columns = self.columns;
        (y0..=y1).flat_map(move |y| (x0..=x1).map(move |x| y * columns + x))
    }
}
