//! BC Sweep: the planner that the boustrophedon paper compares with.
//!
//! **Problem.** As `boustrophedon`.
//! **Idea.** The cells are entered at one fixed corner each, the lower left one, and left wherever their lanes end. A tour over these
//! corners and the station gives the order: Christofides' algorithm. What it costs to get from the end of one cell to the
//! corner of the next one is not looked at.
//! **Guarantee.** The tour over the corners is at most 1.5 times the shortest one; nothing follows for the plan.
//! **Complexity.** O(n³) for the matching.
//! **Paper.** G. Strimel, M. Veloso: Coverage planning with finite resources. IROS 2014; as compared by the paper of
//! `boustrophedon`: *horizontal* and *vertical* sweep the boustrophedon cells of lanes in that one direction, *hybrid* the
//! cells of the minimum sum of altitudes, each with its own best direction ("the best motion for each cell", "the
//! lower left corners of the cells resulting from our segmentation"). Cells, lanes, ways, and the tour over what is left
//! are those of `boustrophedon`: `bc-sweep-hybrid` differs from it in order and corners alone.
//! **Departures.** Horizontal and vertical are meant along and across the main walls where a map is tilted.

use super::boustrophedon::{Order, Segmentation, cover};
use crate::{Instance, Plan, PlanError, PlanOptions};

/// Lanes along the x axis only.
pub(super) fn plan_horizontal(instance: &Instance<'_>, _options: &PlanOptions) -> Result<Plan, PlanError> {
    cover(instance, Segmentation::Horizontal, Order::Christofides)
}

/// Lanes along the y axis only.
pub(super) fn plan_vertical(instance: &Instance<'_>, _options: &PlanOptions) -> Result<Plan, PlanError> {
    cover(instance, Segmentation::Vertical, Order::Christofides)
}

/// Each cell in its best direction.
pub(super) fn plan_hybrid(instance: &Instance<'_>, _options: &PlanOptions) -> Result<Plan, PlanError> {
    cover(instance, Segmentation::MinimumSumOfAltitudes, Order::Christofides)
}
