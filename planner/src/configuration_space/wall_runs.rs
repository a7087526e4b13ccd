//! Where lines along the rows and columns of a map are closed for the body: runs of blocked squares.
//!
//! A run of blocked squares in one row of the map closes, of a line along the rows, what lies nearer to it than the body's
//! radius: one interval. So a line looks at the few rows within a radius of it, and at the runs in them, not at squares.

use terrain::{GridMap, Segment};

/// Beyond any map.
const FAR_M: f64 = 1e9;

/// Runs of blocked squares, begin and end (exclusive), in each row and in each column of a map.
#[derive(Debug, Clone)]
pub(super) struct WallRuns {
    /// Along x by row, along y by column.
    lines: [Vec<Vec<(i64, i64)>>; 2],
    origin: [f64; 2],
    square_m: f64,
    /// Columns and rows.
    size: [i64; 2],
}

impl WallRuns {
    pub(super) fn new(map: &GridMap) -> Self {
        let size = [i64::from(map.columns()), i64::from(map.rows())];
        let along_x = (0..size[1]).map(|y| runs(size[0], |x| !map.is_free(x, y))).collect();
        let mut along_y: Vec<Vec<(i64, i64)>> = vec![Vec::new(); size[0] as usize];
        for y in 0..size[1] {
            for x in (0..size[0]).filter(|&x| !map.is_free(x, y)) {
                match along_y[x as usize].last_mut() {
                    Some(run) if run.1 == y => run.1 += 1,
                    _ => along_y[x as usize].push((y, y + 1)),
                }
            }
        }
        let origin = [map.origin().x, map.origin().y];
        Self { lines: [along_x, along_y], origin, square_m: map.resolution_m(), size }
    }

    /// The parts of a segment along x (axis 0) or y (axis 1) that are nearer than `radius_m` to a blocked square, as
    /// distances from its first end; they may overlap and reach beyond its ends.
    pub(super) fn each_closed(
        &self,
        axis: usize,
        segment: Segment,
        radius_m: f64,
        mut act: impl FnMut(f64, f64),
    ) {
        let (from, to) = (segment.from[axis], segment.to[axis]);
        let aside_m = segment.from[1 - axis] - self.origin[1 - axis];
        let mut close = |low_m: f64, high_m: f64| {
            let (low, high) = (self.origin[axis] + low_m, self.origin[axis] + high_m);
            if from <= to { act(low - from, high - from) } else { act(from - high, from - low) }
        };
        let number = |metres: f64| (metres / self.square_m).floor() as i64;
        let (low_m, high_m) = (from.min(to) - self.origin[axis], from.max(to) - self.origin[axis]);
        for line in number(aside_m - radius_m)..=number(aside_m + radius_m) {
            let begin_m = line as f64 * self.square_m;
            let gap_m = (begin_m - aside_m).max(aside_m - begin_m - self.square_m).max(0.0);
            if gap_m >= radius_m - 1e-9 {
                continue;
            }
            let reach_m = (radius_m * radius_m - gap_m * gap_m).sqrt();
            // All around the map is blocked.
            if line < 0 || line >= self.size[1 - axis] {
                close(-FAR_M, FAR_M);
                continue;
            }
            close(-FAR_M, reach_m);
            close(self.size[axis] as f64 * self.square_m - reach_m, FAR_M);
            let runs = &self.lines[axis][line as usize];
            let first = runs.partition_point(|run| run.1 as f64 * self.square_m + reach_m < low_m);
            for &(begin, end) in &runs[first..] {
                let (begin_m, end_m) = (begin as f64 * self.square_m, end as f64 * self.square_m);
                if begin_m - reach_m > high_m {
                    break;
                }
                close(begin_m - reach_m, end_m + reach_m);
            }
        }
    }
}

fn runs(length: i64, is_blocked: impl Fn(i64) -> bool) -> Vec<(i64, i64)> {
    let mut runs: Vec<(i64, i64)> = Vec::new();
    for place in (0..length).filter(|&place| is_blocked(place)) {
        match runs.last_mut() {
            Some(run) if run.1 == place => run.1 += 1,
            _ => runs.push((place, place + 1)),
        }
    }
    runs
}
