//! Lanes that are not worth their time, for what else is swept on the way, are left out, and so are those of least worth beyond
//! what is asked for.

use super::{placing::Worth, sweep_tour};
use crate::{ground::Ground, lane_tour::LaneTour, transfers::Way};

/// Leaves out lanes, those with the least swept by them alone for their time first, as long as each is worth less than
/// its time, or the coverage without it is `goal` still. `ground` has been swept by the tour.
pub(super) fn leave_out(tour: &mut LaneTour<'_, '_>, ground: &mut Ground, worth: Worth, goal: f64) {
    let mut order: Vec<(f64, usize)> = (0..tour.len())
        .filter(|&at| tour.lane_at(at) != 0)
        .collect::<Vec<_>>()
        .into_iter()
        .map(|at| {
            let saved_s = tour.saving_s(at);
            let lost = lost_without(tour, ground, at);
            restore(tour, ground, at);
            (lost / saved_s.max(1e-3), tour.lane_at(at))
        })
        .collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    for (per_s, lane) in order {
        let is_worthy = per_s > 1.2 * worth.per_s;
        if is_worthy && ground.coverage() < goal {
            break;
        }
        let Some(at) = tour.place_of(lane).filter(|_| tour.len() > 2) else { continue };
        let saved_s = tour.saving_s(at);
        if lost_without(tour, ground, at) < worth.per_s * saved_s || ground.coverage() >= goal {
            tour.remove(at);
        } else {
            restore(tour, ground, at);
            // Those that follow are worth more still.
            if is_worthy {
                break;
            }
        }
    }
    sweep_tour(ground, tour);
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
