//! Forest search: one tree per robot, grown around it, balanced by annealing.
//!
//! **Problem.** As `tmstc-star`: the slowest robot should be done as early as possible, turns counted.
//! **Idea.** A division of one walk sends each robot to its piece and back. Here each robot has a tree of blocks of its own
//! that holds its start, and drives around it: no way to the work, none back. Trees are grown from the starts, the
//! quickest robot first; then branches change hands at random, and simulated annealing on a high power mean of the
//! robots' times keeps what helps. Passages that several robots need belong to several trees.
//! **Guarantee.** Every block belongs to some tree at any time: an answer after any number of steps covers everything. None
//! on quality; the annealing keeps the best forest it has seen.
//! **Complexity.** O(n) for growing; each proposal looks at one branch of at most 150 blocks, and changes the
//! prices of a few. `effort` × O(n) proposals for n blocks.
//! **Paper.** None: ours. The objective and the moves follow what was learnt from local search on forests of LS-MCPP
//! (J. Tang, Z. Mao, H. Ma: Large-scale multirobot coverage path planning on grids with path deconfliction. IEEE
//! Transactions on Robotics 41, 2025), which keeps sets of cells and judges the slowest robot alone.

mod annealing;
mod growth;
mod straightening;

use crate::{
    Instance, Plan, PlanError, PlanOptions,
    block_trees::{Blocks, Pricing, roots, routes},
};
use annealing::Search;

/// Plans.
pub(super) fn plan(instance: &Instance<'_>, options: &PlanOptions) -> Result<Plan, PlanError> {
    let blocks = Blocks::new(instance);
    let pricing = Pricing::new(instance, &blocks);
    let roots = roots(instance, &blocks)?;
    let mut grown = growth::grow(instance, &blocks, &pricing, &roots);
    straightening::straighten(&blocks, &pricing, &mut grown, &roots);
    let move_s = instance.floor.lattice().cell_m / instance.motion.speed_m_per_s;
    let search = Search { blocks: &blocks, pricing: &pricing, roots: &roots, move_s };
    let proposals = u64::from(options.effort) * proposals(blocks.len());
    let forest = search.anneal(grown, proposals, options.seed);
    Ok(routes(instance, &blocks, &forest, &roots))
}

/// Proposals for one unit of effort on a floor of so many blocks: on large floors fewer for each.
fn proposals(blocks: usize) -> u64 {
    let blocks = blocks as u64;
    20_000 + 150 * blocks + (450 * blocks).min(5_000_000)
}
