//! A stretch of a path that is driven from stop to stop without turning in place: a line that bends gently.
//!
//! ```text
//!   stop ──────────╮                     a vertex that turns by at most CORNER_RAD is driven through: its turn is
//!                   ╲  h   h             spread over the way h before and behind it, so that the curvature
//!                    ●───┼───            has no jumps (a hat function for each vertex, all of them summed up).
//!        curvature  ╱╲                   h is the longest at which the line is cut by no more than CUT_M.
//!               ───╯  ╰─────── stop      A sharper vertex is a corner: the robot stops there and turns.
//! ```
//!
//! The speed along it is bounded by the top speed, by the turning speed (`ω = v κ`), by the angular acceleration
//! (`v² dκ/ds`), and by acceleration and braking from stop to stop. Planners price it so, agents drive it so.

use crate::{MotionModel, Point, Vector, angle_between};

/// Vertices that turn by more than this are corners, radians (30°).
pub const CORNER_RAD: f64 = std::f64::consts::FRAC_PI_6;
/// The line driven cuts a bend by at most this, metres.
pub const CUT_M: f64 = 0.008;
/// A turn is spread over at least so much way to either side where that cuts less than allowed, metres …
const SPREAD_M: f64 = 0.15;
/// … and at most over so much.
const SPREAD_MAX_M: f64 = 0.5;
/// Share of the angular acceleration that is planned with: the rest is left for speeding up in a bend and for
/// steering.
const STEERING_SHARE: f64 = 0.7;
/// A turn so near to an end is no bend: there is no room to spread it, metres.
const END_M: f64 = 0.004;
/// Points nearer than this are the same, metres.
const SAME_M: f64 = 1e-9;
/// Turns smaller than this are none, radians.
const STRAIGHT_RAD: f64 = 1e-6;

/// Where the curvature begins to change at another rate.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Knot {
    at_m: f64,
    heading_rad: f64,
    curvature_per_m: f64,
    /// Change of the curvature from here to the next knot, 1/m².
    rate_per_m2: f64,
}

/// A stretch between two stops.
#[derive(Debug, Clone, PartialEq)]
pub struct Stretch {
    points: Vec<Point>,
    /// Way from the beginning to each point, metres.
    at_m: Vec<f64>,
    knots: Vec<Knot>,
}

impl Stretch {
    /// The stretch that begins with the first of `points`; it ends with the first corner, or with the last point.
    /// Returns how many points it uses, too: the last one used is the first of the next stretch. `None` when there
    /// are no two different points. Without `brakes` each turn is a corner.
    pub fn first(points: &[Point], brakes: bool) -> Option<(Self, usize)> {
        let corner_rad = if brakes { CORNER_RAD } else { STRAIGHT_RAD };
        let mut kept: Vec<Point> = vec![*points.first()?];
        let mut used = 1;
        let mut heading: Option<f64> = None;
        for &point in &points[1..] {
            let step = point - kept[kept.len() - 1];
            if step.norm() > SAME_M {
                let towards = heading_of(step);
                if heading.is_some_and(|from| angle_between(from, towards).abs() > corner_rad) {
                    break;
                }
                heading = Some(towards);
                kept.push(point);
            }
            used += 1;
        }
        (kept.len() > 1).then(|| (Self::through(kept), used))
    }

    /// A stretch through all of `points`, none of which is the same as the one before.
    fn through(points: Vec<Point>) -> Self {
        let mut at_m = vec![0.0];
        for pair in points.windows(2) {
            at_m.push(at_m[at_m.len() - 1] + (pair[1] - pair[0]).norm());
        }
        let knots = knots(&points, &at_m);
        Self { points, at_m, knots }
    }

    /// Its length, metres.
    pub fn length_m(&self) -> f64 {
        self.at_m[self.at_m.len() - 1]
    }

    /// Its points.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// Way from the beginning to the point with this number, metres.
    pub fn way_to_m(&self, point: usize) -> f64 {
        self.at_m[point]
    }

    /// Whether it is straight from end to end.
    pub fn is_straight(&self) -> bool {
        self.knots.iter().all(|knot| knot.rate_per_m2 == 0.0 && knot.curvature_per_m == 0.0)
    }

    /// The heading of its first line, radians.
    pub fn heading_at_start_rad(&self) -> f64 {
        heading_of(self.points[1] - self.points[0])
    }

    /// The heading of its last line, radians.
    pub fn heading_at_end_rad(&self) -> f64 {
        let last = self.points.len() - 1;
        heading_of(self.points[last] - self.points[last - 1])
    }

