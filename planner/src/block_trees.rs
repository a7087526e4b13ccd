//! Trees of blocks, several at once, and the walks around them: for planners that give each robot a tree of its own.
//!
//! ```text
//!   Blocks ── Pricing ──▶ Forest ──▶ Walker ──▶ trim ──▶ routes
//!   parts of 2 × 2,       a tree     a closed    what need not
//!   and how they join     per robot  walk each   be driven
//! ```

mod blocks;
mod circuit;
mod forest;
mod pricing;
mod region;
mod trimming;

pub(crate) use blocks::{Block, Blocks};
pub(crate) use circuit::Walker;
pub(crate) use forest::{Forest, Member, ROOT, Tree, up_bit};
pub(crate) use pricing::Pricing;
pub(crate) use region::Region;

use crate::{Instance, Plan, PlanError, Route};

/// The blocks in which robots start.
///
/// # Errors
///
/// [`PlanError::Unreachable`] for a start that is closed.
pub(crate) fn roots(instance: &Instance<'_>, blocks: &Blocks) -> Result<Vec<Block>, PlanError> {
    let root = |cell| blocks.at(instance, cell).ok_or(PlanError::Unreachable(cell));
    instance.starts.iter().map(|start| root(start.cell)).collect()
}

/// The routes around the trees of a forest.
pub(crate) fn routes(instance: &Instance<'_>, blocks: &Blocks, forest: &Forest, roots: &[Block]) -> Plan {
    let mut walker = Walker::new(instance, blocks);
    let walks = (0..roots.len())
        .map(|robot| walker.walk(forest, robot as Tree, roots[robot], instance.starts[robot].cell))
        .collect();
    let walks = trimming::trim(instance, walks);
    let route = |walk: Vec<_>| Route::new(walk.into_iter().map(|cell| instance.center(cell)).collect());
    Plan { routes: walks.into_iter().map(route).collect() }
}
