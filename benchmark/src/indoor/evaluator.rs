//! Judges a way through a floor plan as the research notes did for all programs alike; knows no planner.
//!
//! - **Ground.** A pixel is feasible when its centre is farther than the body's radius from the centres of all blocked
//!   pixels; only the largest piece counts (steps to eight neighbours). A free pixel within half a tool of a feasible one is
//!   coverable.
//! - **Way.** The body's disc is free where it lies farther than its radius from the centres of blocked pixels (as
//!   [`Robot::radius_to_squares_m`] has it, hence a little farther at their corners). A point at which it is free stays; any
//!   other is moved to the nearest feasible pixel. Two points are joined by a straight line where that is free for the disc,
//!   else by the shortest feasible way, pulled tight.
//! - **Figures.** Length; direction changes above 30° after points on a straight line are left out (tolerance 0.75 pixels);
//!   the part of the coverable area that the tool's disc sweeps, sampled twice as finely as the pixels; overlap = length ×
//!   tool width ÷ covered area − 1; time = length ÷ speed + all turning ÷ turn rate, turns below 30° included.

use std::collections::BinaryHeap;
use terrain::{GridMap, Lattice, Point, Segment, SweptRaster, angle_between};

/// Body, tool and motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Robot {
    pub(crate) radius_m: f64,
    pub(crate) tool_width_m: f64,
    pub(crate) speed_m_per_s: f64,
    pub(crate) turn_rate_rad_per_s: f64,
}

impl Robot {
    /// The radius of the disc that is kept off the squares of blocked pixels, metres. The notes, as costmaps do, take
    /// clearance between the centres of pixels. A pixel holds a disc of half its side: what is farther from its square than
    /// the radius less half a side is farther than the radius from its centre.
    pub(crate) fn radius_to_squares_m(&self, resolution_m: f64) -> f64 {
        self.radius_m - resolution_m / 2.0
    }
}

/// What a way costs and covers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Judged {
    pub(crate) length_m: f64,
    pub(crate) turns: u32,
    pub(crate) rotation_rad: f64,
    /// Share of the coverable area.
    pub(crate) coverage: f64,
    pub(crate) overlap: f64,
    pub(crate) time_s: f64,
    /// Joins between two points that were not free in a straight line.
    pub(crate) detours: u32,
}

/// A floor plan as one robot sees it.
pub(crate) struct Evaluator<'a> {
    map: &'a GridMap,
    robot: Robot,
    feasible: Vec<bool>,
    coverable: Vec<bool>,
}

/// A radius in pixels. Where it is a whole number of them, the rim counts as it does in the notes: if that many times
/// the side of a pixel, as a floating-point number, is no more than the radius.
fn in_pixels(radius_m: f64, resolution_m: f64) -> f64 {
    let pixels = radius_m / resolution_m;
    let whole = pixels.round();
    if (pixels - whole).abs() > 1e-6 {
        pixels
    } else if whole * resolution_m <= radius_m {
        whole + 1e-9
    } else {
        whole - 1e-9
    }
}

impl<'a> Evaluator<'a> {
    pub(crate) fn new(map: &'a GridMap, robot: Robot) -> Self {
        let size = [map.columns() as usize, map.rows() as usize];
        let radius = in_pixels(robot.radius_m, map.resolution_m());
        let blocked: Vec<bool> = pixels(map).map(|(x, y)| !map.is_free(x, y)).collect();
        let near_walls = grown(&blocked, size, radius, true);
        let fits: Vec<bool> = near_walls.iter().map(|near| !near).collect();
        let feasible = largest_piece(&fits, size);
        let tool = in_pixels(robot.tool_width_m / 2.0, map.resolution_m());
        let touched = grown(&feasible, size, tool, false);
        let coverable = touched.iter().zip(&blocked).map(|(touched, blocked)| *touched && !blocked).collect();
        Self { map, robot, feasible, coverable }
    }

