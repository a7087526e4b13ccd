//! Where the lanes of an orientation are driven: the body has to fit, and what the squares need is to be swept.
//!
//! A run of squares wants a lane along its middle. Where walls cut into the run the lane moves aside, in steps of half a
//! place, to where it sweeps the most; it is no longer than it has to be to reach all samples of its squares that are left,
//! and walls divide it. What remains of the run gets another lane if it is worth one.

use crate::{
    configuration_space::ConfigurationSpace,
    ground::Ground,
    lane_tour::Lane,
    minimum_lanes::{Orientation, Run, ToolLattice},
};
use terrain::{Point, Segment};

/// A lane is worth driving if it sweeps this share of the squares along it.
const WORTH: f64 = 0.25;
/// A lane in the middle that sweeps this share of what is left need not move aside.
const GOOD: f64 = 0.995;

/// One lane or more for each run, the longest runs first. What they sweep is swept in `ground`.
pub(super) fn lanes(
    space: &ConfigurationSpace<'_>,
    ground: &mut Ground,
    orientation: &Orientation,
) -> Vec<Lane> {
    let lattice = &orientation.lattice;
    let samples = samples_of_squares(space, ground, lattice);
    let mut runs = orientation.runs();
    runs.sort_by_key(|run| (std::cmp::Reverse(run.squares.len()), run.squares.clone()));
    let mut lanes = Vec::new();
    let worth = (WORTH * whole_square(space, lattice)) as usize;
    for run in &runs {
        let line = Lines { space, lattice, is_along: run.is_along };
        let middle_m = line.middle_m(run);
        loop {
            let left = run.squares.iter().flat_map(|&square| &samples[square]);
            let left: Vec<[f64; 2]> = left
                .filter(|&&place| ground.is_left(place as usize))
                .map(|&place| line.position(space.point(place as usize)))
                .collect();
            if left.len() < worth {
                break;
            }
            let found = line.best(&left, middle_m, lattice.side_m / 2.0, ground.radius_m(), worth);
            if found.is_empty() {
                break;
            }
            let before = ground.left_count();
            for lane in found {
                ground.sweep(&[lane.from, lane.to]);
                lanes.push(lane);
            }
            if ground.left_count() == before {
                break;
            }
        }
    }
    lanes
}

/// Samples in a whole square.
pub(super) fn whole_square(space: &ConfigurationSpace<'_>, lattice: &ToolLattice) -> f64 {
    (lattice.side_m / space.places().cell_m).powi(2)
}

fn samples_of_squares(
    space: &ConfigurationSpace<'_>,
    ground: &Ground,
    lattice: &ToolLattice,
) -> Vec<Vec<u32>> {
    let mut samples = vec![Vec::new(); lattice.is_in.len()];
    for place in (0..space.places().len()).filter(|&place| ground.is_left(place)) {
        if let Some(square) = lattice.square_at(space.point(place)) {
            samples[square].push(place as u32);
        }
    }
    samples
}

/// Lines along one direction of a lattice. Positions are (along the line, across it).
pub(super) struct Lines<'l, 's> {
    pub(super) space: &'l ConfigurationSpace<'s>,
    pub(super) lattice: &'l ToolLattice,
    pub(super) is_along: bool,
}

/// Lanes on one line, as places along it, and how many samples they sweep.
#[derive(Debug, Default)]
struct OnLine {
    parts: Vec<(f64, f64)>,
    gain: usize,
}

impl Lines<'_, '_> {
    pub(super) fn position(&self, point: Point) -> [f64; 2] {
        let [along, across] = self.lattice.position(point);
        if self.is_along { [along, across] } else { [across, along] }
    }

    fn point(&self, along_m: f64, across_m: f64) -> Point {
        self.lattice.point(if self.is_along { [along_m, across_m] } else { [across_m, along_m] })
    }

    fn middle_m(&self, run: &Run) -> f64 {
        let (column, row) = (run.squares[0] % self.lattice.columns, run.squares[0] / self.lattice.columns);
        (if run.is_along { row } else { column } as f64 + 0.5) * self.lattice.side_m
    }

    /// The lanes on the line near `middle_m` that sweeps the most of some samples.
    pub(super) fn best(
        &self,
        samples: &[[f64; 2]],
        middle_m: f64,
        aside_m: f64,
        radius_m: f64,
        worth: usize,
    ) -> Vec<Lane> {
        let step_m = self.space.places().cell_m / 2.0;
        let count = (aside_m / step_m + 1e-6) as i32;
        let mut best = self.on_line(samples, middle_m, radius_m, worth);
        let mut best_m = middle_m;
        if best.gain as f64 <= GOOD * samples.len() as f64 {
            for number in (1..=count).flat_map(|number| [number, -number]) {
                let across_m = middle_m + f64::from(number) * step_m;
                let other = self.on_line(samples, across_m, radius_m, worth);
                if other.gain > best.gain {
                    (best, best_m) = (other, across_m);
                }
            }
        }
        let lane = |(from_m, to_m)| Lane { from: self.point(from_m, best_m), to: self.point(to_m, best_m) };
        best.parts.into_iter().map(lane).collect()
    }

    fn on_line(&self, samples: &[[f64; 2]], across_m: f64, radius_m: f64, worth: usize) -> OnLine {
        let low_m = samples.iter().map(|at| at[0]).fold(f64::INFINITY, f64::min) - radius_m;
        let high_m = samples.iter().map(|at| at[0]).fold(f64::NEG_INFINITY, f64::max) + radius_m;
        let line = Segment::new(self.point(low_m, across_m), self.point(high_m, across_m));
        let mut found = OnLine::default();
        for (from_m, to_m) in self.space.slice(line) {
            let (begin, end, gain) = needed(samples, across_m, radius_m, low_m + from_m, low_m + to_m);
            // A long lane has to sweep as much on each square of its length.
            let squares = 1.0 + (end - begin).max(0.0) / self.lattice.side_m;
            if gain == 0 || (gain as f64) < worth as f64 * squares {
                continue;
            }
            let middle = self.point(f64::midpoint(begin, end), across_m);
            if self.space.nearest_place(middle).is_some() {
                found.parts.push((begin, end));
                found.gain += gain;
            }
        }
        found
    }
}

/// The shortest part between two places of a line from which all samples are swept that can be from between them, and how many
/// these are.
fn needed(samples: &[[f64; 2]], across_m: f64, radius_m: f64, low_m: f64, high_m: f64) -> (f64, f64, usize) {
    let (mut begin, mut end, mut gain) = (f64::INFINITY, f64::NEG_INFINITY, 0);
    for &[along, across] in samples {
        let half2 = radius_m * radius_m - (across - across_m).powi(2);
        if half2 < 0.0 {
            continue;
        }
        // A little less, so that rounding leaves no sample just beyond reach.
        let half = (half2.sqrt() - 1e-6).max(0.0);
        if along + half < low_m || along - half > high_m {
            continue;
        }
        gain += 1;
        begin = begin.min((along + half).min(high_m));
        end = end.max((along - half).max(low_m));
    }
    if begin > end {
        let middle = f64::midpoint(begin, end);
        (begin, end) = (middle, middle);
    }
    (begin, end, gain)
}
