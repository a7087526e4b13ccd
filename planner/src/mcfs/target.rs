//! Sweeps a given share of the ground: what costs most way for its ground is left out first.
//!
//! Thin loops in the middle of pockets sweep much that is swept already: they go first. Then the tracks move away from
//! the walls: the outermost ones get shorter, and the ground lost is a rim of even width. How far is found by trial.

use super::swept_counts::SweptCounts;
use super::tracks::{self, Track};
use super::{Cover, McfsOptions, PolygonInstance, lines_along};
use geo::{Euclidean, Length};
use terrain::Point;

/// Tracks that sweep less new ground than this share of way × width are left out.
const LEAST_YIELD: f64 = 0.8;
/// How much more ground is worth than the way that sweeps it.
const GROUND_WORTH: f64 = 2.0;
/// Trials.
const TRIALS: usize = 5;
/// The raster may be so far off.
const RASTER_ERROR: f64 = 5e-4;

/// The best cover found that sweeps at least `target` of the ground; with all tracks when none does.
pub(super) fn cover_share(
    instance: &PolygonInstance,
    options: &McfsOptions,
    target: f64,
) -> Option<Cover> {
    let least_m = tracks::first_distance_m(instance);
    let rim_m: f64 = instance.rings().map(|(_, ring)| Euclidean.length(ring)).sum();
    let target = target + RASTER_ERROR;
    let (mut first_m, mut best) = (least_m, None::<Cover>);
    for _ in 0..TRIALS {
        let tracks = worthwhile(instance, tracks::tracks(instance, first_m));
        let Some(cover) = lines_along(instance, options, &tracks, GROUND_WORTH) else { break };
        let spare_m = (cover.coverage - target) * instance.area_m2() / rim_m;
        let is_better = best.as_ref().is_none_or(|best| {
            let (enough, was_enough) = (cover.coverage >= target, best.coverage >= target);
            match (enough, was_enough) {
                (true, true) => cover.makespan_m() < best.makespan_m(),
                (false, false) => cover.coverage > best.coverage,
                (enough, _) => enough,
            }
        });
        if is_better {
            best = Some(cover);
        }
        first_m = (first_m + spare_m).max(least_m);
    }
    match best {
        Some(best) if best.coverage >= target => Some(best),
        _ => super::whole(instance, options),
    }
}

/// The tracks whose own ground is worth their way.
fn worthwhile(instance: &PolygonInstance, tracks: Vec<Track>) -> Vec<Track> {
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
        links(&track).into_iter().for_each(|(from, to)| swept.take_out(from, to));
        if swept.unswept_m2() - before_m2 >= LEAST_YIELD * width_m * track.length_m() {
            links(&track).into_iter().for_each(|(from, to)| swept.put_in(from, to));
            kept.push(track);
        }
    }
    kept.reverse();
    kept
}
