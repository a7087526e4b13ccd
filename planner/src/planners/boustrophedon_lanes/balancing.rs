//! Lanes that are not worth their time, for what else is swept on the way, are left out, and so are those of least worth beyond
//! what is asked for.

use super::{placing::Worth, ranked::Ranked};
use crate::{ground::Ground, lane_tour::LaneTour, transfers::Way};
use std::{cmp::Reverse, collections::BinaryHeap};

/// Leaves out lanes, those with the least swept by them alone for their time first, as long as each is worth less than
/// its time, or the coverage without it is `goal` still. `ground` has been swept by the tour. Which lanes come first is
/// told by an estimate at first, and looked at closely when it is their turn. In the end `ground` is as the tour leaves it.
pub(super) fn leave_out(tour: &mut LaneTour<'_, '_>, ground: &mut Ground, worth: Worth, goal: f64) {
    let mut heap = BinaryHeap::new();
    for at in 0..tour.len() {
        let lane = tour.lane_at(at);
        if lane == 0 {
            continue;
        }
        let per_s = ground.alone(&tour.lane(lane).points) as f64 / tour.most_saving_s(at).max(1e-3);
        heap.push((Reverse(Ranked { per_s, number: lane }), false));
    }
    while let Some((Reverse(Ranked { per_s, number: lane }), is_exact)) = heap.pop() {
        let is_worthy = per_s > 1.2 * worth.per_s;
        if is_worthy && ground.coverage() < goal {
            break;
        }
        let Some(at) = tour.place_of(lane).filter(|_| tour.len() > 2) else { continue };
        let saved_s = tour.saving_s(at);
        let lost = lost_without(tour, ground, at);
        if !is_exact {
            restore(tour, ground, at);
            heap.push((Reverse(Ranked { per_s: lost / saved_s.max(1e-3), number: lane }), true));
        } else if lost < worth.per_s * saved_s || ground.coverage() >= goal {
            tour.remove(at);
        } else {
            restore(tour, ground, at);
            // Those that follow are worth more still.
            if is_worthy {
                break;
            }
        }
    }
}

/// Samples that nothing would sweep without a lane; `ground` is left as without it.
fn lost_without(tour: &mut LaneTour<'_, '_>, ground: &mut Ground, at: usize) -> f64 {
    let before = ground.left_count();
    let [to, from, instead] = tour.ways_at(at);
    ground.sweep(points(instead.as_ref()));
    ground.unsweep(points(to.as_ref()));
    ground.unsweep(points(from.as_ref()));
    ground.unsweep(&tour.lane(tour.lane_at(at)).points);
    ground.left_count() as f64 - before as f64
}

fn restore(tour: &mut LaneTour<'_, '_>, ground: &mut Ground, at: usize) {
    let [to, from, instead] = tour.ways_at(at);
    ground.sweep(points(to.as_ref()));
    ground.sweep(points(from.as_ref()));
    ground.sweep(&tour.lane(tour.lane_at(at)).points);
    ground.unsweep(points(instead.as_ref()));
}

fn points(way: Option<&Way>) -> &[terrain::Point] {
    way.map_or(&[], |way| &way.points)
}