    /// What a round tool can touch, square metres.
    pub(crate) fn coverable_m2(&self) -> f64 {
        let pixels = self.coverable.iter().filter(|&&coverable| coverable).count();
        pixels as f64 * self.map.resolution_m() * self.map.resolution_m()
    }

    /// Judges the way along these points.
    pub(crate) fn judge(&self, points: &[Point]) -> Judged {
        let (points, detours) = self.joined(points);
        let length_m = points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum::<f64>();
        let rotation_rad: f64 = turns_rad(&points).map(f64::abs).sum();
        let straightened = without_collinear(&points, 0.75 * self.map.resolution_m());
        let turns = turns_rad(&straightened).filter(|turn| turn.abs() > 30.0_f64.to_radians()).count() as u32;
        let coverage = self.coverage(&points);
        let covered_m2 = coverage * self.coverable_m2();
        Judged {
            length_m,
            turns,
            rotation_rad,
            coverage,
            overlap: length_m * self.robot.tool_width_m / covered_m2 - 1.0,
            time_s: length_m / self.robot.speed_m_per_s + rotation_rad / self.robot.turn_rate_rad_per_s,
            detours,
        }
    }

    fn coverage(&self, points: &[Point]) -> f64 {
        // Eight samples across four pixels.
        let lattice = Lattice {
            origin: self.map.origin(),
            cell_m: 4.0 * self.map.resolution_m(),
            columns: self.map.columns().div_ceil(4),
            rows: self.map.rows().div_ceil(4),
        };
        let mut raster = SweptRaster::new(lattice);
        for pair in points.windows(2) {
            for part in short_parts(Segment::new(pair[0], pair[1]), 4.0 * self.robot.tool_width_m) {
                raster.sweep(part, self.robot.tool_width_m / 2.0 + 1e-9, |_| {});
            }
        }
        let (mut wanted, mut swept) = (0_u64, 0_u64);
        for index in 0..lattice.len() {
            let samples = self.coverable_samples(lattice.cell(index));
            wanted += u64::from(samples.count_ones());
            swept += u64::from((samples & raster.samples(index)).count_ones());
        }
        swept as f64 / wanted as f64
    }

    fn coverable_samples(&self, cell: terrain::Cell) -> u64 {
        (0..64_i64)
            .filter(|bit| {
                let (x, y) = (i64::from(cell.x) * 4 + bit % 8 / 2, i64::from(cell.y) * 4 + bit / 8 / 2);
                self.is_marked(&self.coverable, x, y)
            })
            .fold(0, |samples, bit| samples | 1 << bit)
    }

    fn is_marked(&self, marks: &[bool], x: i64, y: i64) -> bool {
        let (columns, rows) = (i64::from(self.map.columns()), i64::from(self.map.rows()));
        (0..columns).contains(&x) && (0..rows).contains(&y) && marks[(y * columns + x) as usize]
    }

    /// The points with what lies between them where the straight line is not free; how often that was so.
    fn joined(&self, points: &[Point]) -> (Vec<Point>, u32) {
        let points: Vec<Point> = points.iter().map(|&point| self.snapped(point)).collect();
        let mut way: Vec<Point> = points.first().copied().into_iter().collect();
        let mut detours = 0;
        for pair in points.windows(2) {
            if !self.is_free(pair[0], pair[1]) {
                detours += 1;
                way.extend(self.shortest_way(pair[0], pair[1]));
            }
            way.push(pair[1]);
        }
        (way, detours)
    }

    /// Free for the body's disc, with a tangent wall allowed.
    fn is_free(&self, from: Point, to: Point) -> bool {
        let radius_m = self.robot.radius_to_squares_m(self.map.resolution_m());
        self.map.capsule_is_free(Segment::new(from, to), radius_m - 1e-6)
    }

    fn snapped(&self, point: Point) -> Point {
        if self.is_free(point, point) {
            return point;
        }
        let feasible = (0..self.feasible.len()).filter(|&pixel| self.feasible[pixel]);
        feasible
            .map(|pixel| self.center(pixel))
            .min_by(|a, b| (a - point).norm().total_cmp(&(b - point).norm()))
            .unwrap_or(point)
    }

