//! Marching squares: the contours of a distance field at one level.
//!
//! ```text
//!   low ---- low       Around a square, anticlockwise, a contour comes in where the field falls below the level
//!    |        |        and goes out where it rises above it: the higher ground is always on its left. So contours
//!   out ..    |        around the outside go anticlockwise, those around holes clockwise, and neighbouring ones
//!    |    .   |        run the same way.
//!   high - in low
//! ```
//!
//! A saddle, two high corners opposite each other, is told apart by its middle.
//! C. Maple: Geometric design and space planning using the marching squares and marching cube algorithms. GMAG, 2003.

use super::distance_field::DistanceField;
use terrain::Point;

const NONE: u32 = u32::MAX;

/// The closed contours at `level_m`, with the higher ground on the left; the first point is not repeated.
pub(super) fn contours(field: &DistanceField, level_m: f64) -> Vec<Vec<Point>> {
    let mut next = successors(field, level_m);
    let mut found = Vec::new();
    for first in 0..next.len() {
        let mut ring = Vec::new();
        let mut edge = first;
        while next[edge] != NONE {
            ring.push(crossing(field, level_m, edge));
            edge = std::mem::replace(&mut next[edge], NONE) as usize;
        }
        if ring.len() > 2 {
            found.push(ring);
        }
    }
    found
}

/// Per lattice edge that a contour crosses: the one that it crosses next. Edge 2 s goes from sample s to the right,
/// edge 2 s + 1 up from it.
fn successors(field: &DistanceField, level_m: f64) -> Vec<u32> {
    let mut next = vec![NONE; 2 * field.distance_m.len()];
    for row in 0..field.rows - 1 {
        for column in 0..field.columns - 1 {
            let square = Square::new(field, column, row);
            for (entry, exit) in square.passages(level_m) {
                next[square.edges[entry]] = square.edges[exit] as u32;
            }
        }
    }
    next
}

/// Four samples, anticlockwise from the lower left, and the lattice edges that follow each.
struct Square {
    values: [f64; 4],
    edges: [usize; 4],
}

impl Square {
    fn new(field: &DistanceField, column: usize, row: usize) -> Self {
        let sample = row * field.columns + column;
        let above = sample + field.columns;
        let corners = [sample, sample + 1, above + 1, above];
        let values = corners.map(|corner| field.distance_m[corner]);
        Self { values, edges: [2 * sample, 2 * (sample + 1) + 1, 2 * above, 2 * sample + 1] }
    }

    fn passages(&self, level_m: f64) -> impl Iterator<Item = (usize, usize)> {
        let high = self.values.map(|value| value >= level_m);
        let entry = move |side: usize| high[side] && !high[(side + 1) % 4];
        let exit = move |side: usize| !high[side] && high[(side + 1) % 4];
        let middle_is_high = self.values.iter().sum::<f64>() / 4.0 >= level_m;
        let turns = if middle_is_high { [1, 2, 3] } else { [3, 2, 1] };
        (0..4).filter(move |&side| entry(side)).filter_map(move |side| {
            let across = turns.into_iter().map(|turn| (side + turn) % 4).find(|&other| exit(other));
            across.map(|across| (side, across))
        })
    }
}

fn crossing(field: &DistanceField, level_m: f64, edge: usize) -> Point {
    let (sample, goes_up) = (edge / 2, edge % 2 == 1);
    let (column, row) = (sample % field.columns, sample / field.columns);
    let (to_column, to_row) = if goes_up { (column, row + 1) } else { (column + 1, row) };
    let (from_m, to_m) = (field.at(column, row), field.at(to_column, to_row));
    let share = (level_m - from_m) / (to_m - from_m);
    field.place(column, row).lerp(&field.place(to_column, to_row), share)
}
