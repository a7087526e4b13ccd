//! What a line sweeps of some samples, place by place along it.
//!
//! From a line, a sample is swept between two places: where the tool's rim reaches it, and where it leaves it behind. Places
//! lie some steps to a sample; how many samples begin to be swept before a place, and how many have been left behind, are
//! running sums, and what a part of the line sweeps is a difference of two of them. Samples that lie in full rows are summed row by
//! row, all samples of a row at once: in a row, all have the same reach.

use crate::ground::Ground;
use std::ops::Range;

/// Places to a sample where ends are looked for closely.
const FINE: usize = 4;
/// Half a tool is taken for so much less, that rounding leaves no sample just beyond reach, metres.
const LESS_M: f64 = 1e-6;

/// Samples for which a line is looked for. Positions are (along the line, across it).
#[derive(Debug, Clone, Copy)]
pub(super) enum Samples<'a> {
    /// All that are left in a rectangle.
    Slab(&'a Slab),
    /// Some, and how far they are apart.
    Loose(&'a [[f64; 2]], f64),
}

/// The samples of a rectangle, row by row along the line.
#[derive(Debug)]
pub(super) struct Slab {
    /// Position of the first sample.
    first_m: [f64; 2],
    sample_m: f64,
    length: usize,
    /// 1 for a sample that is left.
    left: Vec<u16>,
    count: usize,
}

impl Slab {
    /// What is left in a rectangle of columns and rows; `first_m` is the position of its first sample, and lines go along the
    /// rows or along the columns.
    pub(super) fn new(
        ground: &Ground,
        [columns, rows]: [Range<usize>; 2],
        first_m: [f64; 2],
        along_rows: bool,
    ) -> Self {
        let (width, height) = (columns.len(), rows.len());
        let length = if along_rows { width } else { height };
        let mut left = vec![0_u16; width * height];
        let across = ground.samples().columns as usize;
        for (y, row) in rows.enumerate() {
            for (x, column) in columns.clone().enumerate() {
                let at = if along_rows { y * length + x } else { x * length + y };
                left[at] = u16::from(ground.is_left(row * across + column));
            }
        }
        let count = left.iter().map(|&left| usize::from(left)).sum();
        Self { first_m, sample_m: ground.samples().cell_m, length, left, count }
    }

    fn profile<const STEPS: usize>(&self, across_m: f64, radius_m: f64) -> Profile {
        let step_m = self.sample_m / STEPS as f64;
        let margin = ((radius_m / self.sample_m).ceil() as usize + 1) * STEPS;
        let places = (self.length.max(1) - 1) * STEPS + 1 + 2 * margin;
        let (mut begin, mut end) = (vec![0_u32; places], vec![0_u32; places]);
        for (row, left) in self.left.chunks_exact(self.length.max(1)).enumerate() {
            let aside_m = self.first_m[1] + row as f64 * self.sample_m - across_m;
            let Some(half_m) = half_m(radius_m, aside_m) else { continue };
            let half = (half_m / step_m) as usize;
            for (counts, from) in [(&mut begin, margin - half), (&mut end, margin + half)] {
                for (count, &left) in counts[from..].iter_mut().step_by(STEPS).zip(left) {
                    *count += u32::from(left);
                }
            }
        }
        Profile::summed(self.first_m[0] - margin as f64 * step_m, step_m, begin, end)
    }
}

impl Samples<'_> {
    pub(super) fn count(&self) -> usize {
        match self {
            Self::Slab(slab) => slab.count,
            Self::Loose(samples, _) => samples.len(),
        }
    }

    /// What the line at `across_m` sweeps; ends are known more closely where it is `fine`.
    pub(super) fn profile(&self, across_m: f64, radius_m: f64, fine: bool) -> Profile {
        match self {
            Self::Slab(slab) if fine => slab.profile::<FINE>(across_m, radius_m),
            Self::Slab(slab) => slab.profile::<1>(across_m, radius_m),
            Self::Loose(samples, sample_m) => loose(samples, sample_m / FINE as f64, across_m, radius_m),
        }
    }
}

