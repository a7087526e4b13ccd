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
//! prices of a few. `effort` × (20,000 + 150 n) proposals for n blocks.
//! **Paper.** None: ours. The objective and the moves follow what was learnt from local search on forests of LS-MCPP
//! (J. Tang, Z. Mao, H. Ma: Large-scale multirobot coverage path planning on grids with path deconfliction. IEEE
//! Transactions on Robotics 41, 2025), which keeps sets of cells and judges the slowest robot alone.

mod annealing;
mod blocks;
mod circuit;
mod forest;
mod growth;
mod pricing;
mod straightening;
mod trimming;

use crate::{Instance, Plan, PlanError, PlanOptions, Route};
use annealing::Search;
use blocks::{Block, Blocks};
use circuit::Walker;
use forest::Tree;
use pricing::Pricing;
use terrain::Cell;

/// Proposals for one unit of effort: at least, and for each block.
const PROPOSALS: (u64, u64) = (20_000, 150);

/// Plans.
#[expect(clippy::unnecessary_wraps, reason = "every planner has this signature")]
pub(super) fn plan(instance: &Instance<'_>, options: &PlanOptions) -> Result<Plan, PlanError> {
    let blocks = Blocks::new(instance);
    let pricing = Pricing::new(instance, &blocks);
    let roots: Vec<Block> = instance
        .starts
        .iter()
        .map(|start| blocks.at(instance, start.cell).expect("a start can be reached from itself"))
        .collect();
    let mut grown = growth::grow(instance, &blocks, &pricing, &roots);
    straightening::straighten(&blocks, &pricing, &mut grown, &roots);
    let move_s = instance.floor.lattice().cell_m / instance.motion.speed_m_per_s;
    let search = Search { blocks: &blocks, pricing: &pricing, roots: &roots, move_s };
    let proposals = u64::from(options.effort) * (PROPOSALS.0 + PROPOSALS.1 * blocks.len() as u64);
    let forest = search.anneal(grown, proposals, options.seed);
    let mut walker = Walker::new(instance, &blocks);
    let walks: Vec<Vec<Cell>> = (0..roots.len())
        .map(|robot| walker.walk(&forest, robot as Tree, roots[robot], instance.starts[robot].cell))
        .collect();
    let walks = trimming::trim(instance, walks);
    let route =
        |walk: Vec<Cell>| Route { points: walk.into_iter().map(|cell| instance.center(cell)).collect() };
    Ok(Plan { routes: walks.into_iter().map(route).collect() })
}
