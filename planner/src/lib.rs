//! Pure coverage planning: an [`Instance`] in, a [`VerifiedPlan`] out.
//!
//! An instance is *any* state of a mission: cells still to be visited (ragged, in several pieces, with transit
//! through covered ground), robots anywhere, ground that is blocked for now. [`plan`] is the only way in: it
//! runs one planner of the table [`PLANNERS`] and then [`verify()`], which knows nothing of how a plan is made.
//! No clock, no files, no network, no global randomness: same instance and seed, same plan.

mod instance;
mod plan;
pub mod planners;
mod verify;

pub use instance::{Instance, InstanceError, Mode, Start};
pub use plan::{Plan, Route, VerifiedPlan};
pub use planners::{PLANNERS, Planner};
pub use verify::{Figures, VerifyError, verify};

use terrain::Cell;
use thiserror::Error;

/// How to plan.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanOptions {
    /// Name of a row of [`PLANNERS`].
    pub planner: String,
    /// Bound on the work, as a number of improvement steps (0: first answer). Never a clock: same seed, same plan.
    pub effort: u32,
    /// Seed for planners that draw.
    pub seed: u64,
}

impl Default for PlanOptions {
    fn default() -> Self {
        Self { planner: "tmstc-star".to_owned(), effort: 1, seed: 0 }
    }
}

/// Why there is no plan.
#[derive(Debug, Clone, Error, PartialEq)]
pub enum PlanError {
    /// No row of that name.
    #[error("no planner is called `{0}`; there are: {names}", names = planners::names())]
    UnknownPlanner(String),
    /// The instance itself is not sound.
    #[error(transparent)]
    Instance(#[from] InstanceError),
    /// No robot can get to this cell.
    #[error("cell {0} cannot be reached by any robot")]
    Unreachable(Cell),
    /// The planner made a plan that does not stand the test: our bug.
    #[error("the plan of `{planner}` does not hold: {source}")]
    Refuted {
        /// Name of the planner.
        planner: &'static str,
        /// What verify found.
        source: VerifyError,
    },
    /// This planner cannot do what the instance asks, though another may.
    #[error("`{planner}` cannot plan this: {reason}")]
    Unsupported {
        /// Name of the planner.
        planner: &'static str,
        /// What it cannot do.
        reason: String,
    },
}

/// Plans with the planner named in `options`, and verifies what it made.
///
/// # Errors
///
/// [`PlanError`]; an instance in which a cell to visit cannot be reached is refused with that cell.
pub fn plan(instance: &Instance<'_>, options: &PlanOptions) -> Result<VerifiedPlan, PlanError> {
    let planner = planners::by_name(&options.planner)
        .ok_or_else(|| PlanError::UnknownPlanner(options.planner.clone()))?;
    instance.check()?;
    let plan = (planner.plan)(instance, options)?;
    let figures =
        verify(instance, &plan).map_err(|source| PlanError::Refuted { planner: planner.name, source })?;
    Ok(VerifiedPlan::new(plan, figures, planner.name))
}
