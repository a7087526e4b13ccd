//! Exact distances from places to the blocked squares of a map.
//!
//! The distance to a square is that of two gaps, one along the column and one along the row. Each row of places looks up
//! the gap to the next blocked square in every column of the map. The gap of a column counts from both its edges, as a
//! parabola over the row; the least of all parabolas is found from left to right, each new one taking over from those before
//! it from some place on. O(places + rows of places × columns of the map).
//!
//! After P. Felzenszwalb and D. Huttenlocher: Distance transforms of sampled functions. Theory of Computing 8, 2012, with
//! edges of squares for samples.

use terrain::{Floor, GridMap, Lattice};

/// Row-major by place: distance to the nearest blocked square, at most `most_m`; infinite without a map.
pub(super) fn clearances_m(floor: &Floor, places: &Lattice, most_m: f64) -> Vec<f32> {
    let Some(map) = floor.map() else { return vec![f32::INFINITY; places.len()] };
    let mut columns = Columns::new(map);
    let mut clearance = Vec::with_capacity(places.len());
    let mut gaps_m = vec![0.0; map.columns() as usize + 2];
    let mut envelope = Envelope { square_m: map.resolution_m(), most_m, parabolas: Vec::new() };
    for row in 0..places.rows {
        let y_m = (f64::from(row) + 0.5) * places.cell_m;
        columns.gaps_m(y_m, &mut gaps_m);
        envelope.build(&gaps_m);
        let mut at = 0;
        for column in 0..places.columns {
            let x_m = (f64::from(column) + 0.5) * places.cell_m;
            let own = ((x_m / map.resolution_m()).floor() as usize + 1).min(gaps_m.len() - 1);
            clearance.push(envelope.least_m(x_m, &mut at).min(gaps_m[own]) as f32);
        }
    }
    clearance
}

/// A gap that counts from an edge between two columns.
#[derive(Debug, Clone, Copy)]
struct Parabola {
    x_m: f64,
    gap2: f64,
    /// From where on it is less than all before it.
    from_m: f64,
}

/// The least of the parabolas of a row, from left to right.
struct Envelope {
    square_m: f64,
    most_m: f64,
    parabolas: Vec<Parabola>,
}

impl Envelope {
    /// `gaps_m[0]` and the last are the columns just outside, which are blocked.
    fn build(&mut self, gaps_m: &[f64]) {
        self.parabolas.clear();
        for (edge, pair) in gaps_m.windows(2).enumerate() {
            let gap_m = pair[0].min(pair[1]);
            if gap_m < self.most_m {
                self.push(edge as f64 * self.square_m, gap_m * gap_m);
            }
        }
    }

    fn push(&mut self, x_m: f64, gap2: f64) {
        let mut from_m = f64::NEG_INFINITY;
        while let Some(last) = self.parabolas.last() {
            // Where both are equal.
            let meet_m = ((gap2 - last.gap2) / (x_m - last.x_m) + x_m + last.x_m) / 2.0;
            if meet_m > last.from_m {
                from_m = meet_m;
                break;
            }
            self.parabolas.pop();
        }
        self.parabolas.push(Parabola { x_m, gap2, from_m });
    }

    /// At a place not left of those asked for before; `at` is where the last one was found.
    fn least_m(&self, x_m: f64, at: &mut usize) -> f64 {
        while self.parabolas.get(*at + 1).is_some_and(|next| next.from_m <= x_m) {
            *at += 1;
        }
        let most2 = self.most_m * self.most_m;
        let distance2 = self.parabolas.get(*at).map_or(most2, |found| (x_m - found.x_m).powi(2) + found.gap2);
        if distance2 < most2 { distance2.sqrt() } else { self.most_m }
    }
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
