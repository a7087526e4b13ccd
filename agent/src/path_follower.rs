//! Follows a line of points: straight runs with a trapezoidal speed profile, gentle bends without stopping, turns in
//! place at corners.
//!
//! ```text
//!   speed │   ╭────────────╮         each tick asks for the highest speed from which the robot can
//!         │  ╱              ╲        still stop at the end of the run with its full braking:
//!         │ ╱                ╲       v² / 2a + (v + v₀) Δt / 2 ≤ distance left
//!         └───────────────────▶ way
//! ```
//!
//! A run goes over all nodes of the base that lie on one line, so a robot only slows down at corners and at the
//! end of its base. While driving, a small turning speed draws it back to the line. Where the base bends gently the
//! run becomes a bend (see `bend.rs`) without a stop.

use crate::{bend::Bend, localisation::Place, order_book::OrderBook};
use terrain::{MotionModel, Point, Vector, angle_between};

/// Time between two setpoints, seconds.
pub(crate) const TICK_S: f64 = 0.02;
/// A node counts as reached within this, metres.
pub(crate) const REACHED_M: f64 = 0.008;
/// Below this speed a robot that is near enough stands, m/s.
pub(crate) const CREEP_M_PER_S: f64 = 0.03;
/// Headings nearer than this need no turn in place, radians.
const STRAIGHT_RAD: f64 = 0.03;
/// A turn in place is done within this, radians.
const TURNED_RAD: f64 = 0.008;
/// Farther than this off its line a standing robot drives to the next node by a line of its own, metres.
const OFF_LINE_M: f64 = 0.03;
/// Nodes no farther than this off the line of a run are driven over by it, metres.
const ON_LINE_M: f64 = 0.01;
/// How strongly heading and sideways errors are corrected, 1/s and 1/(m s).
const HEADING_GAIN: f64 = 2.5;
const SIDE_GAIN: f64 = 3.0;
const CORRECTION_MAX_RAD_PER_S: f64 = 0.5;

/// What the robot is to do until the next tick.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Command {
    pub(crate) speed_m_per_s: f64,
    pub(crate) angular_speed_rad_per_s: f64,
    /// Way that is left until it must stand, metres.
    pub(crate) run_m: f64,
}

#[derive(Debug, Clone, PartialEq, Default)]
enum Motion {
    /// Stands, or is to stand.
    #[default]
    Rest,
    /// Turns in place to this heading.
    Turn(f64),
    /// Drives along a line, from a point in a direction.
    Run { from: Point, along: Vector },
    /// Drives along a line that bends.
    Bend(Box<Bend>),
}

/// The follower.
#[derive(Debug, Clone, Default)]
pub(crate) struct PathFollower {
    motion: Motion,
}

impl PathFollower {
    /// The next command, from where the robot is and how it moves. Passes the nodes that are reached. `stop` asks
    /// for braking wherever it is.
    pub(crate) fn follow(
        &mut self,
        order: &mut OrderBook,
        place: Place,
        moving: Command,
        model: &MotionModel,
        stop: bool,
    ) -> Command {
        self.bend_where_the_base_does(order, model);
        self.pass_nodes(order, place, moving);
        if let Motion::Bend(bend) = &mut self.motion {
            let command = bend.follow(order, place, moving, model, stop);
            if bend.is_done(moving) {
                self.motion = Motion::Rest;
            }
            return command;
        }
        if stop {
            return brake(moving, model);
        }
        if self.motion == Motion::Rest {
            if !is_standing(moving) {
                return brake(moving, model);
            }
            self.begin(order, place);
        }
        match self.motion {
            // The first tick of a bend is spent on seeing that it is one.
            Motion::Rest | Motion::Bend(_) => Command::default(),
            Motion::Turn(heading) => self.turn(heading, place, moving, model),
            Motion::Run { from, along } => self.run(order, place, moving, model, from, along),
        }
    }

    /// A run whose base goes on in a bend becomes one.
    fn bend_where_the_base_does(&mut self, order: &OrderBook, model: &MotionModel) {
        if let Motion::Run { from, along } = self.motion
            && let Some(bend) = Bend::from_run(from, along, order, model)
        {
            self.motion = Motion::Bend(Box::new(bend));
        }
    }

    /// The order was replaced or the robot was pushed: whatever it does is ended first.
    pub(crate) fn reset(&mut self) {
        self.motion = Motion::Rest;
    }

    fn pass_nodes(&self, order: &mut OrderBook, place: Place, moving: Command) {
        while order.has_base() {
            let Some(next) = order.base().nth(1).map(|node| node.point) else { return };
            let to = next - place.point();
            let behind = match &self.motion {
                // What lies to the side of the line is not reached by driving past it.
                Motion::Run { from, along } => to.dot(along) <= REACHED_M && is_on_line(next, *from, *along),
                Motion::Bend(_) => return, // it passes its nodes itself
                Motion::Rest | Motion::Turn(_) => false,
            };
            let at_rest = to.norm() <= 2.0 * REACHED_M && moving.speed_m_per_s.abs() < CREEP_M_PER_S;
            if !(behind && to.norm() < 0.1 || at_rest) {
                return;
            }
            order.pass_next();
        }
    }

