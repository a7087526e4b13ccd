//! Trees over a given set of blocks, whatever their shape.

use super::{
    blocks::{Block, Blocks},
    forest::{Member, ROOT, Tree},
    pricing::Pricing,
};
use crate::{
    bricks::{Sided, Tiling, tile},
    disjoint_sets::DisjointSets,
    spanning_graph::Node,
};
use std::{cmp::Reverse, collections::BinaryHeap};
use terrain::Direction;

/// The blocks of one tree, numbered; the root is number 0.
pub(crate) struct Region<'a> {
    pub(crate) blocks: &'a Blocks,
    pub(crate) pricing: &'a Pricing,
    /// Its blocks.
    pub(crate) members: &'a [Block],
    /// Per block: its number, if it is in the region.
    pub(crate) number_of: &'a [Node],
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
        self.members[node as usize]
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
        (self.seconds(&used), used)
    }

    /// Time of the walk around the tree with these joints, seconds.
    pub(crate) fn seconds(&self, used: &[u8]) -> f64 {
        used.iter().zip(self.members).map(|(&used, &block)| self.pricing.seconds(block, used)).sum()
    }

    /// The cheaper of the turn-minimising trees of two minimum tilings: its seconds, and the joints used by each block.
    pub(crate) fn turn_minimising(&self) -> (f64, Vec<u8>) {
        let [a, b] = tile(self).map(|tiling| self.grow(&tiling));
        if b.0 < a.0 { b } else { a }
    }

    /// Kruskal's tree: joints on these sides first, then all others, in the order of the blocks.
    pub(crate) fn kruskal(&self, first: [Direction; 2]) -> Vec<u8> {
        let mut used = vec![0_u8; self.members.len()];
        let mut sets = DisjointSets::new(self.members.len());
        for comes_first in [true, false] {
            for node in 0..self.members.len() as Node {
                for (joint, link) in self.blocks.joints[self.block(node) as usize].iter().enumerate() {
                    let other = self.number_of[link.other as usize];
                    let inside = other != Node::MAX && first.contains(&link.side) == comes_first;
                    if inside && sets.find(node) != sets.find(other) {
                        self.join(&mut used, node, joint as u8, other);
                        sets.unite(node, other);
                    }
                }
            }
        }
        used
    }

    /// A depth first tree from the root that prefers these sides.
    pub(crate) fn depth_first(&self, first: [Direction; 2]) -> Vec<u8> {
        let mut used = vec![0_u8; self.members.len()];
        let mut seen = vec![false; self.members.len()];
        seen[0] = true;
        let mut stack: Vec<(Node, usize)> = vec![(0, 0)];
        while let Some((node, tried)) = stack.pop() {
            let links = &self.blocks.joints[self.block(node) as usize];
            let mut order: Vec<usize> = (0..links.len()).collect();
            order.sort_by_key(|&joint| !first.contains(&links[joint].side));
            let Some(&joint) = order.get(tried) else { continue };
            stack.push((node, tried + 1));
            let other = self.number_of[links[joint].other as usize];
            if other != Node::MAX && !std::mem::replace(&mut seen[other as usize], true) {
                self.join(&mut used, node, joint as u8, other);
                stack.push((other, 0));
            }
        }
        used
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
    pub(crate) fn rooted(&self, tree: Tree, used: &[u8]) -> Vec<Member> {
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
