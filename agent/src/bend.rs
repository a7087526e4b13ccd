//! Follows a line that bends gently, without stopping.
//!
//! ```text
//!          o───o
//!        o      ╲ o        the stretch of the base up to its first corner, with what lies close behind
//!   ●───o        ╰──o      ω = v κ (the bend itself) − heading error − distance from the line
//! ```
//!
//! Speed and curvature are the time model's ([`Stretch`]): so slow in a bend that the wheels can turn as fast as it
//! does, and always able to stop at the end of the granted ground. When more is granted the stretch grows. Asked to
//! stop, the robot brakes along the line.

use crate::{
    localisation::Place,
    order_book::OrderBook,
    path_follower::{CREEP_M_PER_S, Command, REACHED_M, TICK_S, fastest, is_on_line},
};
use terrain::{MotionModel, Point, Speeds, Stretch, Vector, angle_between};

/// What lies farther behind than this is forgotten when the stretch grows, metres.
const BEHIND_M: f64 = 1.2;
/// How far ahead of where it was last the robot is looked for, metres.
const SEARCH_M: f64 = 0.3;
/// How strongly heading and sideways errors are corrected, 1/s and 1/(m s).
const HEADING_GAIN: f64 = 3.5;
const SIDE_GAIN: f64 = 5.0;
const CORRECTION_MAX_RAD_PER_S: f64 = 0.6;
/// A heading that is off by more than this ends the bend: the robot was pushed, radians.
const LOST_RAD: f64 = 0.6;
/// Farther off the line than this it was pushed, metres.
const LOST_M: f64 = 0.15;

/// A stretch under way.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Bend {
    /// Where it begins, and the nodes from there to the end of the base; those with a number are yet to be passed.
    path: Vec<(Option<u64>, Point)>,
    stretch: Stretch,
    speeds: Speeds,
    /// Nodes of the stretch that are not passed: number, and way to it, metres.
    ahead: Vec<(u64, f64)>,
    /// Last node of the base that is known here.
    known: u64,
    /// How far along it the robot is, metres.
    at_m: f64,
    lost: bool,
}

impl Bend {
    /// The bend that a run from `from` in the direction `along` leads into; `None` when the base goes straight on, or
    /// turns a corner first.
    pub(crate) fn from_run(
        from: Point,
        along: Vector,
        order: &OrderBook,
        model: &MotionModel,
    ) -> Option<Self> {
        if goes_straight_on(from, order) {
            return None;
        }
        let last = order.base().next()?.point;
        let (mut path, mut at_m) = (vec![(None, from)], 0.0);
        // A line of its own to the next node does not lead over the last one; else the run may have to stop there.
        if (last - from).dot(&along) > 1e-6 && is_on_line(last, from, along) {
            path.push((None, last));
            at_m = (last - from).norm();
        }
        let bend = Self::along(path, order, model, at_m)?;
        (!bend.stretch.is_straight()).then_some(bend)
    }

    /// The stretch over `path` (nodes that are passed) and the base ahead.
    fn along(
        mut path: Vec<(Option<u64>, Point)>,
        order: &OrderBook,
        model: &MotionModel,
        at_m: f64,
    ) -> Option<Self> {
        path.extend(order.base().skip(1).map(|node| (Some(node.sequence), node.point)));
        let points: Vec<Point> = path.iter().map(|&(_, point)| point).collect();
        let (stretch, used) = Stretch::first(&points, true)?;
        let mut way_m = 0.0;
        let mut ahead = Vec::new();
        for at in 0..used {
            way_m += if at == 0 { 0.0 } else { (points[at] - points[at - 1]).norm() };
            ahead.extend(path[at].0.map(|sequence| (sequence, way_m)));
        }
        let speeds = stretch.speeds_when_moving(model);
        Some(Self { path, stretch, speeds, ahead, known: order.released(), at_m, lost: false })
    }

