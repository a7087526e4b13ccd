//! One tree of blocks per robot, with costs that change locally.

use super::{
    blocks::{Block, Blocks},
    pricing::Pricing,
};

use smallvec::SmallVec;

/// Number of a tree: that of its robot.
pub(crate) type Tree = u32;

/// A block in a tree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Member {
    pub(crate) tree: Tree,
    /// Joints used, one bit each.
    pub(crate) used: u8,
    /// The joint towards the root; [`ROOT`] at the root.
    pub(crate) up: u8,
}

/// No joint leads up from here.
pub(crate) const ROOT: u8 = u8::MAX;

/// The trees of all robots. A block may belong to several.
#[derive(Debug, Clone)]
pub(crate) struct Forest {
    /// Per block: the trees that it belongs to.
    members: Vec<SmallVec<[Member; 2]>>,
    /// Per tree: seconds, the robot's delay included.
    pub(crate) cost_s: Vec<f64>,
}

impl Forest {
    /// Trees of one block each; robots without work on their piece of ground have them, too.
    pub(crate) fn new(blocks: &Blocks, pricing: &Pricing, roots: &[Block], delays_s: &[f64]) -> Self {
        let mut forest = Self { members: vec![SmallVec::new(); blocks.len()], cost_s: delays_s.to_vec() };
        for (tree, &root) in roots.iter().enumerate() {
            forest.members[root as usize].push(Member { tree: tree as Tree, used: 0, up: ROOT });
            forest.cost_s[tree] += pricing.seconds(root, 0);
        }
        forest
    }

    /// A whole tree at once: its blocks, the root first, and how they hang together.
    pub(crate) fn plant(&mut self, pricing: &Pricing, blocks: &[Block], members: &[Member]) {
        for (&block, &member) in blocks.iter().zip(members) {
            let before_s =
                self.member(block, member.tree).map_or(0.0, |old| pricing.seconds(block, old.used));
            self.cost_s[member.tree as usize] += pricing.seconds(block, member.used) - before_s;
            self.members[block as usize].retain(|old| old.tree != member.tree);
            self.members[block as usize].push(member);
        }
    }

    pub(crate) fn members(&self, block: Block) -> &[Member] {
        &self.members[block as usize]
    }

    pub(crate) fn member(&self, block: Block, tree: Tree) -> Option<Member> {
        self.members(block).iter().copied().find(|member| member.tree == tree)
    }

    fn member_mut(&mut self, block: Block, tree: Tree) -> &mut Member {
        let found = self.members[block as usize].iter_mut().find(|member| member.tree == tree);
        found.expect("the block is in the tree")
    }

    /// Hangs a new block below `under` by the joint `joint` of `under`.
    pub(crate) fn add_leaf(
        &mut self,
        blocks: &Blocks,
        pricing: &Pricing,
        tree: Tree,
        under: Block,
        joint: u8,
    ) {
        let link = blocks.joints[under as usize][joint as usize];
        self.members[link.other as usize].push(Member { tree, used: 1 << link.back, up: link.back });
        self.cost_s[tree as usize] += pricing.seconds(link.other, 1 << link.back);
        let parent = self.member_mut(under, tree);
        let before = parent.used;
        parent.used |= 1 << joint;
        let after = parent.used;
        self.cost_s[tree as usize] += pricing.seconds(under, after) - pricing.seconds(under, before);
    }

    /// The parent of a block in a tree, and the parent's joint to it.
    pub(crate) fn parent(blocks: &Blocks, block: Block, member: Member) -> Option<(Block, u8)> {
        let link = blocks.joints[block as usize].get(member.up as usize)?;
        Some((link.other, link.back))
    }

