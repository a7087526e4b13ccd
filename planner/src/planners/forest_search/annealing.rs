//! Simulated annealing over forests.
//!
//! The energy of a forest is Σ (m / p) (c / m)^p over its trees, with c the time of a tree and m the mean time. Near balance
//! its slope is the total time, so overlap and turns go down as well; p grows, and with it the pressure on the slowest.

use super::straightening::straighten;
use crate::block_trees::{Block, Blocks, Forest, Member, Pricing, ROOT, Tree, up_bit};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use std::collections::{BTreeMap, VecDeque};

/// Blocks that may change hands at once: drawn from these.
const SIZES: [usize; 4] = [1, 6, 30, 150];
/// One proposal in so many is a far transfer.
const FAR: u32 = 1_500;
/// Blocks that a far transfer looks at to find the other tree.
const FAR_BLOCKS: usize = 4_000;
/// First and last power of the energy.
const POWERS: [f64; 2] = [20.0, 140.0];
/// First and last temperature, in moves.
const TEMPERATURES: [f64; 2] = [2.0, 0.08];
/// Proposals are drawn from so many neighbouring blocks for as many proposals: what is at hand stays in the cache.
const WINDOW: usize = 8_192;
/// How often the forest is compared with the best one on the way.
const LOOKS: u64 = 50;
/// How often all trees are straightened on the way.
const STRAIGHTENINGS: u64 = 3;
/// Proposals between two looks at the mean time.
const REFRESH: u64 = 512;

/// What stays the same during a search.
pub(super) struct Search<'a> {
    pub(super) blocks: &'a Blocks,
    pub(super) pricing: &'a Pricing,
    /// Where the trees begin.
    pub(super) roots: &'a [Block],
    /// A move at full speed, seconds: the unit of temperatures.
    pub(super) move_s: f64,
}

/// The state of a search.
struct Annealing<'a> {
    search: &'a Search<'a>,
    forest: Forest,
    best: Option<(f64, Forest)>,
    rng: ChaCha8Rng,
    mean_s: f64,
    power: f64,
    temperature_s: f64,
    subtree: Vec<(Block, Member)>,
    /// First of the blocks that proposals are drawn from.
    window: usize,
}

impl Search<'_> {
    /// Improves a forest by so many proposals.
    pub(super) fn anneal(&self, forest: Forest, proposals: u64, seed: u64) -> Forest {
        let mut annealing = Annealing {
            search: self,
            best: None,
            rng: ChaCha8Rng::seed_from_u64(seed),
            mean_s: 1.0,
            power: POWERS[0],
            temperature_s: self.move_s,
            subtree: Vec::new(),
            window: 0,
            forest,
        };
        annealing.keep_best();
        let look = proposals / LOOKS + 1;
        for number in 0..proposals {
            if number % REFRESH == 0 {
                annealing.cool(number as f64 / proposals as f64);
            }
            if number % WINDOW as u64 == 0 {
                annealing.window = annealing.rng.random_range(0..self.blocks.len());
            }
            if STRAIGHTENINGS > 0 && number % (proposals / (STRAIGHTENINGS + 1) + 1) == 0 && number > 0 {
                straighten(self.blocks, self.pricing, &mut annealing.forest, self.roots);
            }
            if number % look == 0 {
                annealing.keep_best();
            }
            annealing.propose();
        }
        annealing.keep_best();
        annealing.best.map_or(annealing.forest, |(_, best)| best)
    }
}