    /// More was granted: the stretch goes on.
    fn grow(&mut self, order: &OrderBook, model: &MotionModel) {
        let passed = order.passed();
        let mut path: Vec<(Option<u64>, Point)> = self
            .path
            .iter()
            .filter(|(sequence, _)| sequence.is_none_or(|sequence| sequence <= passed))
            .map(|&(_, point)| (None, point))
            .collect();
        let mut at_m = self.at_m;
        let length_m: f64 = path.windows(2).map(|pair| (pair[1].1 - pair[0].1).norm()).sum();
        let mut behind_m = length_m;
        while path.len() > 2 && behind_m - (path[1].1 - path[0].1).norm() > BEHIND_M {
            let gone_m = (path[1].1 - path[0].1).norm();
            path.remove(0);
            behind_m -= gone_m;
            at_m -= gone_m;
        }
        match Self::along(path, order, model, at_m) {
            Some(grown) => *self = grown,
            None => self.lost = true,
        }
    }

    /// The next command; passes the nodes that are reached.
    pub(crate) fn follow(
        &mut self,
        order: &mut OrderBook,
        place: Place,
        moving: Command,
        model: &MotionModel,
        stop: bool,
    ) -> Command {
        if order.released() != self.known {
            self.grow(order, model);
        }
        let (at_m, left_m) = self.stretch.project(place.point(), self.at_m - 0.05, SEARCH_M);
        self.at_m = at_m;
        self.pass_nodes(order);
        let to_end_m = self.stretch.length_m() - self.at_m;
        let speed = if stop || self.lost { 0.0 } else { self.speed(to_end_m, moving, model) };
        let slowest = moving.speed_m_per_s - model.acceleration_m_per_s2 * TICK_S;
        let speed_m_per_s = speed.max(slowest).max(0.0);
        let (_, curvature) = self.stretch.bearing(self.at_m + moving.speed_m_per_s * TICK_S);
        let (heading, _) = self.stretch.bearing(self.at_m);
        let heading_error = angle_between(heading, place.theta);
        self.lost |= heading_error.abs() > LOST_RAD || left_m.abs() > LOST_M;
        let near = (moving.speed_m_per_s / 0.2).clamp(0.0, 1.0);
        let correction = -(HEADING_GAIN * near.max(0.5) * heading_error + SIDE_GAIN * left_m * near);
        let steered = correction.clamp(-CORRECTION_MAX_RAD_PER_S, CORRECTION_MAX_RAD_PER_S);
        let standing = speed_m_per_s == 0.0;
        Command {
            speed_m_per_s,
            angular_speed_rad_per_s: if standing { 0.0 } else { speed_m_per_s * curvature + steered },
            run_m: if stop { model.stopping_distance_m(speed_m_per_s) } else { to_end_m },
        }
    }

    fn speed(&self, to_end_m: f64, moving: Command, model: &MotionModel) -> f64 {
        let now = moving.speed_m_per_s;
        let there = self.speeds.at(self.at_m + now * TICK_S);
        fastest(to_end_m, now, model.speed_m_per_s, model.acceleration_m_per_s2).min(there)
    }

    fn pass_nodes(&mut self, order: &mut OrderBook) {
        let reached = self.ahead.iter().take_while(|&&(_, way_m)| way_m <= self.at_m + REACHED_M).count();
        for (sequence, _) in self.ahead.drain(..reached) {
            if order.has_base() && order.passed() < sequence {
                order.pass_next();
            }
        }
    }

    /// Whether it has come to its end, or lost the line.
    pub(crate) fn is_done(&self, moving: Command) -> bool {
        let to_end_m = self.stretch.length_m() - self.at_m;
        let slow = moving.speed_m_per_s < CREEP_M_PER_S;
        self.lost || to_end_m <= REACHED_M && slow || to_end_m < -0.1
    }
}

/// Whether all of the base lies on one line with `from`: the usual case, seen at little cost.
fn goes_straight_on(from: Point, order: &OrderBook) -> bool {
    let Some(next) = order.base().nth(1) else { return true };
    let along = (next.point - from).normalize();
    order.base().skip(2).all(|node| along.perp(&(node.point - from)).abs() < 1e-9)
}
