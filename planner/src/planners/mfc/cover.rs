//! Rooted tree covers for one bound after another.

use super::{
    bounds::Bounds,
    matching::{Offer, assign},
    reach::Reach,
    splitting::{Piece, split_early, split_late},
};
use crate::{
    Instance,
    block_trees::{Block, Blocks, Forest, Pricing},
};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use std::{
    cmp::Reverse,
    collections::{BTreeMap, BinaryHeap, VecDeque},
};

/// How equal edges are ordered, and with it the shape of the trees and how they are split.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Growth {
    /// Short bushy trees; split late, into few large pieces.
    BreadthFirst,
    /// Any minimum spanning tree; split early, into pieces hardly heavier than the bound.
    ByChance,
}

/// The spanning trees tried for one unit of effort.
const GROWTHS: [Growth; 5] =
    [Growth::BreadthFirst, Growth::ByChance, Growth::ByChance, Growth::ByChance, Growth::ByChance];
/// Beyond so many blocks one spanning tree has to do.
const LARGE: usize = 20_000;
/// An edge of a tree, from the root away.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Edge {
    pub(super) upper: Block,
    pub(super) lower: Block,
    /// The joint of `upper` that it is.
    pub(super) joint: u8,
    pub(super) weight: f64,
}

/// Looks for the best cover.
pub(super) struct Search<'a> {
    pub(super) blocks: &'a Blocks,
    pricing: &'a Pricing,
    roots: &'a [Block],
    delays_s: Vec<f64>,
    /// Per block: time of the moves around it alone, seconds.
    alone_s: Vec<f64>,
}

impl<'a> Search<'a> {
    pub(super) fn new(
        instance: &'a Instance<'a>,
        blocks: &'a Blocks,
        pricing: &'a Pricing,
        roots: &'a [Block],
    ) -> Self {
        let delays_s = instance.starts.iter().map(|start| start.available_in_s).collect();
        let alone_s = (0..blocks.len() as Block).map(|block| pricing.seconds(block, 0)).collect();
        Self { blocks, pricing, roots, delays_s, alone_s }
    }

    /// The cover whose slowest walk takes the least time, of all that the bisections on the bound find.
    pub(super) fn best_cover(&self, effort: u32, seed: u64) -> Forest {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let growths = if self.blocks.len() > LARGE { &GROWTHS[..1] } else { &GROWTHS[..] };
        let tries = (0..effort.max(1)).flat_map(|_| growths.iter().copied());
        let covers = tries.map(|growth| self.best_cover_of(&self.spanning_trees(growth, &mut rng), growth));
        let best = covers.min_by(|a, b| a.makespan_s().total_cmp(&b.makespan_s()));
        best.expect("at least one tree is tried")
    }

    fn best_cover_of(&self, trees: &[Vec<Edge>], growth: Growth) -> Forest {
        let weights = trees.iter().flatten().map(|edge| edge.weight);
        let mut bounds = Bounds::new(weights, self.roots.len());
        let mut best = self.cover(trees, growth, bounds.whole()).expect("leftovers need no match");
        while let Some(bound) = bounds.next(best.makespan_s()) {
            let found = self.cover(trees, growth, bound);
            bounds.narrow(bound, found.is_some());
            best = found
                .into_iter()
                .fold(best, |best, found| if found.makespan_s() < best.makespan_s() { found } else { best });
        }
        best
    }

    /// What a block adds to the walk around a tree when it is hung below another one, seconds; never below 0.
    pub(super) fn weight(&self, upper: Block, joint: u8) -> f64 {
        let link = self.blocks.joints[upper as usize][joint as usize];
        let joined_s =
            self.pricing.seconds(upper, 1 << joint) + self.pricing.seconds(link.other, 1 << link.back);
        let apart_s = f64::midpoint(self.alone_s[upper as usize], self.alone_s[link.other as usize]);
        (joined_s - apart_s).max(0.0)
    }

