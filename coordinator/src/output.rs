//! What the coordinator asks its driver to do.

use crate::BreakOffRequest;
use planner::{Instance, Mode, PlanError, PlanOptions, Start, Station, VerifiedPlan};
use protocol::v1;
use std::sync::Arc;
use terrain::{Cell, Floor, MotionModel, Point};

/// Share of what is missing that a plan off the lattice must sweep …
const COVERAGE_MIN: f64 = 0.99;
/// … and a repair of lines under way: specks left behind earlier are no reason to wait for a better plan, they are visited
/// in the end.
const WARM_COVERAGE_MIN: f64 = 0.95;

/// One thing to do.
#[derive(Debug, Clone)]
pub enum Output {
    /// Send to a robot.
    Order {
        /// The robot.
        robot: String,
        /// What to send.
        order: v1::Order,
    },
    /// Send to a robot.
    Grant {
        /// The robot.
        robot: String,
        /// What to send.
        grant: v1::Grant,
    },
    /// Send to a robot.
    InstantActions {
        /// The robot.
        robot: String,
        /// What to send.
        actions: v1::InstantActions,
    },
    /// Plan, away from this thread, and answer with `Input::Planned`.
    Plan(Box<PlanRequest>),
    /// Choose, away from this thread, where these routes are broken off to charge, and answer with `Input::BrokenOff`.
    BreakOffs(Box<BreakOffRequest>),
    /// Show to whoever watches, and log.
    Publish(Publication),
    /// Answer an operator.
    Reply(v1::OperatorReply),
}

/// What is shown to those who watch. The last one of a mission is `Result`.
#[derive(Debug, Clone, PartialEq)]
pub enum Publication {
    /// How everything stands; once a second and on events.
    Status(Box<v1::FleetStatus>),
    /// What changed in the ledger.
    Coverage(v1::CoverageDelta),
    /// Why something was decided.
    Decision(v1::Decision),
    /// Something happened that a person wants to read.
    Event(v1::Event),
    /// Who holds which ground; on change.
    Reservations(v1::Reservations),
    /// The mission ended.
    Result(v1::MissionResult),
}

/// An instance that owns its parts, so that it can go to another thread.
#[derive(Debug, Clone)]
pub struct PlanRequest {
    /// Number of the plan.
    pub revision: u64,
    /// The floor.
    pub floor: Arc<Floor>,
    /// Cells to visit.
    pub visit: Vec<bool>,
    /// Cells not to be entered.
    pub blocked: Vec<bool>,
    /// The robots' starts; the coordinator knows which robot each is.
    pub starts: Vec<Start>,
    /// How fast they are.
    pub motion: MotionModel,
    /// When they are done.
    pub mode: Mode,
    /// Chargers.
    pub stations: Vec<Cell>,
    /// Per robot: what it is driving already.
    pub incumbent: Vec<Vec<Cell>>,
    /// Routes that have lost their robot.
    pub orphans: Vec<Vec<Cell>>,
    /// Per robot: the points it still has ahead, where routes leave the lattice.
    pub incumbent_lines: Vec<Vec<Point>>,
    /// Such routes that have lost their robot.
    pub orphan_lines: Vec<Vec<Point>>,
    /// Samples that are swept already, row-major.
    pub swept: Vec<u64>,
    /// How to plan.
    pub options: PlanOptions,
}

impl PlanRequest {
    /// Plans, here and now.
    ///
    /// # Errors
    ///
    /// See [`planner::plan`].
    pub fn run(&self) -> Result<VerifiedPlan, PlanError> {
        planner::plan(&self.instance(), &self.options)
    }

    /// What is to be planned.
    pub fn instance(&self) -> Instance<'_> {
        Instance {
            floor: &self.floor,
            visit: self.visit.clone(),
            blocked: self.blocked.clone(),
            starts: self.starts.clone(),
            motion: self.motion,
            mode: self.mode,
            stations: self.stations.iter().copied().map(Station::at).collect(),
            battery: None,
            weights: None,
            coverage_min: if self.options.warm { WARM_COVERAGE_MIN } else { COVERAGE_MIN },
            incumbent: self.incumbent.clone(),
            orphans: self.orphans.clone(),
            incumbent_lines: self.incumbent_lines.clone(),
            orphan_lines: self.orphan_lines.clone(),
            swept: self.swept.clone(),
        }
    }
}
