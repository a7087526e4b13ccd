//! Exact distances from places to the blocked squares of a map.
//!
//! The distance to a square is that of two gaps, one along the column and one along the row. Each row of places looks up
//! the gap to the next blocked square in every column of the map, then each place looks sideways until the columns are
//! farther away than the best it has found. O(places × squares within the largest distance), far less near walls.

use terrain::{Floor, GridMap, Lattice};

/// Row-major by place: distance to the nearest blocked square, at most `most_m`; infinite without a map.
pub(super) fn clearances_m(floor: &Floor, places: &Lattice, most_m: f64) -> Vec<f32> {
    let Some(map) = floor.map() else { return vec![f32::INFINITY; places.len()] };
    let mut columns = Columns::new(map);
    let mut clearance = Vec::with_capacity(places.len());
    let mut gaps_m = vec![0.0; map.columns() as usize + 2];
    for row in 0..places.rows {
        let y_m = (f64::from(row) + 0.5) * places.cell_m;
        columns.gaps_m(y_m, &mut gaps_m);
        for column in 0..places.columns {
            let x_m = (f64::from(column) + 0.5) * places.cell_m;
            clearance.push(nearest_m(&gaps_m, x_m, map.resolution_m(), most_m) as f32);
        }
    }
    clearance
}

/// `gaps_m[0]` and the last are the columns just outside, which are blocked.
fn nearest_m(gaps_m: &[f64], x_m: f64, square_m: f64, most_m: f64) -> f64 {
    let own = ((x_m / square_m).floor() as i64 + 1).clamp(0, gaps_m.len() as i64 - 1);
    let near_m = most_m.min(gaps_m[own as usize]);
    // Squares of distances: a root is drawn only in the end.
    let mut best = near_m * near_m;
    for away in 1.. {
        let right_m = (own + away - 1) as f64 * square_m - x_m;
        let left_m = x_m - (own - away) as f64 * square_m;
        let mut is_near = false;
        for (column, gap_m) in [(own + away, right_m), (own - away, left_m)] {
            let gap_m = gap_m.max(0.0);
            if gap_m * gap_m < best && column >= 0 && column < gaps_m.len() as i64 {
                is_near = true;
                let other_m = gaps_m[column as usize];
                best = best.min(gap_m * gap_m + other_m * other_m);
            }
        }
        if !is_near {
            break;
        }
    }
    if best < near_m * near_m { best.sqrt() } else { near_m }
}

/// For each column of a map, the blocked squares next to a height that only grows.
struct Columns<'a> {
    map: &'a GridMap,
    /// Row of the last blocked square that begins at or below the height; -1 is below the map.
    below: Vec<i64>,
    /// Row of the first one that begins above it.
    above: Vec<i64>,
}

impl<'a> Columns<'a> {
    fn new(map: &'a GridMap) -> Self {
        let columns = map.columns() as usize;
        let mut new = Self { map, below: vec![-1; columns], above: vec![-1; columns] };
        for column in 0..columns {
            new.above[column] = new.next_blocked(column, 0);
        }
        new
    }

    fn next_blocked(&self, column: usize, from: i64) -> i64 {
        let rows = i64::from(self.map.rows());
        (from..rows).find(|&row| !self.map.is_free(column as i64, row)).unwrap_or(rows)
    }

    fn gaps_m(&mut self, y_m: f64, gaps_m: &mut [f64]) {
        let square_m = self.map.resolution_m();
        gaps_m.fill(0.0);
        for column in 0..self.below.len() {
            while self.above[column] as f64 * square_m <= y_m {
                self.below[column] = self.above[column];
                if self.below[column] >= i64::from(self.map.rows()) {
                    self.above[column] = i64::MAX / 2;
                } else {
                    self.above[column] = self.next_blocked(column, self.below[column] + 1);
                }
            }
            let to_below_m = y_m - (self.below[column] + 1) as f64 * square_m;
            let to_above_m = self.above[column] as f64 * square_m - y_m;
            let inside = self.below[column] >= i64::from(self.map.rows());
            gaps_m[column + 1] = if inside { 0.0 } else { to_below_m.min(to_above_m).max(0.0) };
        }
    }
}