    /// Heading (radians) and curvature (1/m) after so much way.
    pub fn bearing(&self, at_m: f64) -> (f64, f64) {
        let next = self.knots.partition_point(|knot| knot.at_m <= at_m);
        let knot = self.knots[next.saturating_sub(1)];
        let on_m = (at_m - knot.at_m).max(0.0);
        let turned = knot.curvature_per_m * on_m + knot.rate_per_m2 * on_m * on_m / 2.0;
        (knot.heading_rad + turned, knot.curvature_per_m + knot.rate_per_m2 * on_m)
    }

    /// Where along the stretch a place is that is at most `ahead_m` farther on than `from_m`: the way there, and how
    /// far to its left the place lies, metres.
    pub fn project(&self, place: Point, from_m: f64, ahead_m: f64) -> (f64, f64) {
        let mut best = (f64::INFINITY, from_m, 0.0);
        let first = self.at_m.partition_point(|&at| at <= from_m).clamp(1, self.points.len() - 1) - 1;
        for at in first..self.points.len() - 1 {
            if self.at_m[at] > from_m + ahead_m {
                break;
            }
            let line = self.points[at + 1] - self.points[at];
            let length_m = line.norm();
            let along = line / length_m;
            let to = place - self.points[at];
            // The lines at both ends go on beyond them.
            let low = if at == 0 { f64::NEG_INFINITY } else { 0.0 };
            let high = if at + 2 == self.points.len() { f64::INFINITY } else { length_m };
            let on_m = to.dot(&along).clamp(low, high);
            let apart_m = (to - along * on_m).norm();
            if apart_m < best.0 - 1e-9 {
                best = (apart_m, self.at_m[at] + on_m, along.perp(&to));
            }
        }
        (best.1, best.2)
    }

    /// The speeds at which a robot drives it from stop to stop.
    pub fn speeds(&self, model: &MotionModel) -> Speeds {
        let mut speeds = Speeds::up_to_stop(&self.knots, self.length_m(), model);
        speeds.begin_with_stop();
        speeds
    }

    /// The speeds at which a robot that is already moving may drive it, up to the stop at its end.
    pub fn speeds_when_moving(&self, model: &MotionModel) -> Speeds {
        Speeds::up_to_stop(&self.knots, self.length_m(), model)
    }
}

fn heading_of(step: Vector) -> f64 {
    step.y.atan2(step.x)
}

/// Spreads the turn of each vertex, and sums up.
fn knots(points: &[Point], at_m: &[f64]) -> Vec<Knot> {
    let bends = bends(points, at_m);
    let mut changes: Vec<(f64, f64)> = Vec::with_capacity(3 * bends.len() + 1);
    for (number, bend) in bends.iter().enumerate() {
        let spread_m = spread_m(&bends, number, at_m[at_m.len() - 1]);
        let slope = bend.turn_rad / (spread_m * spread_m);
        changes.push((bend.at_m - spread_m, slope));
        changes.push((bend.at_m, -2.0 * slope));
        changes.push((bend.at_m + spread_m, slope));
    }
    changes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut knots = vec![Knot {
        at_m: 0.0,
        heading_rad: heading_behind_end(points, at_m),
        curvature_per_m: 0.0,
        rate_per_m2: 0.0,
    }];
    for (at, change) in changes {
        let last = knots[knots.len() - 1];
        let on_m = (at - last.at_m).max(0.0);
        let rate_per_m2 = last.rate_per_m2 + change;
        if on_m < SAME_M {
            let number = knots.len() - 1;
            knots[number].rate_per_m2 = rate_per_m2;
            continue;
        }
        knots.push(Knot {
            at_m: at,
            heading_rad: last.heading_rad
                + last.curvature_per_m * on_m
                + last.rate_per_m2 * on_m * on_m / 2.0,
            curvature_per_m: last.curvature_per_m + last.rate_per_m2 * on_m,
            rate_per_m2,
        });
    }
    knots
}

/// The heading where the first bend can be.
fn heading_behind_end(points: &[Point], at_m: &[f64]) -> f64 {
    let last = points.len() - 1;
    let at = at_m[1..last].iter().take_while(|&&way_m| way_m < END_M).count();
    heading_of(points[at + 1] - points[at])
}

/// A vertex, and by how much it turns.
#[derive(Debug, Clone, Copy)]
struct Bend {
    at_m: f64,
    turn_rad: f64,
    /// Mean length of the two lines that meet here, metres.
    spacing_m: f64,
}

