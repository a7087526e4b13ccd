//! Trees with few turns: each tree of a forest grown anew over the blocks that it has.
//!
//! As in TMSTC*: the fewest straight bricks first (`bricks.rs`), then the joints that add the least time, looked up
//! again when they come up. What comes out is taken where it is cheaper than what was there.

use crate::{
    block_trees::{Block, Blocks, Forest, Member, Pricing, ROOT, Tree},
    bricks::{Sided, Tiling, tile},
    disjoint_sets::DisjointSets,
    spanning_graph::Node,
};
use std::{cmp::Reverse, collections::BinaryHeap};
use terrain::Direction;

/// Straightens every tree that gets cheaper by it.
pub(super) fn straighten(blocks: &Blocks, pricing: &Pricing, forest: &mut Forest, roots: &[Block]) {
    let mut number_of = vec![Node::MAX; blocks.len()];
    let mut members: Vec<(Block, Member)> = Vec::new();
    for (tree, &root) in roots.iter().enumerate() {
        forest.subtree(blocks, tree as Tree, root, usize::MAX, &mut members);
        for (number, &(block, _)) in members.iter().enumerate() {
            number_of[block as usize] = number as Node;
        }
        let region = Region { blocks, pricing, members: &members, number_of: &number_of };
        let before_s: f64 = members.iter().map(|&(block, member)| pricing.seconds(block, member.used)).sum();
        let better =
            tile(&region).iter().map(|tiling| region.grow(tiling)).min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, used)) = better.filter(|&(after_s, _)| after_s < before_s - 1e-9) {
            forest.replace(pricing, tree as Tree, &members, &region.rooted(&used));
        }
        for &(block, _) in &members {
            number_of[block as usize] = Node::MAX;
        }
    }
}

/// The blocks of one tree, numbered; the root is number 0.
struct Region<'a> {
    blocks: &'a Blocks,
    pricing: &'a Pricing,
    members: &'a [(Block, Member)],
    /// Per block: its number, if it is in the region.
    number_of: &'a [Node],
}

impl Sided for Region<'_> {
    fn len(&self) -> usize {
        self.members.len()
    }

    fn neighbour(&self, node: Node, side: Direction) -> Option<Node> {
        self.joint(node, side).map(|(_, other)| other)
    }
}

impl Region<'_> {
    fn block(&self, node: Node) -> Block {
        self.members[node as usize].0
    }

    /// The parallel joint on a side, and the number of the block behind it.
    fn joint(&self, node: Node, side: Direction) -> Option<(u8, Node)> {
        let joints = &self.blocks.joints[self.block(node) as usize];
        let joint = joints.iter().position(|joint| joint.side == side && joint.own.1.is_some())?;
        let other = self.number_of[joints[joint].other as usize];
        (other != Node::MAX).then_some((joint as u8, other))
    }

    /// A tree over the region: its seconds, and the joints used by each block.
    fn grow(&self, tiling: &Tiling) -> (f64, Vec<u8>) {
        let mut used = vec![0_u8; self.members.len()];
        let mut sets = DisjointSets::new(self.members.len());
        for &(node, side) in tiling {
            let (joint, other) = self.joint(node, side).expect("bricks are made of parallel joints");
            self.join(&mut used, node, joint, other);
            sets.unite(node, other);
        }
        let mut heap = BinaryHeap::new();
        for node in 0..self.members.len() as Node {
            for (joint, link) in self.blocks.joints[self.block(node) as usize].iter().enumerate() {
                let other = self.number_of[link.other as usize];
                if other != Node::MAX && other > node {
                    heap.push(Reverse((self.added_us(&used, node, joint as u8, other), node, joint as u8)));
                }
            }
        }
        while let Some(Reverse((cost_us, node, joint))) = heap.pop() {
            let link = self.blocks.joints[self.block(node) as usize][joint as usize];
            let other = self.number_of[link.other as usize];
            if sets.find(node) == sets.find(other) {
                continue;
            }
            let now_us = self.added_us(&used, node, joint, other);
            if now_us == cost_us {
                self.join(&mut used, node, joint, other);
                sets.unite(node, other);
            } else {
                heap.push(Reverse((now_us, node, joint)));
            }
        }
        let seconds =
            used.iter().zip(self.members).map(|(&used, &(block, _))| self.pricing.seconds(block, used));
        (seconds.sum(), used)
    }

    fn join(&self, used: &mut [u8], node: Node, joint: u8, other: Node) {
        used[node as usize] |= 1 << joint;
        used[other as usize] |= 1 << self.blocks.joints[self.block(node) as usize][joint as usize].back;
    }

    /// What a joint adds, microseconds: whole numbers can be compared.
    fn added_us(&self, used: &[u8], node: Node, joint: u8, other: Node) -> i64 {
        let back = self.blocks.joints[self.block(node) as usize][joint as usize].back;
        let change_s = |node: Node, joint: u8| {
            let (block, used) = (self.block(node), used[node as usize]);
            self.pricing.seconds(block, used | 1 << joint) - self.pricing.seconds(block, used)
        };
        ((change_s(node, joint) + change_s(other, back)) * 1e6).round() as i64
    }

    /// Members with these joints, hung from the root.
    fn rooted(&self, used: &[u8]) -> Vec<Member> {
        let tree = self.members[0].1.tree;
        let mut rooted: Vec<Member> = used.iter().map(|&used| Member { tree, used, up: ROOT }).collect();
        let mut stack: Vec<Node> = vec![0];
        while let Some(node) = stack.pop() {
            let Member { used, up, .. } = rooted[node as usize];
            for (joint, link) in self.blocks.joints[self.block(node) as usize].iter().enumerate() {
                if used >> joint & 1 == 1 && joint as u8 != up {
                    let other = self.number_of[link.other as usize];
                    rooted[other as usize].up = link.back;
                    stack.push(other);
                }
            }
        }
        rooted
    }
}
