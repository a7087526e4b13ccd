//! How far the nearest wall is at least, from anywhere: computed once for a map, so that most questions about
//! walls are answered by one look-up.

use terrain::{GridMap, Point};

/// Per square of the map: how many squares (of the larger of the two axes) lie between it and the nearest wall.
#[derive(Debug, Clone)]
pub(crate) struct Clearance {
    columns: usize,
    rows: usize,
    origin: Point,
    resolution_m: f64,
    squares: Vec<u16>,
}

impl Clearance {
    pub(crate) fn new(map: &GridMap) -> Self {
        let (columns, rows) = (map.columns() as usize, map.rows() as usize);
        let mut squares = vec![u16::MAX; columns * rows];
        for (at, squares) in squares.iter_mut().enumerate() {
            if !map.is_free((at % columns) as i64, (at / columns) as i64) {
                *squares = 0;
            }
        }
        let mut clearance =
            Self { columns, rows, origin: map.origin(), resolution_m: map.resolution_m(), squares };
        clearance.spread();
        clearance
    }

    /// Two passes of the chessboard distance; outside the map everything is wall.
    fn spread(&mut self) {
        for at in 0..self.squares.len() {
            self.lower(at, [(-1, 0), (-1, -1), (0, -1), (1, -1)]);
        }
        for at in (0..self.squares.len()).rev() {
            self.lower(at, [(1, 0), (1, 1), (0, 1), (-1, 1)]);
        }
    }

    fn lower(&mut self, at: usize, neighbours: [(i64, i64); 4]) {
        let (x, y) = ((at % self.columns) as i64, (at / self.columns) as i64);
        let nearest = neighbours.iter().map(|(dx, dy)| self.at(x + dx, y + dy)).min().unwrap_or(0);
        self.squares[at] = self.squares[at].min(nearest.saturating_add(1));
    }

    fn at(&self, x: i64, y: i64) -> u16 {
        let inside = x >= 0 && y >= 0 && x < self.columns as i64 && y < self.rows as i64;
        if inside { self.squares[y as usize * self.columns + x as usize] } else { 0 }
    }

    /// No wall is nearer to `point` than this, metres. Often less than the true distance, never more.
    pub(crate) fn at_least_m(&self, point: Point) -> f64 {
        let (x, y) = self.square_at(point);
        f64::from(self.at(x, y).saturating_sub(1)) * self.resolution_m
    }

    fn square_at(&self, point: Point) -> (i64, i64) {
        (
            ((point.x - self.origin.x) / self.resolution_m).floor() as i64,
            ((point.y - self.origin.y) / self.resolution_m).floor() as i64,
        )
    }

    /// Distance from `eye` along a unit direction to the first wall, metres; `reach_m` when none is nearer.
    /// Walks from square to square, and leaps where walls are far.
    pub(crate) fn ray_m(&self, eye: Point, direction: (f64, f64), reach_m: f64) -> f64 {
        let mut along_m = 0.0;
        while along_m < reach_m {
            let here = Point::new(eye.x + direction.0 * along_m, eye.y + direction.1 * along_m);
            let (x, y) = self.square_at(here);
            match self.at(x, y) {
                0 => return along_m,
                squares @ 3.. => along_m += f64::from(squares - 1) * self.resolution_m,
                _ => along_m += self.to_next_square_m(here, (x, y), direction),
            }
        }
        reach_m
    }

    /// A hair more than the way to the edge of a square.
    fn to_next_square_m(&self, here: Point, (x, y): (i64, i64), direction: (f64, f64)) -> f64 {
        let to_edge = |at: f64, square: i64, origin: f64, towards: f64| {
            if towards == 0.0 {
                return f64::INFINITY;
            }
            let edge = origin + (square + i64::from(towards > 0.0)) as f64 * self.resolution_m;
            (edge - at) / towards
        };
        let to_x = to_edge(here.x, x, self.origin.x, direction.0);
        let to_y = to_edge(here.y, y, self.origin.y, direction.1);
        to_x.min(to_y).max(0.0) + 1e-6
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn room() -> GridMap {
        GridMap::from_drawing(
            "#########\n#.......#\n#.......#\n#...#...#\n#.......#\n#.......#\n#########",
            0.5,
        )
        .unwrap()
    }

    #[test]
    fn clearance_is_never_more_than_the_true_distance() {
        let (map, clearance) = (room(), Clearance::new(&room()));
        for step in 0..400 {
            let point = Point::new(0.5 + 0.1 * f64::from(step % 35), 0.5 + 0.2 * f64::from(step / 35 % 12));
            let least = clearance.at_least_m(point);
            assert!(least == 0.0 || map.disc_is_free(point, least), "{point} {least}");
        }
    }

    #[test]
    fn a_ray_ends_at_the_wall() {
        let clearance = Clearance::new(&room());
        let eye = Point::new(1.25, 0.75);
        assert!((clearance.ray_m(eye, (1.0, 0.0), 9.0) - 2.75).abs() < 1e-5);
        assert!((clearance.ray_m(eye, (-1.0, 0.0), 9.0) - 0.75).abs() < 1e-5);
        assert!((clearance.ray_m(eye, (0.6, 0.8), 9.0) - 1.25).abs() < 1e-5);
        assert!((clearance.ray_m(eye, (1.0, 0.0), 2.0) - 2.0).abs() < 1e-9);
    }
}