fn bends(points: &[Point], at_m: &[f64]) -> Vec<Bend> {
    let length_m = at_m[at_m.len() - 1];
    (1..points.len() - 1)
        .filter(|&at| at_m[at] >= END_M && length_m - at_m[at] >= END_M)
        .map(|at| Bend {
            at_m: at_m[at],
            turn_rad: angle_between(
                heading_of(points[at] - points[at - 1]),
                heading_of(points[at + 1] - points[at]),
            ),
            spacing_m: (at_m[at + 1] - at_m[at - 1]) / 2.0,
        })
        .filter(|bend| bend.turn_rad.abs() > STRAIGHT_RAD)
        .collect()
}

/// Over how much way to either side a turn is spread: as much as cuts the line by no more than allowed, with all the
/// turns around it.
fn spread_m(bends: &[Bend], number: usize, length_m: f64) -> f64 {
    let bend = bends[number];
    let room_m = bend.at_m.min(length_m - bend.at_m);
    let mut spread_m = bend.spacing_m.clamp(SPREAD_M, SPREAD_MAX_M).min(room_m);
    for _ in 0..8 {
        let cut_m = cut_m(bends, number, spread_m);
        if cut_m <= CUT_M {
            break;
        }
        spread_m *= (CUT_M / cut_m).max(0.5);
    }
    spread_m.max(0.5 * END_M)
}

/// How far the line is cut at a vertex when all turns are spread over `spread_m` to either side.
fn cut_m(bends: &[Bend], number: usize, spread_m: f64) -> f64 {
    let here_m = bends[number].at_m;
    let share = |bend: &Bend| (spread_m - (bend.at_m - here_m).abs()).max(0.0).powi(3);
    let near = |bend: &&Bend| (bend.at_m - here_m).abs() < spread_m;
    let before = bends[..number].iter().rev().take_while(near);
    let cubes = before.chain(bends[number..].iter().take_while(near));
    let sum: f64 = cubes.map(|bend| bend.turn_rad * share(bend)).sum();
    sum.abs() / (6.0 * spread_m * spread_m)
}

/// The speed along a stretch.
#[derive(Debug, Clone, PartialEq)]
pub struct Speeds {
    /// Way from the beginning, metres.
    at_m: Vec<f64>,
    /// Speed there, m/s.
    speed_m_per_s: Vec<f64>,
    /// Highest speed from there to the next one, m/s.
    cap_m_per_s: Vec<f64>,
    acceleration_m_per_s2: f64,
}

impl Speeds {
    fn up_to_stop(knots: &[Knot], length_m: f64, model: &MotionModel) -> Self {
        let within: Vec<&Knot> = knots.iter().filter(|knot| knot.at_m < length_m).collect();
        let mut at_m: Vec<f64> = within.iter().map(|knot| knot.at_m).collect();
        at_m.push(length_m);
        let cap_m_per_s: Vec<f64> =
            within.iter().zip(&at_m[1..]).map(|(knot, &next_m)| cap_m_per_s(knot, next_m, model)).collect();
        let mut speed_m_per_s = vec![0.0; at_m.len()];
        speed_m_per_s[0] = cap_m_per_s[0];
        for at in 1..at_m.len() - 1 {
            speed_m_per_s[at] = cap_m_per_s[at - 1].min(cap_m_per_s[at]);
        }
        let mut speeds =
            Self { at_m, speed_m_per_s, cap_m_per_s, acceleration_m_per_s2: model.acceleration_m_per_s2 };
        for at in (1..speeds.at_m.len()).rev() {
            speeds.speed_m_per_s[at - 1] =
                speeds.speed_m_per_s[at - 1].min(speeds.reachable_m_per_s(at, at - 1));
        }
        speeds
    }

    fn begin_with_stop(&mut self) {
        self.speed_m_per_s[0] = 0.0;
        for at in 1..self.at_m.len() {
            self.speed_m_per_s[at] = self.speed_m_per_s[at].min(self.reachable_m_per_s(at - 1, at));
        }
    }

    fn reachable_m_per_s(&self, from: usize, to: usize) -> f64 {
        let way_m = (self.at_m[to] - self.at_m[from]).abs();
        (self.speed_m_per_s[from].powi(2) + 2.0 * self.acceleration_m_per_s2 * way_m).sqrt()
    }

    /// Time from stop to stop, seconds.
    pub fn total_s(&self) -> f64 {
        (1..self.at_m.len()).map(|at| self.piece_s(at)).sum()
    }

