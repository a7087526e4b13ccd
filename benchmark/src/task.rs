//! One instance with everything it borrows.

use crate::cpu::timed;
use planner::{
    EdgeWeights, Instance, Mode, PlanError, PlanOptions, Start, VerifiedPlan, lower_bound_s, plan,
};
use terrain::{Floor, MotionModel};

/// A floor to cover, and by whom.
#[derive(Debug, Clone)]
pub(crate) struct Task {
    pub(crate) name: String,
    pub(crate) floor: Floor,
    pub(crate) starts: Vec<Start>,
    pub(crate) motion: MotionModel,
    pub(crate) mode: Mode,
    pub(crate) weights: Option<EdgeWeights>,
}

/// A plan and what it took.
#[derive(Debug, Clone)]
pub(crate) struct Outcome {
    pub(crate) plan: VerifiedPlan,
    pub(crate) cpu_s: f64,
}

impl Outcome {
    pub(crate) fn makespan_s(&self) -> f64 {
        self.plan.figures().makespan_s
    }
}

impl Task {
    pub(crate) fn instance(&self) -> Instance<'_> {
        let mut instance = Instance::whole_floor(&self.floor, self.starts.clone(), self.motion, self.mode);
        instance.weights.clone_from(&self.weights);
        instance
    }

    pub(crate) fn lower_bound_s(&self) -> f64 {
        lower_bound_s(&self.instance())
    }

    /// Plans, and verifies: the CPU time of both counts.
    pub(crate) fn plan(&self, planner: &str, effort: u32) -> Result<Outcome, PlanError> {
        let instance = self.instance();
        let options = PlanOptions { planner: planner.to_owned(), effort, ..PlanOptions::default() };
        let (planned, cpu_s) = timed(|| plan(&instance, &options));
        Ok(Outcome { plan: planned?, cpu_s })
    }
}
