//! The first forest: trees grown from the starts, breadth first, the quickest robot next.

use crate::{
    Instance,
    block_trees::{Block, Blocks, Forest, Pricing, Tree},
};
use std::{
    cmp::Reverse,
    collections::{BinaryHeap, VecDeque},
};

/// Trees that hold every block that can be reached.
pub(super) fn grow(instance: &Instance<'_>, blocks: &Blocks, pricing: &Pricing, roots: &[Block]) -> Forest {
    let delays_s: Vec<f64> = instance.starts.iter().map(|start| start.available_in_s).collect();
    let mut forest = Forest::new(blocks, pricing, roots, &delays_s);
    let mut rims: Vec<VecDeque<(Block, u8)>> =
        roots.iter().map(|&root| joints(blocks, root).collect()).collect();
    // Positive floats compare as their bits do.
    let turn = |forest: &Forest, tree: usize| Reverse((forest.cost_s[tree].max(0.0).to_bits(), tree));
    let mut turns: BinaryHeap<_> = (0..roots.len()).map(|tree| turn(&forest, tree)).collect();
    while let Some(Reverse((_, tree))) = turns.pop() {
        while let Some((under, joint)) = rims[tree].pop_front() {
            let other = blocks.joints[under as usize][joint as usize].other;
            if forest.members(other).is_empty() {
                forest.add_leaf(blocks, pricing, tree as Tree, under, joint);
                rims[tree].extend(joints(blocks, other));
                turns.push(turn(&forest, tree));
                break;
            }
        }
    }
    forest
}

fn joints(blocks: &Blocks, block: Block) -> impl Iterator<Item = (Block, u8)> + '_ {
    (0..blocks.joints[block as usize].len()).map(move |joint| (block, joint as u8))
}
