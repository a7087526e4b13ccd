//! MFC: multi-robot forest coverage.
//!
//! **Problem.** As `tmstc-star`, for robots that may start anywhere, also all in one place.
//! **Idea.** A rooted tree cover: one tree per robot, the heaviest as light as possible. For a bound B, grow one tree
//! from each robot (a minimum spanning tree with all roots taken as one), split each tree into subtrees of weight B to
//! 2 B and a lighter leftover at the root (`mfc/splitting.rs`), and match each subtree to a robot whose leftover is at
//! most B away (`mfc/matching.rs`). Bisect on B. Each robot drives around leftover, subtree and the path between them.
//! **Guarantee.** The heaviest tree weighs at most four times the lightest possible, so the time in moves is at most eight times
//! the best one plus a constant (theorem 3). Never worse than `stc` (theorem 2).
//! **Complexity.** O(log(n w)) bounds, each O(n log n) for the trees and O(k n log n) for distances within B, and a matching of at
//! most k subtrees per probe of the second improvement.
//! **Paper.** X. Zheng, S. Jain, S. Koenig, D. Kempe: Multi-robot forest coverage. IEEE/RSJ International Conference on Intelligent
//! Robots and Systems (IROS), 2005; the cover is by G. Even, N. Garg, J. Könemann, R. Ravi, A. Sinha: Min-max tree covers of
//! graphs. Operations Research Letters 32(4), 2004.
//! **Departures.** Both improvements are there: of all covers found during the bisection the best one counts, by the
//! time of the walks, turns included; and B′, the largest total weight that the matching may make, is as small as can
//! be. Bounds are multiples of a part of an even share, closer only where the guarantee needs it (`mfc/bounds.rs`). Blocks
//! may be partly open, weights count. The paper leaves open how ties between equal edges are broken, and Even and others
//! which subtree is split off first. Five minimum spanning trees are tried: one breadth first, split late; four by
//! chance, split early. Where one robot alone, as by `stc`, takes less time, that is the answer: with turns, delays and
//! ragged blocks theorem 2 does not hold by itself.

mod bounds;
mod cover;
mod matching;
mod reach;
mod splitting;

use super::stc;
use crate::{
    Instance, Plan, PlanError, PlanOptions,
    block_trees::{Blocks, Pricing, roots, routes},
    division::makespan_s,
};
use cover::Search;

/// Plans.
pub(super) fn plan(instance: &Instance<'_>, options: &PlanOptions) -> Result<Plan, PlanError> {
    let blocks = Blocks::new(instance);
    let pricing = Pricing::new(instance, &blocks);
    let roots = roots(instance, &blocks)?;
    let forest = Search::new(instance, &blocks, &pricing, &roots).best_cover(options.effort, options.seed);
    let covered = routes(instance, &blocks, &forest, &roots);
    let single = stc::plan(instance, options)?;
    let better = makespan_s(instance, &single) < makespan_s(instance, &covered);
    Ok(if better { single } else { covered })
}