impl Annealing<'_> {
    fn cool(&mut self, progress: f64) {
        let between = |[first, last]: [f64; 2]| first * (last / first).powf(progress);
        self.power = between(POWERS);
        self.temperature_s = between(TEMPERATURES) * self.search.move_s;
        let costs = &self.forest.cost_s;
        self.mean_s = (costs.iter().sum::<f64>() / costs.len() as f64).max(self.search.move_s);
    }

    fn keep_best(&mut self) {
        let makespan_s = self.forest.makespan_s();
        if self.best.as_ref().is_none_or(|&(best_s, _)| makespan_s < best_s - 1e-9) {
            self.best = Some((makespan_s, self.forest.clone()));
        }
    }

    fn energy(&self, cost_s: f64) -> f64 {
        self.mean_s / self.power * (cost_s / self.mean_s).powf(self.power)
    }

    fn accepts(&mut self, energy_change: f64) -> bool {
        energy_change <= 0.0 || self.rng.random::<f64>() < (-energy_change / self.temperature_s).exp()
    }

    fn propose(&mut self) {
        let count = self.search.blocks.len();
        let block = ((self.window + self.rng.random_range(0..count.min(WINDOW))) % count) as Block;
        let members = self.forest.members(block);
        if members.is_empty() {
            return;
        }
        let member = members[self.rng.random_range(0..members.len())];
        if self.rng.random_range(0..FAR) == 0 {
            self.propose_far(block, member);
            return;
        }
        let joints = &self.search.blocks.joints[block as usize];
        if joints.is_empty() {
            return;
        }
        let joint = self.rng.random_range(0..joints.len()) as u8;
        let other = joints[joint as usize].other;
        let members = self.forest.members(other);
        match self.rng.random_range(0..8_u32) {
            0 => self.propose_drop(block, member),
            1 => self.propose_copy(block, member, joint),
            _ if members.is_empty() => self.propose_copy(block, member, joint),
            _ => {
                let under = members[self.rng.random_range(0..members.len())];
                self.propose_transfer(block, member, joint, under);
            }
        }
    }

    /// The block some steps above `block`, below the root.
    fn climb(&mut self, block: Block, member: Member) -> Option<Block> {
        let mut steps =
            if self.rng.random_range(0..2_u32) == 0 { 0 } else { self.rng.random_range(0..12_u32) };
        let mut top = block;
        let mut at = member;
        if at.up == ROOT {
            return None;
        }
        while steps > 0 {
            let (parent, _) = Forest::parent(self.search.blocks, top, at)?;
            let above = self.forest.member(parent, member.tree)?;
            if above.up == ROOT {
                break;
            }
            (top, at) = (parent, above);
            steps -= 1;
        }
        Some(top)
    }

    /// Cuts the subtree below an ancestor of `block` and hangs it, by `block`, below the block behind `joint`.
    fn propose_transfer(&mut self, block: Block, member: Member, joint: u8, under: Member) {
        if member.tree == under.tree && member.used >> joint & 1 == 1 {
            return;
        }
        let Some(top) = self.climb(block, member) else { return };
        let most = SIZES[self.rng.random_range(0..SIZES.len())];
        let mut subtree = std::mem::take(&mut self.subtree);
        let blocks = self.search.blocks;
        if self.forest.subtree(blocks, member.tree, top, most, &mut subtree)
            && self.can_go(
                &subtree,
                blocks.joints[block as usize][joint as usize].other,
                member.tree,
                under.tree,
            )
        {
            let [from_s, to_s] = self.transfer_s(&subtree, member.tree, block, joint, under);
            if self.accepts_change(member.tree, from_s, under.tree, to_s) {
                let pricing = self.search.pricing;
                self.forest.remove(blocks, pricing, member.tree, &subtree);
                self.forest.insert(blocks, pricing, under.tree, &subtree, block, joint);
            }
        }
        self.subtree = subtree;
    }

    /// Within a tree the new parent must lie outside the subtree; another tree must have none of its blocks.
    fn can_go(&self, subtree: &[(Block, Member)], under: Block, from: Tree, to: Tree) -> bool {
        if from == to {
            subtree.iter().all(|&(block, _)| block != under)
        } else {
            subtree.iter().all(|&(block, _)| self.forest.member(block, to).is_none())
        }
    }

    fn accepts_change(&mut self, from: Tree, from_s: f64, to: Tree, to_s: f64) -> bool {
        let costs = &self.forest.cost_s;
        let change = if from == to {
            let before_s = costs[from as usize];
            self.energy(before_s + from_s + to_s) - self.energy(before_s)
        } else {
            let (one_s, other_s) = (costs[from as usize], costs[to as usize]);
            self.energy(one_s + from_s) - self.energy(one_s) + self.energy(other_s + to_s)
                - self.energy(other_s)
        };
        self.accepts(change)
    }

    /// Change of the tree that gives and of the one that takes, seconds.
    fn transfer_s(
        &self,
        subtree: &[(Block, Member)],
        from: Tree,
        by: Block,
        joint: u8,
        under: Member,
    ) -> [f64; 2] {
        let (blocks, pricing) = (self.search.blocks, self.search.pricing);
        let (top, member) = subtree[0];
        let whole_s: f64 = subtree.iter().map(|&(block, member)| pricing.seconds(block, member.used)).sum();
        let mut to_s = whole_s;
        let change_s = |block: Block, before: u8, after: u8| {
            pricing.seconds(block, after) - pricing.seconds(block, before)
        };
        let loose = member.used & !up_bit(member);
        if by == top {
            to_s += change_s(top, member.used, loose | 1 << joint);
        } else {
            to_s += change_s(top, member.used, loose);
            let used = self.forest.member(by, from).expect("it hangs in the tree").used;
            to_s += change_s(by, used, used | 1 << joint);
        }
        let (parent, parent_joint) = Forest::parent(blocks, top, member).expect("a root is not cut off");
        let above = self.forest.member(parent, from).expect("a parent is in the tree").used;
        let link = blocks.joints[by as usize][joint as usize];
        let cut = above & !(1 << parent_joint);
        if from == under.tree && parent == link.other {
            return [change_s(parent, above, cut | 1 << link.back) - whole_s, to_s];
        }
        to_s += change_s(link.other, under.used, under.used | 1 << link.back);
        [change_s(parent, above, cut) - whole_s, to_s]
    }

    /// Takes a subtree out of which nothing is needed, or all belongs to other trees, too.
    fn propose_drop(&mut self, block: Block, member: Member) {
        let Some(top) = self.climb(block, member) else { return };
        let mut subtree = std::mem::take(&mut self.subtree);
        let blocks = self.search.blocks;
        let spare = |&(block, _): &(Block, Member)| {
            !blocks.needed[block as usize] || self.forest.members(block).len() > 1
        };
        if self.forest.subtree(blocks, member.tree, top, SIZES[2], &mut subtree) && subtree.iter().all(spare)
        {
            self.forest.remove(blocks, self.search.pricing, member.tree, &subtree);
        }
        self.subtree = subtree;
    }

    /// Adds the block behind a joint to the tree as well.
    fn propose_copy(&mut self, block: Block, member: Member, joint: u8) {
        let (blocks, pricing) = (self.search.blocks, self.search.pricing);
        let link = blocks.joints[block as usize][joint as usize];
        if self.forest.member(link.other, member.tree).is_some() {
            return;
        }
        let added_s = pricing.seconds(link.other, 1 << link.back)
            + pricing.seconds(block, member.used | 1 << joint)
            - pricing.seconds(block, member.used);
        let cost_s = self.forest.cost_s[member.tree as usize];
        let change = self.energy(cost_s + added_s) - self.energy(cost_s);
        if self.accepts(change) {
            self.forest.add_leaf(blocks, pricing, member.tree, block, joint);
        }
    }

    /// Gives a subtree of a slow robot to any quicker one, with a passage of shared blocks between them.
    fn propose_far(&mut self, block: Block, member: Member) {
        let from_s = self.forest.cost_s[member.tree as usize];
        let to = self.rng.random_range(0..self.forest.cost_s.len()) as Tree;
        let quicker = self.forest.cost_s[to as usize] + 4.0 * self.search.move_s < from_s;
        if from_s < self.mean_s || !quicker {
            return;
        }
        let Some(top) = self.climb(block, member) else { return };
        let mut subtree = std::mem::take(&mut self.subtree);
        let blocks = self.search.blocks;
        if self.forest.subtree(blocks, member.tree, top, SIZES[3], &mut subtree)
            && subtree.iter().all(|&(block, _)| self.forest.member(block, to).is_none())
            && let Some(passage) = self.passage(&subtree, to)
        {
            self.transfer_far(member.tree, to, &subtree, &passage);
        }
        self.subtree = subtree;
    }

    /// Does a far transfer, and takes it back when it is not accepted.
    fn transfer_far(&mut self, from: Tree, to: Tree, subtree: &[(Block, Member)], passage: &[(Block, u8)]) {
        let (blocks, pricing) = (self.search.blocks, self.search.pricing);
        let before = (self.forest.cost_s[from as usize], self.forest.cost_s[to as usize]);
        self.forest.remove(blocks, pricing, from, subtree);
        for &(under, joint) in &passage[..passage.len() - 1] {
            self.forest.add_leaf(blocks, pricing, to, under, joint);
        }
        let &(under, joint) = passage.last().expect("a passage has a last step");
        let link = blocks.joints[under as usize][joint as usize];
        self.forest.insert(blocks, pricing, to, subtree, link.other, link.back);
        let after = (self.forest.cost_s[from as usize], self.forest.cost_s[to as usize]);
        let change =
            self.energy(after.0) - self.energy(before.0) + self.energy(after.1) - self.energy(before.1);
        if self.accepts(change) {
            return;
        }
        let mut moved = Vec::new();
        self.forest.subtree(blocks, to, link.other, subtree.len(), &mut moved);
        self.forest.remove(blocks, pricing, to, &moved);
        for &(under, joint) in passage[..passage.len() - 1].iter().rev() {
            let leaf = blocks.joints[under as usize][joint as usize].other;
            self.forest.subtree(blocks, to, leaf, 1, &mut moved);
            self.forest.remove(blocks, pricing, to, &moved);
        }
        // Back where it hung.
        let (top, member) = subtree[0];
        self.forest.insert(blocks, pricing, from, subtree, top, member.up);
    }

    /// A shortest chain of joints from a tree to a subtree outside it: (block, joint) steps from the tree on.
    fn passage(&self, subtree: &[(Block, Member)], to: Tree) -> Option<Vec<(Block, u8)>> {
        let blocks = self.search.blocks;
        // Found by block: the joint of the block it was reached from, seen from the subtree.
        let mut seen: BTreeMap<Block, Option<(Block, u8)>> =
            subtree.iter().map(|&(block, _)| (block, None)).collect();
        let mut queue: VecDeque<Block> = subtree.iter().map(|&(block, _)| block).collect();
        while let Some(block) = queue.pop_front() {
            for joint in &blocks.joints[block as usize] {
                if seen.contains_key(&joint.other) {
                    continue;
                }
                // From the other block, `back` leads here.
                seen.insert(joint.other, Some((joint.other, joint.back)));
                if self.forest.member(joint.other, to).is_some() {
                    return Some(trace(blocks, &seen, joint.other));
                }
                queue.push_back(joint.other);
            }
            if seen.len() > FAR_BLOCKS {
                return None;
            }
        }
        None
    }
}

fn trace(blocks: &Blocks, seen: &BTreeMap<Block, Option<(Block, u8)>>, from: Block) -> Vec<(Block, u8)> {
    let mut steps = Vec::new();
    let mut at = from;
    while let Some(Some(step)) = seen.get(&at) {
        steps.push(*step);
        at = blocks.joints[step.0 as usize][step.1 as usize].other;
    }
    steps
}