    /// The blocks below and including `top`; nothing when there are more than `most`.
    pub(crate) fn subtree(
        &self,
        blocks: &Blocks,
        tree: Tree,
        top: Block,
        most: usize,
        found: &mut Vec<(Block, Member)>,
    ) -> bool {
        found.clear();
        let Some(member) = self.member(top, tree) else { return false };
        found.push((top, member));
        let mut next = 0;
        while let Some(&(block, member)) = found.get(next) {
            next += 1;
            let mut below = member.used & !up_bit(member);
            while below != 0 {
                let joint = below.trailing_zeros();
                below &= below - 1;
                let child = blocks.joints[block as usize][joint as usize].other;
                let child_member =
                    self.member(child, tree).expect("a used joint leads to a block of the tree");
                found.push((child, child_member));
                if found.len() > most {
                    return false;
                }
            }
        }
        true
    }

    /// Cuts a subtree off its parent and takes it out of the tree.
    pub(crate) fn remove(
        &mut self,
        blocks: &Blocks,
        pricing: &Pricing,
        tree: Tree,
        subtree: &[(Block, Member)],
    ) {
        let (top, member) = subtree[0];
        let (parent, joint) = Self::parent(blocks, top, member).expect("a root is not cut off");
        let above = self.member_mut(parent, tree);
        let before = above.used;
        above.used &= !(1 << joint);
        let after = above.used;
        let mut change_s = pricing.seconds(parent, after) - pricing.seconds(parent, before);
        for &(block, member) in subtree {
            change_s -= pricing.seconds(block, member.used);
            let members = &mut self.members[block as usize];
            let place = members.iter().position(|other| other.tree == tree).expect("it is in the tree");
            members.swap_remove(place);
        }
        self.cost_s[tree as usize] += change_s;
    }

    /// Hangs a subtree that was taken out into a tree, by the joint `joint` of its block `by`, which gets its top.
    pub(crate) fn insert(
        &mut self,
        blocks: &Blocks,
        pricing: &Pricing,
        tree: Tree,
        subtree: &[(Block, Member)],
        by: Block,
        joint: u8,
    ) {
        for &(block, member) in subtree {
            self.members[block as usize].push(Member { tree, ..member });
        }
        let old_top = subtree[0].0;
        let mut at = by;
        let mut up = joint;
        // The way from the new top to the old one turns round.
        loop {
            let member = self.member_mut(at, tree);
            let old_up = std::mem::replace(&mut member.up, up);
            if at == old_top {
                member.used &= !joint_bit(old_up);
                break;
            }
            let link = blocks.joints[at as usize][old_up as usize];
            (at, up) = (link.other, link.back);
        }
        self.member_mut(by, tree).used |= 1 << joint;
        let link = blocks.joints[by as usize][joint as usize];
        let under = self.member_mut(link.other, tree);
        let before = under.used;
        under.used |= 1 << link.back;
        let after = under.used;
        let mut change_s = pricing.seconds(link.other, after) - pricing.seconds(link.other, before);
        for &(block, _) in subtree {
            change_s += pricing.seconds(block, self.member_mut(block, tree).used);
        }
        self.cost_s[tree as usize] += change_s;
    }

    /// Puts other members of a tree in the place of its old ones: the same blocks, joined otherwise.
    pub(crate) fn replace(&mut self, pricing: &Pricing, tree: Tree, old: &[(Block, Member)], new: &[Member]) {
        for (&(block, before), &after) in old.iter().zip(new) {
            self.cost_s[tree as usize] +=
                pricing.seconds(block, after.used) - pricing.seconds(block, before.used);
            *self.member_mut(block, tree) = after;
        }
    }

    /// Time of the slowest robot.
    pub(crate) fn makespan_s(&self) -> f64 {
        self.cost_s.iter().copied().fold(0.0, f64::max)
    }
}

/// The bit of the joint towards the root; none at the root.
pub(crate) fn up_bit(member: Member) -> u8 {
    joint_bit(member.up)
}

fn joint_bit(joint: u8) -> u8 {
    if joint == ROOT { 0 } else { 1 << joint }
}
