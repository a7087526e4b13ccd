//! In which directions lanes are worth a try, and what one direction for all ground costs (Huang 2001).
//!
//! The altitude of a piece of ground is its extent across the lanes: about so many tool widths of lanes it needs. Between two
//! directions in which a supporting line lies flush with an edge of a hull it is a piece of a sine, concave: the least
//! altitude is at such an edge, of the outer hull or of the hull of a hole.

use super::raster::{NONE, Raster};
use std::f64::consts::{FRAC_PI_2, PI};

/// Edges within this angle count as one direction.
const SAME_RAD: f64 = 1.5 * PI / 180.0;
/// Less than this from the rows of squares is taken for the rows themselves.
const STRAIGHT_RAD: f64 = 0.2 * PI / 180.0;

/// At most `most` directions in [0, π), those with the longest hull edges first. Edges shorter than `least_m` are curves.
pub(super) fn candidates(ground: &Raster, least_m: f64, most: usize) -> Vec<f64> {
    let mut edges: Vec<(f64, f64)> = hulls(ground)
        .iter()
        .flat_map(|hull| hull_edges(hull))
        .map(|(angle, length)| (angle, length * ground.frame().step_m()))
        .filter(|&(_, length_m)| length_m >= least_m)
        .collect();
    let mut chosen = Vec::new();
    while chosen.len() < most && !edges.is_empty() {
        let weight = |angle: f64| -> f64 { near(&edges, angle).map(|(_, length_m)| length_m).sum() };
        let best = edges.iter().map(|&(angle, _)| angle).max_by(|&a, &b| weight(a).total_cmp(&weight(b)));
        let best = best.expect("there are edges");
        let mean = near(&edges, best).map(|&(angle, length_m)| turn(best, angle) * length_m).sum::<f64>()
            / weight(best);
        chosen.push(snapped((best + mean).rem_euclid(PI)));
        edges.retain(|&(angle, _)| turn(best, angle).abs() > 2.0 * SAME_RAD);
    }
    chosen
}

/// Rows of runs when all lanes run one way, metres: the altitude of the ground plus those of its holes. A border that runs
/// nearly along the rows tears single rows into many runs; so the least of three rows counts.
pub(super) fn altitude_m(ground: &Raster, angle_rad: f64) -> f64 {
    let runs: Vec<usize> = ground.turned(angle_rad).slices().iter().map(Vec::len).collect();
    let least = runs.windows(3).map(|rows| rows.iter().min().copied().unwrap_or(0));
    least.sum::<usize>() as f64 * ground.frame().step_m()
}

/// The direction with the least altitude of all candidates and what is square to them.
pub(super) fn main_direction(ground: &Raster, candidates: &[f64]) -> f64 {
    let square = candidates.iter().map(|&angle| snapped((angle + FRAC_PI_2).rem_euclid(PI)));
    let all = [0.0, FRAC_PI_2].into_iter().chain(candidates.iter().copied()).chain(square);
    let priced = all.map(|angle| (altitude_m(ground, angle), angle));
    priced.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |(_, angle)| angle)
}

/// The turn from one direction of lanes to another, in (-π/2, π/2].
pub(super) fn turn(from: f64, to: f64) -> f64 {
    let turn = (to - from).rem_euclid(PI);
    if turn > FRAC_PI_2 { turn - PI } else { turn }
}

fn near(edges: &[(f64, f64)], angle: f64) -> impl Iterator<Item = &(f64, f64)> + '_ {
    edges.iter().filter(move |edge| turn(angle, edge.0).abs() <= SAME_RAD)
}

fn snapped(angle: f64) -> f64 {
    let axes = [0.0, FRAC_PI_2, PI];
    axes.into_iter().find(|axis| (axis - angle).abs() < STRAIGHT_RAD).map_or(angle, |axis| axis % PI)
}

/// Corners in squares.
type Corner = (i64, i64);