    /// Time from one knot to the next: up to the highest speed that there is room for, and down again.
    fn piece_s(&self, to: usize) -> f64 {
        let (from_speed, to_speed) = (self.speed_m_per_s[to - 1], self.speed_m_per_s[to]);
        let way_m = self.at_m[to] - self.at_m[to - 1];
        let (a, cap) = (self.acceleration_m_per_s2, self.cap_m_per_s[to - 1]);
        if a.is_infinite() {
            return way_m / cap;
        }
        let peak = (f64::midpoint(from_speed.powi(2), to_speed.powi(2)) + a * way_m).sqrt();
        if peak <= cap {
            return (2.0 * peak - from_speed - to_speed).max(0.0) / a;
        }
        let ramps_m = (2.0 * cap * cap - from_speed.powi(2) - to_speed.powi(2)) / (2.0 * a);
        (2.0 * cap - from_speed - to_speed) / a + (way_m - ramps_m).max(0.0) / cap
    }

    /// The highest speed after so much way from which all that follows can be driven, m/s.
    pub fn at(&self, at_m: f64) -> f64 {
        let at_m = at_m.max(0.0);
        let next = self.at_m.partition_point(|&knot| knot <= at_m).min(self.at_m.len() - 1);
        let left_m = (self.at_m[next] - at_m).max(0.0);
        let to_speed = self.speed_m_per_s[next];
        let stoppable = (to_speed * to_speed + 2.0 * self.acceleration_m_per_s2 * left_m).sqrt();
        stoppable.min(self.cap_m_per_s[next.max(1) - 1])
    }
}

