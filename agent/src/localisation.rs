//! Where the robot is: the last fix, carried on by odometry until the next one.
//!
//! Evidence rests on fixes. Odometry that disagrees with them (wheels that slip, a jump) makes what was swept in
//! between untrusted.

use nalgebra::Vector2;
use protocol::v1;
use terrain::{Point, angle_between};

/// Fixes may disagree with odometry by this much beyond their own bounds, metres.
const JUMP_M: f64 = 0.03;
/// The same for headings, radians.
const JUMP_RAD: f64 = 0.1;
/// Odometry is compared with fixes over this way, metres.
const COMPARED_M: f64 = 0.15;
/// A difference of this share of the way is slip.
const SLIP_SHARE: f64 = 0.25;

/// A pose in the plane.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Place {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) theta: f64,
}

impl Place {
    fn of(pose: &v1::Pose) -> Self {
        Self { x: pose.x_m, y: pose.y_m, theta: pose.theta_rad }
    }

    pub(crate) fn point(self) -> Point {
        Point::new(self.x, self.y)
    }
}

/// What a measurement told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum News {
    /// Odometry only.
    Carried,
    /// A fix came; whether what was driven since the last one can be trusted.
    Fixed {
        /// Fix and odometry agree.
        trusted: bool,
    },
}

/// The estimate.
#[derive(Debug, Clone, Default)]
pub(crate) struct Localisation {
    pub(crate) place: Place,
    pub(crate) deviation_m: f64,
    /// The last fix as it came.
    pub(crate) fix: Place,
    fix_sequence: u64,
    odometry: Place,
    /// Odometry and fix where the comparison for slip began.
    compared: Option<(Place, Place)>,
    wheel_way_m: f64,
    slips: bool,
}

impl Localisation {
    /// Takes in a measurement of the base.
    pub(crate) fn take(&mut self, base: &v1::BaseState) -> News {
        let (Some(odometry), Some(fix)) = (&base.odometry, &base.fix) else { return News::Carried };
        let odometry = Place::of(odometry);
        let first = self.fix_sequence == 0;
        if !first {
            self.carry(odometry);
        }
        self.odometry = odometry;
        if base.fix_sequence == self.fix_sequence {
            return News::Carried;
        }
        self.fix_sequence = base.fix_sequence;
        self.deviation_m = base.fix_deviation_m;
        let fix = Place::of(fix);
        self.fix = fix;
        let agrees = first || self.agrees(fix, base.fix_deviation_m);
        self.correct(fix, first || !agrees);
        self.compare(odometry, fix);
        News::Fixed { trusted: agrees && !self.slips }
    }

    /// Moves the estimate as the wheels say.
    fn carry(&mut self, odometry: Place) {
        let step = Vector2::new(odometry.x - self.odometry.x, odometry.y - self.odometry.y);
        let (sin, cos) = (self.place.theta - self.odometry.theta).sin_cos();
        self.place.x += cos * step.x - sin * step.y;
        self.place.y += sin * step.x + cos * step.y;
        self.place.theta += angle_between(self.odometry.theta, odometry.theta);
        self.wheel_way_m += step.norm();
    }

    fn agrees(&self, fix: Place, deviation_m: f64) -> bool {
        let apart = (fix.x - self.place.x).hypot(fix.y - self.place.y);
        apart < 2.0 * deviation_m + JUMP_M && angle_between(self.place.theta, fix.theta).abs() < JUMP_RAD
    }

    /// Draws the estimate towards a fix; all the way when they disagree.
    fn correct(&mut self, fix: Place, all_the_way: bool) {
        let share = if all_the_way { 1.0 } else { 0.3 };
        self.place.x += share * (fix.x - self.place.x);
        self.place.y += share * (fix.y - self.place.y);
        self.place.theta += share * angle_between(self.place.theta, fix.theta);
    }

    /// Compares the way of the wheels with the way between fixes, over a stretch.
    fn compare(&mut self, odometry: Place, fix: Place) {
        let Some((_, from)) = self.compared else {
            self.compared = Some((odometry, fix));
            self.wheel_way_m = 0.0;
            return;
        };
        if self.wheel_way_m < COMPARED_M {
            return;
        }
        let (before, _) = self.compared.expect("it was just looked at");
        let wheels = (odometry.x - before.x).hypot(odometry.y - before.y);
        let fixes = (fix.x - from.x).hypot(fix.y - from.y);
        self.slips = (wheels - fixes).abs() > SLIP_SHARE * self.wheel_way_m;
        self.compared = Some((odometry, fix));
        self.wheel_way_m = 0.0;
    }

    /// Whether the wheels slip.
    pub(crate) fn slips(&self) -> bool {
        self.slips
    }
}