    /// From standstill: turn towards the next node, or drive.
    fn begin(&mut self, order: &OrderBook, place: Place) {
        let mut base = order.base();
        let (Some(last), Some(next)) = (base.next(), base.next()) else { return };
        let line = next.point - last.point;
        let from_here = next.point - place.point();
        let off_line_m = if line.norm() > 1e-6 {
            (line.normalize().perp(&(place.point() - last.point))).abs()
        } else {
            f64::INFINITY
        };
        let (from, along) = if off_line_m <= OFF_LINE_M && line.dot(&from_here) > 0.0 {
            (last.point, line)
        } else {
            (place.point(), from_here)
        };
        if along.norm() < 1e-6 {
            return;
        }
        let along = along.normalize();
        let heading = along.y.atan2(along.x);
        self.motion = if angle_between(place.theta, heading).abs() > STRAIGHT_RAD {
            Motion::Turn(heading)
        } else {
            Motion::Run { from, along }
        };
    }

    fn turn(&mut self, heading: f64, place: Place, moving: Command, model: &MotionModel) -> Command {
        let left = angle_between(place.theta, heading);
        let turning = moving.angular_speed_rad_per_s;
        let acceleration = model.angular_acceleration_rad_per_s2.min(50.0);
        if left.abs() < TURNED_RAD && turning.abs() < 2.0 * acceleration * TICK_S {
            self.motion = Motion::Rest;
            return Command::default();
        }
        let toward = left.signum();
        let speed = fastest(left.abs(), turning * toward, model.angular_speed_rad_per_s, acceleration);
        Command { angular_speed_rad_per_s: speed * toward, ..Command::default() }
    }

    fn run(
        &mut self,
        order: &OrderBook,
        place: Place,
        moving: Command,
        model: &MotionModel,
        from: Point,
        along: Vector,
    ) -> Command {
        let here = place.point() - from;
        let left_m = run_end(order, from, along) - here.dot(&along);
        let ended = left_m <= REACHED_M && moving.speed_m_per_s < CREEP_M_PER_S || left_m < -0.1;
        if ended {
            self.motion = Motion::Rest;
            return brake(moving, model);
        }
        let heading_error = angle_between(along.y.atan2(along.x), place.theta);
        if heading_error.abs() > 0.5 {
            self.motion = Motion::Rest;
            return brake(moving, model);
        }
        let speed = fastest(left_m, moving.speed_m_per_s, model.speed_m_per_s, model.acceleration_m_per_s2);
        let side_m = along.perp(&here);
        let near = (moving.speed_m_per_s / 0.2).clamp(0.0, 1.0);
        let correction = -(HEADING_GAIN * heading_error + SIDE_GAIN * side_m * near);
        Command {
            speed_m_per_s: speed,
            angular_speed_rad_per_s: correction.clamp(-CORRECTION_MAX_RAD_PER_S, CORRECTION_MAX_RAD_PER_S),
            run_m: left_m,
        }
    }
}

/// Whether a place lies on the line of a run.
pub(crate) fn is_on_line(place: Point, from: Point, along: Vector) -> bool {
    along.perp(&(place - from)).abs() <= ON_LINE_M
}

/// How far along a line the base goes straight on, metres from its beginning.
fn run_end(order: &OrderBook, from: Point, along: Vector) -> f64 {
    let mut end = f64::NEG_INFINITY;
    for node in order.base() {
        let to = node.point - from;
        let distance = to.dot(&along);
        if !is_on_line(node.point, from, along) || distance < end - 1e-9 {
            break;
        }
        end = distance;
    }
    if end == f64::NEG_INFINITY {
        // A line of its own to the next node.
        end = order.base().nth(1).map_or(0.0, |node| (node.point - from).dot(&along));
    }
    end
}

/// The highest speed for the next tick from which `distance` still suffices to stop.
pub(crate) fn fastest(distance: f64, speed: f64, speed_max: f64, acceleration: f64) -> f64 {
    if distance <= 0.0 {
        return 0.0;
    }
    let half = acceleration * TICK_S / 2.0;
    let under = half * half + 2.0 * acceleration * (distance - speed * TICK_S / 2.0);
    let stoppable = if under > 0.0 { (under.sqrt() - half).max(0.0) } else { 0.0 };
    stoppable.min(speed_max).min(speed + acceleration * TICK_S).max(speed - acceleration * TICK_S).max(0.0)
}

fn brake(moving: Command, model: &MotionModel) -> Command {
    let slower = |speed: f64, by: f64| speed.signum() * (speed.abs() - by).max(0.0);
    let speed_m_per_s = slower(moving.speed_m_per_s, model.acceleration_m_per_s2 * TICK_S);
    Command {
        speed_m_per_s,
        angular_speed_rad_per_s: slower(
            moving.angular_speed_rad_per_s,
            model.angular_acceleration_rad_per_s2.min(50.0) * TICK_S,
        ),
        run_m: model.stopping_distance_m(speed_m_per_s),
    }
}

fn is_standing(moving: Command) -> bool {
    moving.speed_m_per_s.abs() < 0.01 && moving.angular_speed_rad_per_s.abs() < 0.02
}