fn loose(samples: &[[f64; 2]], step_m: f64, across_m: f64, radius_m: f64) -> Profile {
    let low_m = samples.iter().map(|at| at[0]).fold(f64::INFINITY, f64::min) - radius_m;
    let high_m = samples.iter().map(|at| at[0]).fold(f64::NEG_INFINITY, f64::max) + radius_m;
    let places = ((high_m - low_m).max(0.0) / step_m) as usize + 1;
    let (mut begin, mut end) = (vec![0_u32; places], vec![0_u32; places]);
    for &[along_m, aside_m] in samples {
        let Some(half_m) = half_m(radius_m, aside_m - across_m) else { continue };
        let first = ((along_m - half_m - low_m) / step_m).ceil() as usize;
        let last = ((along_m + half_m - low_m) / step_m) as usize;
        if first <= last {
            begin[first.min(places - 1)] += 1;
            end[last.min(places - 1)] += 1;
        }
    }
    Profile::summed(low_m, step_m, begin, end)
}

/// How far along the line a sample is within reach, to either side.
fn half_m(radius_m: f64, aside_m: f64) -> Option<f64> {
    let half2 = radius_m * radius_m - aside_m * aside_m;
    (half2 >= 0.0).then(|| (half2.sqrt() - LESS_M).max(0.0))
}

/// Places along a line, and what is swept up to each.
#[derive(Debug)]
pub(super) struct Profile {
    pub(super) from_m: f64,
    step_m: f64,
    /// Samples that begin to be swept at a place or before it.
    begun: Vec<u32>,
    /// Samples that are swept last from before a place.
    ended: Vec<u32>,
}

/// A part of a line, and the samples it sweeps.
#[derive(Debug, Clone, Copy)]
pub(super) struct Swath {
    pub(super) from_m: f64,
    pub(super) to_m: f64,
    pub(super) swept: usize,
}

impl Profile {
    fn summed(from_m: f64, step_m: f64, begin: Vec<u32>, end: Vec<u32>) -> Self {
        let mut sum = 0;
        let begun = begin.into_iter().map(|count| {
            sum += count;
            sum
        });
        let begun = begun.collect();
        let mut sum = 0;
        let ended = end.into_iter().map(|count| {
            let before = sum;
            sum += count;
            before
        });
        Self { from_m, step_m, begun, ended: ended.collect() }
    }

    pub(super) fn to_m(&self) -> f64 {
        self.from_m + (self.begun.len() - 1) as f64 * self.step_m
    }

    /// The part between two places that is worth the most, when a metre is worth `per_m` samples.
    pub(super) fn worthy(&self, low_m: f64, high_m: f64, per_m: f64) -> Option<Swath> {
        let per_step = per_m * self.step_m;
        let place = |along_m: f64| (along_m - self.from_m) / self.step_m;
        let first = (place(low_m) - 1e-6).ceil().max(0.0) as usize;
        let last = ((place(high_m) + 1e-6).floor() as usize).min(self.begun.len() - 1);
        if first > last {
            return None;
        }
        let before = f64::from(self.ended[first]);
        let value = |to: usize| f64::from(self.begun[to]) - before - (to - first) as f64 * per_step;
        let to = best(first..=last, value);
        let value =
            |from: usize| f64::from(self.begun[to]) - f64::from(self.ended[from]) + from as f64 * per_step;
        let from = best(first..=to, value);
        let swept = self.begun[to].saturating_sub(self.ended[from]) as usize;
        let at = |place: usize| (self.from_m + place as f64 * self.step_m).clamp(low_m, high_m);
        (swept > 0).then(|| Swath { from_m: at(from), to_m: at(to), swept })
    }
}

/// The first place with the highest value.
fn best(places: std::ops::RangeInclusive<usize>, value: impl Fn(usize) -> f64) -> usize {
    let (mut best, mut most) = (*places.start(), f64::NEG_INFINITY);
    for place in places {
        let value = value(place);
        if value > most {
            (best, most) = (place, value);
        }
    }
    best
}