    fn center(&self, pixel: usize) -> Point {
        let columns = self.map.columns() as usize;
        let at = |number: usize| (number as f64 + 0.5) * self.map.resolution_m();
        self.map.origin() + terrain::Vector::new(at(pixel % columns), at(pixel / columns))
    }

    fn pixel_near(&self, point: Point) -> Option<usize> {
        let (x, y) = self.map.square_at(point);
        let near = (-3..=3).flat_map(|dy| (-3..=3).map(move |dx| (x + dx, y + dy)));
        near.filter(|&(x, y)| self.is_marked(&self.feasible, x, y))
            .map(|(x, y)| (y * i64::from(self.map.columns()) + x) as usize)
            .min_by(|&a, &b| (self.center(a) - point).norm().total_cmp(&(self.center(b) - point).norm()))
    }

    /// The points between two points on the shortest feasible way over pixels, pulled tight; none where there is no way.
    fn shortest_way(&self, from: Point, to: Point) -> Vec<Point> {
        let (Some(source), Some(target)) = (self.pixel_near(from), self.pixel_near(to)) else {
            return Vec::new();
        };
        let columns = i64::from(self.map.columns());
        let mut best = vec![u32::MAX; self.feasible.len()];
        let mut before = vec![usize::MAX; self.feasible.len()];
        let mut heap = BinaryHeap::from([(std::cmp::Reverse(0_u32), source)]);
        best[source] = 0;
        while let Some((std::cmp::Reverse(cost), pixel)) = heap.pop() {
            if pixel == target {
                break;
            }
            if cost > best[pixel] {
                continue;
            }
            let (x, y) = (pixel as i64 % columns, pixel as i64 / columns);
            for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
                if !self.is_marked(&self.feasible, x + dx, y + dy) {
                    continue;
                }
                let next = ((y + dy) * columns + x + dx) as usize;
                let cost = cost + if dx != 0 && dy != 0 { 1414 } else { 1000 };
                if cost < best[next] {
                    (best[next], before[next]) = (cost, pixel);
                    heap.push((std::cmp::Reverse(cost), next));
                }
            }
        }
        let mut way = vec![to];
        let mut pixel = target;
        while pixel != usize::MAX {
            way.push(self.center(pixel));
            pixel = before[pixel];
        }
        way.push(from);
        way.reverse();
        let tight = self.pulled_tight(&way);
        tight[1..tight.len() - 1].to_vec()
    }

    fn pulled_tight(&self, points: &[Point]) -> Vec<Point> {
        let mut kept = vec![points[0]];
        let mut at = 0;
        while at + 1 < points.len() {
            let seen = (at + 1..points.len()).rev().find(|&to| self.is_free(points[at], points[to]));
            at = seen.unwrap_or(at + 1);
            kept.push(points[at]);
        }
        kept
    }
}

fn pixels(map: &GridMap) -> impl Iterator<Item = (i64, i64)> + use<> {
    let (columns, rows) = (i64::from(map.columns()), i64::from(map.rows()));
    (0..rows).flat_map(move |y| (0..columns).map(move |x| (x, y)))
}

/// Marks all within `radius` pixels of a mark, between centres; `outside` is what lies around the map.
fn grown(marks: &[bool], [columns, rows]: [usize; 2], radius: f64, outside: bool) -> Vec<bool> {
    let reach = radius.floor() as i64;
    let disc: Vec<(i64, i64)> =
        (-reach..=reach).map(|dy| (dy, (radius * radius - (dy * dy) as f64).sqrt().floor() as i64)).collect();
    let mut grown = vec![false; marks.len()];
    let mut mark_around = |x: i64, y: i64| {
        for &(dy, half) in &disc {
            let row = y + dy;
            if row < 0 || row >= rows as i64 {
                continue;
            }
            let (begin, end) = ((x - half).max(0), (x + half).min(columns as i64 - 1));
            if begin <= end {
                let start = row as usize * columns;
                grown[start + begin as usize..=start + end as usize].fill(true);
            }
        }
    };
    let is_marked = |x: i64, y: i64| {
        if x < 0 || y < 0 || x >= columns as i64 || y >= rows as i64 {
            outside
        } else {
            marks[y as usize * columns + x as usize]
        }
    };
    for (x, y) in (-1..=rows as i64).flat_map(|y| (-1..=columns as i64).map(move |x| (x, y))) {
        let around = [(1, 0), (0, 1), (-1, 0), (0, -1)];
        // What lies inside of marks marks nothing that its border does not; itself it stays.
        if is_marked(x, y) && !around.iter().all(|(dx, dy)| is_marked(x + dx, y + dy)) {
            mark_around(x, y);
        }
    }
    grown.iter().zip(marks).map(|(&grown, &mark)| grown || mark).collect()
}

