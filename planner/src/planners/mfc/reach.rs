//! Cheapest paths from a leftover to the subtrees around it.

use super::{
    cover::{Edge, Search},
    splitting::Piece,
};
use crate::block_trees::Block;
use std::{cmp::Reverse, collections::BinaryHeap};

/// How a block was reached.
#[derive(Debug, Clone, Copy)]
struct Step {
    round: u32,
    far: f64,
    by: Option<Edge>,
}

/// Finds paths one leftover after another without clearing its tables in between.
pub(super) struct Reach<'a> {
    search: &'a Search<'a>,
    steps: Vec<Step>,
    round: u32,
    subtrees: usize,
    /// Per block: where its entries in `members` begin.
    begins: Vec<u32>,
    /// Subtrees, block by block.
    members: Vec<u32>,
}

impl<'a> Reach<'a> {
    pub(super) fn new(search: &'a Search<'a>, subtrees: &[Piece]) -> Self {
        let mut pairs: Vec<(Block, u32)> = Vec::new();
        for (number, subtree) in subtrees.iter().enumerate() {
            pairs.extend(subtree.blocks().map(|block| (block, number as u32)));
        }
        pairs.sort_unstable();
        pairs.dedup();
        let blocks = search.blocks.len();
        let mut begins = vec![0_u32; blocks + 1];
        for &(block, _) in &pairs {
            begins[block as usize + 1] += 1;
        }
        for block in 0..blocks {
            begins[block + 1] += begins[block];
        }
        let members = pairs.into_iter().map(|(_, subtree)| subtree).collect();
        let steps = vec![Step { round: 0, far: 0.0, by: None }; blocks];
        Self { search, steps, round: 0, subtrees: subtrees.len(), begins, members }
    }

    /// The cheapest path of weight `bound` at most from a leftover to each subtree within reach (Dijkstra, up to the last
    /// subtree).
    pub(super) fn paths(&mut self, leftover: &Piece, bound: f64) -> Vec<(usize, Vec<Edge>)> {
        self.round += 1;
        let mut found = vec![false; self.subtrees];
        let mut paths = Vec::new();
        let mut heap = BinaryHeap::new();
        for block in leftover.blocks() {
            self.steps[block as usize] = Step { round: self.round, far: 0.0, by: None };
            heap.push(Reverse((0_u64, block)));
        }
        while let Some(Reverse((bits, block))) = heap.pop() {
            let far = f64::from_bits(bits);
            if self.steps[block as usize].far < far {
                continue;
            }
            let (begin, end) =
                (self.begins[block as usize] as usize, self.begins[block as usize + 1] as usize);
            for member in begin..end {
                let subtree = self.members[member] as usize;
                if !std::mem::replace(&mut found[subtree], true) {
                    paths.push((subtree, self.trace(block)));
                }
            }
            if paths.len() == self.subtrees {
                break;
            }
            self.go_on(block, far, bound, &mut heap);
        }
        paths
    }

    fn go_on(&mut self, upper: Block, so_far: f64, bound: f64, heap: &mut BinaryHeap<Reverse<(u64, Block)>>) {
        let joints = &self.search.blocks.joints[upper as usize];
        for (joint, link) in joints.iter().enumerate() {
            let weight = self.search.weight(upper, joint as u8);
            let far = so_far + weight;
            let known = self.steps[link.other as usize];
            if far <= bound && (known.round != self.round || far < known.far) {
                let by = Some(Edge { upper, lower: link.other, joint: joint as u8, weight });
                self.steps[link.other as usize] = Step { round: self.round, far, by };
                heap.push(Reverse((far.to_bits(), link.other)));
            }
        }
    }

    fn trace(&self, to: Block) -> Vec<Edge> {
        let mut path = Vec::new();
        let mut at = to;
        while let Some(edge) = self.steps[at as usize].by {
            path.push(edge);
            at = edge.upper;
        }
        path
    }
}
