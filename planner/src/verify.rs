//! Checks any plan, knowing nothing of how it was made: complete, connected, on free ground.

use crate::{Instance, Plan};
use terrain::Cell;
use thiserror::Error;

/// What a plan costs, measured from its points alone.
#[derive(Debug, Clone, PartialEq)]
pub struct Figures {
    /// Time until the last robot is done (its delay before the start included), seconds.
    pub makespan_s: f64,
    /// Per robot: time, seconds.
    pub cost_s: Vec<f64>,
    /// Per robot: way, metres.
    pub length_m: Vec<f64>,
    /// Per robot: turns in place of more than 1°.
    pub turns: Vec<u32>,
    /// Area swept at least once, as a share of the area to be swept, by footprint.
    pub coverage_ratio: f64,
    /// Area swept more than once, as a share of the area swept: cells entered again ÷ cells entered.
    pub overlap_ratio: f64,
}

/// Why a plan does not hold.
#[derive(Debug, Clone, Error, PartialEq)]
pub enum VerifyError {
    /// Not one route per robot.
    #[error("{found} routes for {expected} robots")]
    RouteCount {
        /// Routes in the plan.
        found: usize,
        /// Robots in the instance.
        expected: usize,
    },
    /// A route does not begin where its robot stands.
    #[error("the route of robot {robot} does not begin in its start cell {start}")]
    WrongStart {
        /// Number of the robot.
        robot: usize,
        /// Its start.
        start: Cell,
    },
    /// A cell to visit that no route passes.
    #[error("cell {0} is left out")]
    Gap(Cell),
    /// A line that leaves the ground on which the body fits, or enters a blocked cell.
    #[error("robot {robot} would drive off free ground between point {from} and {to} of its route")]
    OffGround {
        /// Number of the robot.
        robot: usize,
        /// Number of the point before.
        from: usize,
        /// Number of the point after.
        to: usize,
    },
    /// A place that is not a number.
    #[error("point {point} of robot {robot} is not finite")]
    NotFinite {
        /// Number of the robot.
        robot: usize,
        /// Number of the point.
        point: usize,
    },
    /// The mode asks to return, and a route ends elsewhere.
    #[error("robot {0} does not return to its start")]
    NoReturn(usize),
}

/// Checks a plan against its instance and measures it.
///
/// # Errors
///
/// [`VerifyError`]: the first thing found wrong.
pub fn verify(_instance: &Instance<'_>, _plan: &Plan) -> Result<Figures, VerifyError> {
    todo!("planner work")
}
