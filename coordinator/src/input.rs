//! What can happen to the coordinator.

use crate::ChosenBreak;
use planner::{PlanError, VerifiedPlan};
use protocol::v1;

/// One thing that happened.
#[derive(Debug, Clone)]
pub enum Input {
    /// A liveliness token appeared: the robot's process has a session.
    Alive {
        /// The robot.
        robot: String,
        /// The start of its agent.
        boot_id: u64,
    },
    /// A liveliness token disappeared: process dead, or link gone for longer than zenoh's lease.
    Gone {
        /// The robot.
        robot: String,
        /// The start of its agent.
        boot_id: u64,
    },
    /// A robot says what it is.
    Factsheet(Box<v1::Factsheet>),
    /// A robot comes or goes in good order.
    Connection(v1::Connection),
    /// A robot says how it is, and asks for its lease.
    State(Box<v1::State>),
    /// The planner answered.
    Planned {
        /// The request it answers.
        revision: u64,
        /// The plan, or why there is none.
        result: Result<VerifiedPlan, PlanError>,
        /// How long planning took, seconds.
        planning_s: f64,
    },
    /// It was chosen where the routes of a plan are broken off to charge.
    BrokenOff {
        /// The plan.
        revision: u64,
        /// Where.
        breaks: Vec<ChosenBreak>,
    },
    /// A person asked for something.
    Operator(v1::OperatorCommand),
    /// The time asked for by `next_wakeup` has come.
    Woken,
}
