//! Rounds the tips of lines: where a line runs back beside itself it turns in two corners, not in one.
//!
//! ```text
//!   ──────────▶╲           ───────╮      the two new corners lie to both sides of the tip
//!   ◀──────────╱    ──▶    ───────╯
//! ```

use super::joint::turn_rad;
use super::walls::Walls;
use terrain::{Point, Vector};

/// A turn sharper than this is a tip.
const TIP_RAD: f64 = 2.5;
/// Half the width of a rounded tip, in tool widths: the widest one that there is room for.
const HALF_WIDTHS: [f64; 4] = [0.25, 0.12, 0.06, 0.03];
/// How far a rounded tip stays behind, in half widths: at a wall there may be no room to its sides.
const BACKS: [f64; 2] = [0.0, 1.0];
/// How far behind the tip the arms begin to part, in half widths.
const PARTING: f64 = 3.0;

/// Rounds every tip of a line; its first and last point stay.
pub(super) fn round_tips(line: &mut Vec<Point>, walls: &Walls, width_m: f64) {
    let Some(&last) = line.last() else { return };
    line.dedup_by(|next, point| (*next - *point).norm() < 1e-6 * width_m);
    if let Some(end) = line.last_mut() {
        // The last two may have become one: the line ends where it ended.
        *end = last;
    }
    let mut at = 1;
    while at + 1 < line.len() {
        if turn_at(line, at) > TIP_RAD {
            let round =
                |(half, back): (f64, f64)| rounded(line, at, half * width_m, back * half * width_m, walls);
            let shapes = HALF_WIDTHS.into_iter().flat_map(|half| BACKS.map(|back| (half, back)));
            if let Some((range, corners)) = shapes.into_iter().find_map(round) {
                at = range.start + corners.len();
                line.splice(range, corners);
                continue;
            }
        }
        at += 1;
    }
}

fn turn_at(line: &[Point], at: usize) -> f64 {
    turn_rad(line[at] - line[at - 1], line[at + 1] - line[at])
}

/// The points to be replaced and what comes in their place, if there is room.
fn rounded(
    line: &[Point],
    tip: usize,
    half_m: f64,
    back_m: f64,
    walls: &Walls,
) -> Option<(std::ops::Range<usize>, Vec<Point>)> {
    let reach_m = PARTING * half_m;
    let (first, before) = arm(line[..=tip].iter().rev(), reach_m)?;
    let (last, after) = arm(line[tip..].iter(), reach_m)?;
    let apex = line[tip];
    let outwards = ((apex - before).normalize() + (apex - after).normalize()).try_normalize(1e-9)?;
    let across = Vector::new(-outwards.y, outwards.x);
    let apex = apex - outwards * back_m;
    let side = if (before - after).dot(&across) >= 0.0 { across } else { -across };
    let corners = vec![before, apex + side * half_m, apex - side * half_m, after];
    let (from, to) = (tip - first, tip + last);
    let way: Vec<Point> = [line[from]].into_iter().chain(corners.iter().copied()).chain([line[to]]).collect();
    let is_clear = way.windows(2).all(|pair| walls.is_clear(pair[0], pair[1]));
    let turns = (1..way.len() - 1)
        .filter(|&at| (way[at + 1] - way[at]).norm() > 1e-9 && (way[at] - way[at - 1]).norm() > 1e-9);
    let is_round = turns.into_iter().all(|at| turn_at(&way, at) < TIP_RAD);
    (is_clear && is_round).then_some((from + 1..to, corners))
}

/// Walks from a tip: how many points off the first one beyond `reach_m` is, and the place at that distance.
fn arm<'a>(points: impl Iterator<Item = &'a Point>, reach_m: f64) -> Option<(usize, Point)> {
    let (mut left_m, mut before) = (reach_m, None::<Point>);
    for (steps, &point) in points.enumerate() {
        if let Some(before) = before {
            let step_m = (point - before).norm();
            if step_m > left_m {
                return Some((steps, before + (point - before) * (left_m / step_m)));
            }
            left_m -= step_m;
        }
        before = Some(point);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mcfs::PolygonInstance;
    use geo::Rect;

    fn walls() -> Walls {
        let corners = [geo::coord! { x: -1.0, y: -1.0 }, geo::coord! { x: 3.0, y: 1.0 }];
        Walls::new(&PolygonInstance {
            ground: Rect::new(corners[0], corners[1]).to_polygon(),
            tool_width_m: 0.1,
            body_radius_m: 0.05,
            starts: Vec::new(),
        })
    }

    fn sharpest_rad(line: &[Point]) -> f64 {
        (1..line.len() - 1).map(|at| turn_at(line, at)).fold(0.0, f64::max)
    }

    #[test]
    fn a_line_that_runs_back_turns_in_two_corners() {
        let mut line = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (1.0, 0.01), (0.0, 0.02)]
            .map(|(x, y)| Point::new(x, y))
            .to_vec();
        assert!(sharpest_rad(&line) > 3.0);
        round_tips(&mut line, &walls(), 0.1);
        assert!(sharpest_rad(&line) < TIP_RAD, "{line:?}");
        assert_eq!((line[0], line[line.len() - 1]), (Point::new(0.0, 0.0), Point::new(0.0, 0.02)));
    }

    #[test]
    fn ends_stay_where_they_are_even_when_points_coincide() {
        let start = Point::new(0.1, 0.1);
        let mut line =
            vec![start, Point::new(1.0, 0.1), Point::new(1.0, 0.5), start + Vector::new(1e-9, 0.0), start];
        round_tips(&mut line, &walls(), 0.1);
        assert!(line[0] == start && line[line.len() - 1] == start && line.len() == 4, "{line:?}");
    }

    #[test]
    fn a_tip_at_a_wall_is_rounded_less_wide() {
        let mut line = [(0.0, 0.94), (1.0, 0.94), (0.0, 0.93)].map(|(x, y)| Point::new(x, y)).to_vec();
        round_tips(&mut line, &walls(), 0.1);
        assert!(sharpest_rad(&line) < TIP_RAD, "{line:?}");
        assert!(line.iter().all(|point| point.y <= 0.95 + 1e-6), "{line:?}");
    }
}