fn largest_piece(fits: &[bool], [columns, rows]: [usize; 2]) -> Vec<bool> {
    let mut piece = vec![0_u32; fits.len()];
    let mut largest = (0, 0);
    let mut number = 0;
    for first in 0..fits.len() {
        if !fits[first] || piece[first] != 0 {
            continue;
        }
        number += 1;
        piece[first] = number;
        let mut stack = vec![first];
        let mut size = 0;
        while let Some(pixel) = stack.pop() {
            size += 1;
            let (x, y) = ((pixel % columns) as i64, (pixel / columns) as i64);
            for (x, y) in (y - 1..=y + 1).flat_map(|y| (x - 1..=x + 1).map(move |x| (x, y))) {
                let inside = x >= 0 && y >= 0 && x < columns as i64 && y < rows as i64;
                let next = (y * columns as i64 + x) as usize;
                if inside && fits[next] && piece[next] == 0 {
                    piece[next] = number;
                    stack.push(next);
                }
            }
        }
        largest = largest.max((size, number));
    }
    piece.iter().map(|&number| number != 0 && number == largest.1).collect()
}

/// The turns between the straight pieces of a line of points, radians.
fn turns_rad(points: &[Point]) -> impl Iterator<Item = f64> + '_ {
    let steps = points.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| step.norm() > 1e-9);
    let mut before: Option<f64> = None;
    steps.filter_map(move |step| {
        let heading = step.y.atan2(step.x);
        let turn = before.map(|before| angle_between(before, heading));
        before = Some(heading);
        turn
    })
}

/// Leaves out points nearer than a tolerance to the line between those that are kept (Douglas and Peucker).
fn without_collinear(points: &[Point], tolerance_m: f64) -> Vec<Point> {
    let mut keep = vec![false; points.len()];
    if points.is_empty() {
        return Vec::new();
    }
    // A closed way is one line from its start to the farthest point, and another one back.
    let start = points[0];
    let away = |&a: &usize, &b: &usize| (points[a] - start).norm().total_cmp(&(points[b] - start).norm());
    let farthest = (0..points.len()).max_by(away).unwrap_or(0);
    let mut stack = vec![(0, farthest), (farthest, points.len() - 1)];
    while let Some((from, to)) = stack.pop() {
        keep[from] = true;
        keep[to] = true;
        let line = Segment::new(points[from], points[to]);
        let off = |&at: &usize| line.distance_to_point(points[at]);
        let worst = (from + 1..to).max_by(|a, b| off(a).total_cmp(&off(b)));
        if let Some(at) = worst.filter(|at| off(at) > tolerance_m) {
            stack.extend([(from, at), (at, to)]);
        }
    }
    points.iter().zip(&keep).filter(|(_, keep)| **keep).map(|(&point, _)| point).collect()
}