/// Convex hulls of the pieces of ground and of the holes in it, as corners of squares.
fn hulls(ground: &Raster) -> Vec<Vec<Corner>> {
    let (pieces, count) = pieces(ground);
    let (columns, rows) = (ground.columns(), ground.rows());
    let mut corners: Vec<Vec<Corner>> = vec![Vec::new(); count];
    for row in 0..rows {
        let line = &pieces[row * columns..(row + 1) * columns];
        let mut from = 0;
        for to in 1..=columns {
            if to == columns || line[to] != line[from] {
                let (y, left, right) = (row as i64, from as i64, to as i64);
                corners[line[from] as usize].extend([(left, y), (right, y), (left, y + 1), (right, y + 1)]);
                from = to;
            }
        }
    }
    let on_the_rim = |index: usize| {
        let (column, row) = (index % columns, index / columns);
        column == 0 || row == 0 || column + 1 == columns || row + 1 == rows
    };
    let mut wanted = vec![true; count];
    for index in (0..pieces.len()).filter(|&index| on_the_rim(index) && ground.labels()[index] == NONE) {
        wanted[pieces[index] as usize] = false;
    }
    corners.into_iter().zip(wanted).filter(|(_, wanted)| *wanted).map(|(corners, _)| hull(corners)).collect()
}

/// Per square the number of the connected piece (of ground, or of what is no ground) it belongs to.
pub(super) fn pieces(ground: &Raster) -> (Vec<u32>, usize) {
    let (columns, labels) = (ground.columns(), ground.labels());
    let mut piece = vec![NONE; labels.len()];
    let mut count = 0;
    let mut stack = Vec::new();
    for first in 0..labels.len() {
        if piece[first] != NONE {
            continue;
        }
        piece[first] = count;
        stack.push(first);
        while let Some(at) = stack.pop() {
            for next in neighbours(at, columns, labels.len()) {
                if piece[next] == NONE && (labels[next] == NONE) == (labels[first] == NONE) {
                    piece[next] = count;
                    stack.push(next);
                }
            }
        }
        count += 1;
    }
    (piece, count as usize)
}

/// Numbers of the squares beside a square.
pub(super) fn neighbours(at: usize, columns: usize, squares: usize) -> impl Iterator<Item = usize> {
    let left = (!at.is_multiple_of(columns)).then(|| at - 1);
    let right = (!(at + 1).is_multiple_of(columns)).then_some(at + 1);
    let below = at.checked_sub(columns);
    let above = (at + columns < squares).then_some(at + columns);
    [left, right, below, above].into_iter().flatten()
}

/// Convex hull, anticlockwise (Andrew's monotone chain).
fn hull(mut corners: Vec<Corner>) -> Vec<Corner> {
    corners.sort_unstable();
    corners.dedup();
    let half = |corners: &mut dyn Iterator<Item = Corner>| {
        let mut chain: Vec<Corner> = Vec::new();
        for corner in corners {
            while chain.len() >= 2 && !turns_left(chain[chain.len() - 2], chain[chain.len() - 1], corner) {
                chain.pop();
            }
            chain.push(corner);
        }
        chain.pop();
        chain
    };
    let mut whole = half(&mut corners.iter().copied());
    whole.extend(half(&mut corners.iter().rev().copied()));
    whole
}

fn turns_left(a: Corner, b: Corner, c: Corner) -> bool {
    (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0) > 0
}

/// Direction in [0, π) in the map frame and length in squares of each edge.
fn hull_edges(hull: &[Corner]) -> impl Iterator<Item = (f64, f64)> {
    let next = hull.iter().cycle().skip(1);
    hull.iter().zip(next).map(|(a, b)| {
        let (dx, dy) = ((b.0 - a.0) as f64, (b.1 - a.1) as f64);
        (snapped(dy.atan2(dx).rem_euclid(PI)), dx.hypot(dy))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planners::boustrophedon::raster::Frame;
    use terrain::Point;

    /// A slanting hall, 20 m by 8 m, in squares of 0.1 m.
    fn hall(angle_rad: f64) -> Raster {
        let (along, middle) =
            (terrain::Vector::new(angle_rad.cos(), angle_rad.sin()), Point::new(12.0, 12.0));
        Raster::new(Frame::around(Point::origin(), Point::new(24.0, 24.0), 0.1, 0.0), |point| {
            let way = point - middle;
            let inside = way.dot(&along).abs() < 10.0 && way.perp(&along).abs() < 4.0;
            if inside { 0 } else { NONE }
        })
    }

    #[test]
    fn lanes_run_along_a_slanting_hall() {
        for degrees in [0.0_f64, 1.5, 30.0, 90.0, 123.0] {
            let hall = hall(degrees.to_radians());
            let found = candidates(&hall, 1.0, 2);
            let best = main_direction(&hall, &found);
            assert!(turn(best, degrees.to_radians()).abs() < 0.01, "{degrees}: {best} of {found:?}");
            assert!((altitude_m(&hall, best) - 8.0).abs() < 0.4);
        }
    }
}