fn cap_m_per_s(knot: &Knot, next_m: f64, model: &MotionModel) -> f64 {
    let curvature_then = knot.curvature_per_m + knot.rate_per_m2 * (next_m - knot.at_m);
    let curvature = knot.curvature_per_m.abs().max(curvature_then.abs());
    let by_turning = model.angular_speed_rad_per_s / curvature;
    let by_steering =
        (STEERING_SHARE * model.angular_acceleration_rad_per_s2 / knot.rate_per_m2.abs()).sqrt();
    let cap = model.speed_m_per_s;
    // Straight, both bounds are no numbers or infinite.
    cap.min(by_turning).min(by_steering)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, TAU};

    const MODEL: MotionModel = MotionModel {
        speed_m_per_s: 1.0,
        acceleration_m_per_s2: 0.8,
        angular_speed_rad_per_s: 1.5,
        angular_acceleration_rad_per_s2: 3.0,
        brakes: true,
    };

    fn circle(radius_m: f64, spacing_m: f64) -> Vec<Point> {
        let count = (TAU * radius_m / spacing_m).ceil() as u32;
        let place = |at: u32| f64::from(at) / f64::from(count) * TAU;
        (0..=count).map(place).map(|a| Point::new(radius_m * a.cos(), radius_m * a.sin())).collect()
    }

    fn whole(points: &[Point]) -> Stretch {
        let (stretch, used) = Stretch::first(points, true).unwrap();
        assert_eq!(used, points.len());
        stretch
    }

    #[test]
    fn a_sampled_circle_has_the_curvature_of_the_circle() {
        for spacing_m in [0.01, 0.05, 0.2] {
            let stretch = whole(&circle(1.0, spacing_m));
            let (_, curvature) = stretch.bearing(0.5 * stretch.length_m());
            assert!((curvature - 1.0).abs() < 0.02, "{curvature}");
            let (start, _) = stretch.bearing(0.0);
            let (end, _) = stretch.bearing(stretch.length_m());
            assert!((end - start - TAU).abs() < 1.5 * spacing_m + 1e-6, "turned by {}", end - start);
        }
    }

    #[test]
    fn a_tight_circle_is_driven_at_the_turning_speed_and_a_wide_one_at_top_speed() {
        let at_mid = |radius_m: f64| {
            let stretch = whole(&circle(radius_m, 0.05));
            stretch.speeds(&MODEL).at(0.5 * stretch.length_m())
        };
        assert!((at_mid(0.4) - 0.6).abs() < 0.02, "{}", at_mid(0.4));
        assert!((at_mid(3.0) - 1.0).abs() < 1e-6, "{}", at_mid(3.0));
    }

    #[test]
    fn a_straight_stretch_takes_the_time_of_a_run() {
        for length_m in [0.3, 1.0, 7.0] {
            let points: Vec<Point> =
                (0..8).map(|at| Point::new(f64::from(at) / 7.0 * length_m, 0.0)).collect();
            let stretch = whole(&points);
            assert!(stretch.is_straight());
            let (run_s, total_s) = (MODEL.run_s(length_m), stretch.speeds(&MODEL).total_s());
            assert!((run_s - total_s).abs() < 1e-9, "{run_s} {total_s}");
        }
    }

    #[test]
    fn a_bend_cuts_its_corner_by_no_more_than_allowed() {
        let bend = |turn: f64| {
            let knee = Point::new(3.0, 0.0);
            vec![Point::origin(), knee, knee + Vector::new(turn.cos(), turn.sin()) * 3.0]
        };
        for turn in [0.1, 0.3, 0.5] {
            let stretch = whole(&bend(turn));
            let mut place = Point::origin();
            let mut nearest_m = f64::INFINITY;
            let step_m = 0.001;
            for at in 0..6000 {
                let (heading, _) = stretch.bearing(f64::from(at) * step_m);
                place += Vector::new(heading.cos(), heading.sin()) * step_m;
                nearest_m = nearest_m.min((place - Point::new(3.0, 0.0)).norm());
            }
            assert!(nearest_m < 1.2 * CUT_M, "{turn}: {nearest_m}");
        }
    }

    #[test]
    fn a_bend_right_behind_the_start_costs_no_time() {
        let line =
            [Point::new(-0.0003, -0.0001), Point::origin(), Point::new(0.5, 0.0), Point::new(1.0, 0.0)];
        let (plain_s, total_s) = (MODEL.run_s(1.0), MODEL.path_s(&line, Some(0.0)));
        let first_turn_s = MODEL.turn_s(0.1_f64.atan2(0.3));
        assert!(total_s < plain_s + first_turn_s + 0.01, "{total_s} s instead of {plain_s} s");
        let backwards: Vec<Point> = line.iter().rev().copied().collect();
        assert!(MODEL.path_s(&backwards, None) < plain_s + 0.01);
    }

    #[test]
    fn a_corner_ends_the_stretch() {
        let points = [Point::origin(), Point::new(1.0, 0.0), Point::new(1.0, 0.0), Point::new(1.0, 1.0)];
        let (stretch, used) = Stretch::first(&points, true).unwrap();
        assert_eq!((stretch.points().len(), used), (2, 3));
        assert!(Stretch::first(&points[1..3], true).is_none());
        assert!((stretch.heading_at_end_rad() - 0.0).abs() < 1e-12);
        let (next, _) = Stretch::first(&points[used - 1..], true).unwrap();
        assert!((next.heading_at_start_rad() - FRAC_PI_2).abs() < 1e-12);
    }

    #[test]
    fn speeds_can_be_followed() {
        let wave: Vec<Point> =
            (0..200).map(|at| Point::new(0.05 * f64::from(at), 0.4 * (0.1 * f64::from(at)).sin())).collect();
        let stretch = whole(&wave);
        let speeds = stretch.speeds_when_moving(&MODEL);
        let step_m = 0.002;
        let steps = (stretch.length_m() / step_m) as u32;
        let mut before = speeds.at(0.0);
        let mut time_s = 0.0;
        for at in 1..steps {
            let at_m = f64::from(at) * step_m;
            let speed = speeds.at(at_m);
            let (_, curvature) = stretch.bearing(at_m);
            assert!(speed * curvature.abs() <= MODEL.angular_speed_rad_per_s + 1e-6);
            let braking = (before * before - speed * speed) / (2.0 * step_m);
            // Down by braking; up is the robot's business.
            assert!(
                braking < MODEL.acceleration_m_per_s2 * 1.02 || before - speed < 0.02,
                "{braking} at {at_m}"
            );
            time_s += step_m / speed.max(0.05);
            before = speed;
        }
        let total_s = stretch.speeds(&MODEL).total_s();
        assert!(time_s < total_s && total_s < time_s + 2.5, "{time_s} {total_s}");
    }

    #[test]
    fn a_place_is_projected_onto_the_line_ahead() {
        let stretch = whole(&circle(1.0, 0.1));
        let place = Point::new(0.0, 0.95);
        let (at_m, left_m) = stretch.project(place, 1.0, 1.5);
        assert!((at_m - FRAC_PI_2).abs() < 0.02, "{at_m}");
        assert!((left_m - 0.05).abs() < 0.003, "{left_m}");
        let (beyond_m, _) = stretch.project(Point::new(1.0, 0.3), stretch.length_m() - 0.2, 1.0);
        assert!(beyond_m > stretch.length_m());
    }
}