    /// A minimum spanning forest with all roots taken as one (Prim), edges in the order in which they were found.
    /// Branches in which nothing is needed are left out.
    fn spanning_trees(&self, growth: Growth, rng: &mut ChaCha8Rng) -> Vec<Vec<Edge>> {
        let mut tree_of: Vec<Option<usize>> = vec![None; self.blocks.len()];
        let mut heap = BinaryHeap::new();
        let mut seen = 0_u64;
        let mut trees: Vec<Vec<Edge>> = vec![Vec::new(); self.roots.len()];
        let mut look = |heap: &mut BinaryHeap<_>, from: Block, tree: usize| {
            for joint in 0..self.blocks.joints[from as usize].len() as u8 {
                seen += 1;
                let order = match growth {
                    Growth::ByChance => rng.random(),
                    Growth::BreadthFirst => seen,
                };
                heap.push(Reverse((self.weight(from, joint).to_bits(), order, from, joint, tree)));
            }
        };
        for (tree, &root) in self.roots.iter().enumerate() {
            if tree_of[root as usize].is_none() {
                tree_of[root as usize] = Some(tree);
            }
            look(&mut heap, root, tree);
        }
        while let Some(Reverse((bits, _, upper, joint, tree))) = heap.pop() {
            let lower = self.blocks.joints[upper as usize][joint as usize].other;
            if tree_of[lower as usize].is_some() {
                continue;
            }
            tree_of[lower as usize] = Some(tree);
            trees[tree].push(Edge { upper, lower, joint, weight: f64::from_bits(bits) });
            look(&mut heap, lower, tree);
        }
        trees.iter().map(|edges| self.needed(edges)).collect()
    }

    fn needed(&self, edges: &[Edge]) -> Vec<Edge> {
        let mut leads_on = vec![false; self.blocks.len()];
        let mut kept: Vec<Edge> = Vec::new();
        for &edge in edges.iter().rev() {
            if self.blocks.needed[edge.lower as usize] || leads_on[edge.lower as usize] {
                leads_on[edge.upper as usize] = true;
                kept.push(edge);
            }
        }
        kept.reverse();
        kept
    }

    /// Steps 3 to 5 for one bound; `None` when some subtree finds no robot.
    fn cover(&self, trees: &[Vec<Edge>], growth: Growth, bound: f64) -> Option<Forest> {
        let split = match growth {
            Growth::BreadthFirst => split_late,
            Growth::ByChance => split_early,
        };
        let (leftovers, subtrees): (Vec<Piece>, Vec<Vec<Piece>>) =
            trees.iter().zip(self.roots).map(|(edges, &root)| split(root, edges, bound)).unzip();
        let subtrees: Vec<Piece> = subtrees.into_iter().flatten().collect();
        if subtrees.len() > self.roots.len() {
            return None;
        }
        let mut offers = Vec::new();
        let mut paths: BTreeMap<(usize, usize), Vec<Edge>> = BTreeMap::new();
        let mut reach = Reach::new(self, &subtrees);
        for (robot, leftover) in leftovers.iter().enumerate() {
            for (subtree, path) in reach.paths(leftover, bound) {
                let path_weight: f64 = path.iter().map(|edge| edge.weight).sum();
                let weight = leftover.weight + path_weight + subtrees[subtree].weight + self.delays_s[robot];
                offers.push(Offer { subtree, robot, weight });
                paths.insert((subtree, robot), path);
            }
        }
        let robot_of = assign(subtrees.len(), self.roots.len(), &offers)?;
        let mut own: Vec<Vec<Edge>> = leftovers.into_iter().map(|leftover| leftover.edges).collect();
        for (subtree, robot) in robot_of.into_iter().enumerate() {
            own[robot].extend(paths.remove(&(subtree, robot)).into_iter().flatten());
            own[robot].extend(&subtrees[subtree].edges);
        }
        Some(self.forest(&own))
    }

    /// A tree for each robot over the blocks that its edges join; edges that would close a cycle are left out.
    fn forest(&self, own: &[Vec<Edge>]) -> Forest {
        let mut forest = Forest::new(self.blocks, self.pricing, self.roots, &self.delays_s);
        for (tree, edges) in own.iter().enumerate() {
            let mut joints: BTreeMap<Block, Vec<(u8, Block)>> = BTreeMap::new();
            for edge in edges {
                let link = self.blocks.joints[edge.upper as usize][edge.joint as usize];
                joints.entry(edge.upper).or_default().push((edge.joint, edge.lower));
                joints.entry(edge.lower).or_default().push((link.back, edge.upper));
            }
            let mut queue = VecDeque::from([self.roots[tree]]);
            while let Some(at) = queue.pop_front() {
                for &(joint, next) in joints.get(&at).into_iter().flatten() {
                    if forest.member(next, tree as u32).is_none() {
                        forest.add_leaf(self.blocks, self.pricing, tree as u32, at, joint);
                        queue.push_back(next);
                    }
                }
            }
        }
        forest
    }
}
