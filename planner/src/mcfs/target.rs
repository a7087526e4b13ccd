//! Sweeps a given share of the ground: what costs most way for its ground is left out first.
//!
//! Thin loops in the middle of pockets sweep much that is swept already: they go first. Then the tracks move away from
//! the walls: the outermost ones get shorter, and the ground lost is a rim of even width. How far is found by trial.

use super::swept_counts::SweptCounts;
use super::tracks::{self, Track};
use super::{Cover, GroundWorth, McfsOptions, PolygonInstance, TURN_WORTH, lines_along};
use geo::{Euclidean, Length};
use terrain::Point;

/// Tracks that sweep less new ground than this share of way × width are left out: each is tried.
const LEAST_YIELDS: [f64; 2] = [0.85, 0.5];
/// How much more ground is worth than the way that sweeps it.
const GROUND_WORTH: f64 = 2.0;
/// What it is worth in the end, when more is swept than was asked for.
const SPARE_GROUND_WORTHS: [f64; 2] = [1.5, 1.1];
/// Distances from the walls that are tried.
const TRIALS: usize = 6;
/// Trials even the shares out so often; the best distance from the walls is then planned as often as was asked for.
const TRIAL_CORRECTIONS: usize = 1;
/// So often the tracks are moved farther when the best trial is planned in full.
const REFINEMENTS: usize = 2;
/// Near enough to the share asked for.
const NEAR: f64 = 1.5e-3;
/// The raster may be so far off.
const RASTER_ERROR: f64 = 8e-4;

/// The best cover found that sweeps at least `target` of the ground; with all tracks when none does.
pub(super) fn cover_share(instance: &PolygonInstance, options: &McfsOptions, target: f64) -> Option<Cover> {
    let trials = LEAST_YIELDS.into_iter().filter_map(|least_yield| {
        let search = Search { instance, options, target, least_yield };
        search.nearest().map(|(first_m, trial)| search.refined(first_m, trial))
    });
    let best = trials.min_by(|a, b| a.makespan_m().total_cmp(&b.makespan_m()));
    best.or_else(|| super::whole(instance, options))
}

/// Moves the tracks away from the walls until just enough is swept.
struct Search<'a> {
    instance: &'a PolygonInstance,
    options: &'a McfsOptions,
    target: f64,
    least_yield: f64,
}

impl Search<'_> {
    /// The best of a few trials that sweep enough: distance of the first track from the walls, and the lines.
    fn nearest(&self) -> Option<(f64, Cover)> {
        let corrections = TRIAL_CORRECTIONS.min(self.options.corrections);
        let quick = McfsOptions { corrections, ..self.options.clone() };
        let (mut enough, mut too_far) = (None::<(f64, f64)>, None::<(f64, f64)>);
        let (mut first_m, mut best) = (tracks::first_distance_m(self.instance), None::<(f64, Cover)>);
        for _ in 0..TRIALS {
            let Some(cover) = self.lines(first_m, &quick) else { break };
            let spare = self.spare(&cover);
            if spare >= 0.0 {
                enough = Some((first_m, spare));
                if best.as_ref().is_none_or(|(_, best)| cover.makespan_m() < best.makespan_m()) {
                    best = Some((first_m, cover));
                }
                if spare < NEAR {
                    break;
                }
            } else {
                too_far = Some((first_m, spare));
            }
            first_m = match (enough, too_far) {
                (Some(enough), Some(too_far)) => between(enough, too_far),
                (Some((near_m, spare)), None) => near_m + self.rim_m(spare),
                (None, _) => break,
            };
        }
        best
    }

    /// Plans a trial in full, and moves the tracks on while enough is swept. Each time with all that the tracks sweep,
    /// and with what is beyond the share given up.
    fn refined(&self, mut near_m: f64, mut best: Cover) -> Cover {
        let mut step_m = self.rim_m(self.spare(&best).max(0.0));
        for round in 0..=REFINEMENTS {
            let first_m = if round == 0 { near_m } else { near_m + step_m };
            let Some(cover) = self.lines(first_m, self.options) else { break };
            let spare = self.spare(&cover);
            let exact = self.lines_for(first_m, self.options, self.target + RASTER_ERROR);
            for cover in exact.into_iter().chain([cover]).filter(|cover| self.spare(cover) >= 0.0) {
                if cover.makespan_m() < best.makespan_m() {
                    best = cover;
                }
            }
            if spare < 0.0 {
                step_m *= 0.5;
            } else {
                (near_m, step_m) = (first_m, self.rim_m(spare));
            }
        }
        best
    }

    fn lines(&self, first_m: f64, options: &McfsOptions) -> Option<Cover> {
        self.lines_for(first_m, options, 1.0)
    }

    /// Lines along tracks at a distance from the walls; what they sweep beyond a share is worth less.
    fn lines_for(&self, first_m: f64, options: &McfsOptions, plenty: f64) -> Option<Cover> {
        let tracks = worthwhile(self.instance, tracks::tracks(self.instance, first_m), self.least_yield);
        let beyond = SPARE_GROUND_WORTHS;
        let worth =
            GroundWorth { before: GROUND_WORTH, scanty: 0.0, plenty, beyond, turn_beyond: TURN_WORTH };
        lines_along(self.instance, options, &tracks, &worth)
    }

    fn spare(&self, cover: &Cover) -> f64 {
        cover.coverage - self.target - RASTER_ERROR
    }

    /// How wide a rim along all walls holds a share of the ground.
    fn rim_m(&self, share: f64) -> f64 {
        let walls_m: f64 = self.instance.rings().map(|(_, ring)| Euclidean.length(ring)).sum();
        share * self.instance.area_m2() / walls_m
    }
}

/// Where the spare coverage is likely to be gone, well within the two ends.
fn between((near_m, spare): (f64, f64), (far_m, lack): (f64, f64)) -> f64 {
    near_m + (far_m - near_m) * (spare / (spare - lack)).clamp(0.25, 0.85)
}

/// The tracks whose own ground is worth their way.
fn worthwhile(instance: &PolygonInstance, tracks: Vec<Track>, least_yield: f64) -> Vec<Track> {
    let width_m = instance.tool_width_m;
    let mut swept = SweptCounts::new(&instance.ground, width_m);
    let links = |track: &Track| -> Vec<(Point, Point)> {
        let next = track.corners.iter().cycle().skip(1);
        track.corners.iter().copied().zip(next.copied()).collect()
    };
    tracks.iter().flat_map(links).for_each(|(from, to)| swept.put_in(from, to));
    let mut kept = Vec::new();
    for track in tracks.into_iter().rev() {
        let before_m2 = swept.unswept_m2();
        for (from, to) in links(&track) {
            swept.take_out(from, to);
        }
        if swept.unswept_m2() - before_m2 >= least_yield * width_m * track.length_m() {
            for (from, to) in links(&track) {
                swept.put_in(from, to);
            }
            kept.push(track);
        }
    }
    kept.reverse();
    kept
}
