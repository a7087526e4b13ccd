//! Trees with few turns: each tree of a forest grown anew over the blocks that it has.
//!
//! As in TMSTC*: the fewest straight bricks first (`bricks.rs`), then the joints that add the least time, looked up
//! again when they come up. What comes out is taken where it is cheaper than what was there.

use crate::{
    block_trees::{Block, Blocks, Forest, Member, Pricing, Region, Tree},
    spanning_graph::Node,
};

/// Straightens every tree that gets cheaper by it.
pub(super) fn straighten(blocks: &Blocks, pricing: &Pricing, forest: &mut Forest, roots: &[Block]) {
    let mut number_of = vec![Node::MAX; blocks.len()];
    let mut members: Vec<(Block, Member)> = Vec::new();
    for (tree, &root) in roots.iter().enumerate() {
        forest.subtree(blocks, tree as Tree, root, usize::MAX, &mut members);
        for (number, &(block, _)) in members.iter().enumerate() {
            number_of[block as usize] = number as Node;
        }
        let own: Vec<Block> = members.iter().map(|&(block, _)| block).collect();
        let region = Region { blocks, pricing, members: &own, number_of: &number_of };
        let before_s: f64 = members.iter().map(|&(block, member)| pricing.seconds(block, member.used)).sum();
        let (after_s, used) = region.turn_minimising();
        if after_s < before_s - 1e-9 {
            forest.replace(pricing, tree as Tree, &members, &region.rooted(tree as Tree, &used));
        }
        for &(block, _) in &members {
            number_of[block as usize] = Node::MAX;
        }
    }
}
