//! What it costs to lead one stretch of track into another.
//!
//! ```text
//!   ──▶ a            a, b: where the two stretches end and begin; t, u: headings there
//!        ╲           a bend where the headings' lines cross; else a slant that begins before a and ends after b
//!         b ──▶
//! ```

use terrain::{Point, Vector};

/// Way that one radian of turning is worth, as a share of the tool's width.
pub(super) const TURN_WORTH: f64 = 1.0;
/// How far a stretch may be cut back or drawn out, in widths of the tool.
const REACH: f64 = 2.6;
/// Cut backs tried for slants, in widths of the tool, and the way that each is taken to lose.
const SLANTS: [(f64, f64); 3] = [(0.75, 0.05), (1.5, 0.1), (2.5, 0.2)];
/// Only where the headings agree that far (cosine) is a slant drawn out: a turn back would leave ground.
const ONWARDS: f64 = 0.3;
/// Headings less apart than this have no useful crossing (sine).
const PARALLEL: f64 = 0.2;

/// A place on a track and the unit heading there.
#[derive(Debug, Clone, Copy)]
pub(super) struct End {
    pub(super) at: Point,
    pub(super) heading: Vector,
}

/// Way and turning.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cost {
    pub(super) length_m: f64,
    pub(super) turn_rad: f64,
}

impl Cost {
    pub(super) fn value_m(self, width_m: f64) -> f64 {
        self.length_m + TURN_WORTH * width_m * self.turn_rad
    }
}

/// The cheapest way from the end of one stretch into the beginning of another.
pub(super) fn joint(from: End, to: End, width_m: f64) -> Cost {
    let mut best = slant(from, to, 0.0, 0.0);
    let better = |cost: Cost, best: Cost| cost.value_m(width_m) < best.value_m(width_m);
    if let Some(bend) = bend(from, to, width_m)
        && better(bend, best)
    {
        best = bend;
    }
    let onwards = from.heading.dot(&to.heading) > ONWARDS;
    for (cut, loss) in SLANTS.into_iter().filter(|_| onwards) {
        let slant = slant(from, to, cut * width_m, loss * width_m);
        if better(slant, best) {
            best = slant;
        }
    }
    best
}

fn bend(from: End, to: End, width_m: f64) -> Option<Cost> {
    let (apart, cross) = (to.at - from.at, from.heading.perp(&to.heading));
    if cross.abs() < PARALLEL {
        return None;
    }
    let (before_m, after_m) = (apart.perp(&to.heading) / cross, from.heading.perp(&apart) / cross);
    let reach_m = REACH * width_m;
    let fits = before_m.abs() <= reach_m && after_m.abs() <= reach_m;
    fits.then(|| Cost { length_m: before_m + after_m, turn_rad: turn_rad(from.heading, to.heading) })
}

fn slant(from: End, to: End, cut_m: f64, loss_m: f64) -> Cost {
    let way = to.at + to.heading * cut_m - (from.at - from.heading * cut_m);
    let length_m = way.norm();
    if length_m < 1e-9 {
        return Cost { length_m: loss_m, turn_rad: turn_rad(from.heading, to.heading) };
    }
    let turn_rad = turn_rad(from.heading, way) + turn_rad(way, to.heading);
    Cost { length_m: length_m - 2.0 * cut_m + loss_m, turn_rad }
}

/// The size of the turn between two directions, radians.
pub(super) fn turn_rad(from: Vector, to: Vector) -> f64 {
    from.perp(&to).atan2(from.dot(&to)).abs()
}

/// The turning along a line, radians.
pub(super) fn turning_rad(line: &[Point]) -> f64 {
    let steps: Vec<Vector> =
        line.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| step.norm() > 1e-9).collect();
    steps.windows(2).map(|pair| turn_rad(pair[0], pair[1])).sum()
}