fn short_parts(segment: Segment, part_m: f64) -> impl Iterator<Item = Segment> {
    let slants = (segment.to - segment.from).iter().all(|&along| along.abs() > 1e-9);
    let parts = if slants { (segment.length() / part_m).ceil().max(1.0) } else { 1.0 };
    let at = move |part: u32| segment.from + (segment.to - segment.from) * (f64::from(part) / parts);
    (0..parts as u32).map(move |part| Segment::new(at(part), at(part + 1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROBOT: Robot =
        Robot { radius_m: 0.2, tool_width_m: 0.4, speed_m_per_s: 0.5, turn_rate_rad_per_s: 1.0 };

    fn room() -> GridMap {
        let rows = "........................................\n".repeat(20);
        GridMap::from_drawing(&rows, 0.1).unwrap()
    }

    #[test]
    fn a_straight_way_through_an_empty_room_is_measured() {
        let map = room();
        let evaluator = Evaluator::new(&map, ROBOT);
        let judged = evaluator.judge(&[Point::new(0.4, 1.0), Point::new(3.6, 1.0), Point::new(3.6, 0.5)]);
        assert!((judged.length_m - 3.7).abs() < 1e-9);
        assert_eq!((judged.turns, judged.detours), (1, 0));
        assert!((judged.time_s - (7.4 + std::f64::consts::FRAC_PI_2)).abs() < 1e-9);
        let swept_m2 =
            3.7 * 0.4 + 0.25 * std::f64::consts::PI * 0.16 + 0.2 * 0.2 * (1.0 - std::f64::consts::FRAC_PI_4);
        let covered_m2 = judged.coverage * evaluator.coverable_m2();
        assert!((covered_m2 / swept_m2 - 1.0).abs() < 0.02, "{covered_m2} {swept_m2}");
    }

    #[test]
    fn what_keeps_off_squares_keeps_the_radius_from_their_centres() {
        let mut rows = vec![".".repeat(40); 20];
        rows[6].replace_range(14..15, "#");
        rows[12].replace_range(23..26, "###");
        let map = GridMap::from_drawing(&rows.join("\n"), 0.1).unwrap();
        let evaluator = Evaluator::new(&map, ROBOT);
        let blocked = pixels(&map).enumerate().filter(|&(_, (x, y))| !map.is_free(x, y));
        let centres: Vec<Point> = blocked.map(|(pixel, _)| evaluator.center(pixel)).collect();
        let (mut free, mut tight_m) = (0, f64::INFINITY);
        for (from, to) in (0..60).flat_map(|from| (0..60).map(move |to| (from, to))) {
            let end = |number: i32| 0.3 + 0.0234 * f64::from(number);
            let line = Segment::new(Point::new(0.3, end(from)), Point::new(3.7, end(to)));
            if evaluator.is_free(line.from, line.to) {
                let nearest = centres.iter().map(|&centre| line.distance_to_point(centre));
                tight_m = tight_m.min(nearest.fold(f64::INFINITY, f64::min));
                free += 1;
            }
        }
        assert!(free > 300 && tight_m > ROBOT.radius_m - 1e-5, "{free} {tight_m}");
        // Nor much farther: it is that clearance that is asked for.
        assert!(tight_m < ROBOT.radius_m + 0.01, "{tight_m}");
    }

    #[test]
    fn a_join_through_a_wall_is_driven_around_it() {
        let mut rows = vec![".".repeat(40); 20];
        rows[8..20].iter_mut().for_each(|row| row.replace_range(20..21, "#"));
        let map = GridMap::from_drawing(&rows.join("\n"), 0.1).unwrap();
        let evaluator = Evaluator::new(&map, ROBOT);
        let judged = evaluator.judge(&[Point::new(1.05, 0.55), Point::new(3.05, 0.55)]);
        assert_eq!(judged.detours, 1);
        assert!(judged.length_m > 2.6 && judged.length_m < 2.9, "{judged:?}");
    }

    #[test]
    fn points_on_a_line_are_no_turns() {
        let zigzag: Vec<Point> =
            (0..20).map(|i| Point::new(f64::from(i) * 0.1 + 0.5, 1.0 + 0.03 * f64::from(i % 2))).collect();
        assert_eq!(without_collinear(&zigzag, 0.075).len(), 2);
        assert_eq!(without_collinear(&zigzag, 0.01).len(), 20);
    }
}
