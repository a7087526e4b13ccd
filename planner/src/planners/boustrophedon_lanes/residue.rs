//! Short lanes for what a tour leaves unswept.
//!
//! Samples that are left and touch form a patch. For each patch the lines of both directions that pass it are tried, and the
//! one that sweeps the most of it is kept; the patches that gain the most come first, until the coverage asked for is
//! reached.

use super::placing::Lines;
use crate::{
    configuration_space::ConfigurationSpace, ground::Ground, lane_tour::Lane, minimum_lanes::ToolLattice,
};

/// Patches of fewer samples are left.
const PATCH_MIN: usize = 2;

/// Lanes that bring the coverage to `goal`, or as near to it as can be.
pub(super) fn lanes(
    space: &ConfigurationSpace<'_>,
    ground: &mut Ground,
    lattice: &ToolLattice,
    goal: f64,
) -> Vec<Lane> {
    let mut patches = patches(space, ground);
    patches.sort_by_key(|patch| (std::cmp::Reverse(patch.len()), patch[0]));
    let mut lanes = Vec::new();
    for patch in patches {
        if ground.coverage() >= goal {
            break;
        }
        let before = ground.left_count();
        for lane in best_lanes(space, ground, lattice, &patch) {
            ground.sweep(&[lane.from, lane.to]);
            lanes.push(lane);
        }
        debug_assert!(ground.left_count() <= before, "sweeping leaves no more than before");
    }
    lanes
}

fn best_lanes(
    space: &ConfigurationSpace<'_>,
    ground: &Ground,
    lattice: &ToolLattice,
    patch: &[usize],
) -> Vec<Lane> {
    let left: Vec<usize> = patch.iter().copied().filter(|&place| ground.is_left(place)).collect();
    if left.len() < PATCH_MIN {
        return Vec::new();
    }
    let radius_m = ground.radius_m();
    let choices = [true, false].map(|is_along| {
        let lines = Lines { space, lattice, is_along };
        let samples: Vec<[f64; 2]> = left.iter().map(|&place| lines.position(space.point(place))).collect();
        let low_m = samples.iter().map(|at| at[1]).fold(f64::INFINITY, f64::min);
        let high_m = samples.iter().map(|at| at[1]).fold(f64::NEG_INFINITY, f64::max);
        let aside_m = (high_m - low_m) / 2.0 + radius_m;
        lines.best(&samples, f64::midpoint(low_m, high_m), aside_m, radius_m, PATCH_MIN)
    });
    let gain = |lanes: &Vec<Lane>| -> usize {
        lanes.iter().map(|lane| ground.gain(terrain::Segment::new(lane.from, lane.to))).sum()
    };
    let [along, across] = choices;
    if gain(&across) > gain(&along) { across } else { along }
}

/// Samples that are left, gathered where they touch.
fn patches(space: &ConfigurationSpace<'_>, ground: &Ground) -> Vec<Vec<usize>> {
    let columns = space.places().columns as usize;
    let places = space.places().len();
    let mut seen = vec![false; places];
    let mut patches = Vec::new();
    for first in 0..places {
        if seen[first] || !ground.is_left(first) {
            continue;
        }
        seen[first] = true;
        let mut patch = vec![first];
        let mut next = 0;
        while next < patch.len() {
            let place = patch[next];
            next += 1;
            let column = place % columns;
            let around = [
                (column + 1 < columns).then(|| place + 1),
                (column > 0).then(|| place - 1),
                (place + columns < places).then(|| place + columns),
                place.checked_sub(columns),
            ];
            for near in around.into_iter().flatten() {
                if !seen[near] && ground.is_left(near) {
                    seen[near] = true;
                    patch.push(near);
                }
            }
        }
        if patch.len() >= PATCH_MIN {
            patches.push(patch);
        }
    }
    patches
}
