//! Splits trees into subtrees of weight B to 2 B.
//!
//! Even and others let any subtree of that weight be split off next, as long as one is left. [`split_early`] takes what
//! has just become heavy enough, on the way up: subtrees of hardly more than B. [`split_late`] splits only below blocks
//! that 2 B or more hangs from, the lowest ones first, and takes a whole branch where it can: fewer and larger subtrees.

use super::cover::Edge;
use crate::block_trees::Block;
use std::collections::BTreeMap;

/// A connected piece of a tree: its edges, or a single block when there is none.
#[derive(Debug, Clone)]
pub(super) struct Piece {
    /// A block of it.
    pub(super) block: Block,
    pub(super) edges: Vec<Edge>,
    pub(super) weight: f64,
}

impl Piece {
    fn single(block: Block) -> Self {
        Self { block, edges: Vec::new(), weight: 0.0 }
    }

    /// Takes the edges of another piece that shares a block with it.
    fn take(&mut self, mut other: Self) {
        self.weight += other.weight;
        if other.edges.len() > self.edges.len() {
            std::mem::swap(&mut self.edges, &mut other.edges);
        }
        self.edges.append(&mut other.edges);
    }

    fn take_branch(&mut self, (edge, mut piece): (Edge, Self)) {
        piece.edges.push(edge);
        piece.weight += edge.weight;
        self.take(piece);
    }

    /// Its blocks; those with several edges more than once.
    pub(super) fn blocks(&self) -> impl Iterator<Item = Block> + '_ {
        std::iter::once(self.block).chain(self.edges.iter().flat_map(|edge| [edge.upper, edge.lower]))
    }
}

/// Splits a tree. `edges` lead away from the root, each after the one above it. What is left at the root comes first;
/// it weighs less than `bound`, the others less than 2 × `bound` (no edge weighs more than `bound`).
pub(super) fn split_early(root: Block, edges: &[Edge], bound: f64) -> (Piece, Vec<Piece>) {
    let mut subtrees = Vec::new();
    // Per block below which something hangs: what has been gathered there so far.
    let mut gathered: BTreeMap<Block, Piece> = BTreeMap::new();
    for &edge in edges.iter().rev() {
        let mut piece = gathered.remove(&edge.lower).unwrap_or_else(|| Piece::single(edge.lower));
        piece.edges.push(edge);
        piece.weight += edge.weight;
        let at_upper = gathered.entry(edge.upper).or_insert_with(|| Piece::single(edge.upper));
        if piece.weight >= bound {
            subtrees.push(piece);
            continue;
        }
        at_upper.take(piece);
        if at_upper.weight >= bound {
            subtrees.push(std::mem::replace(at_upper, Piece::single(edge.upper)));
        }
    }
    (gathered.remove(&root).unwrap_or_else(|| Piece::single(root)), subtrees)
}

/// The same, with fewer and larger subtrees. An edge above a subtree may be in none: both its blocks are.
pub(super) fn split_late(root: Block, edges: &[Edge], bound: f64) -> (Piece, Vec<Piece>) {
    let mut subtrees = Vec::new();
    // Per block: the branches that hang from it, the edge to each apart.
    let mut hanging: BTreeMap<Block, Vec<(Edge, Piece)>> = BTreeMap::new();
    for &edge in edges.iter().rev() {
        let branches = hanging.remove(&edge.lower).unwrap_or_default();
        let piece = lighten(edge.lower, branches, bound, &mut subtrees);
        hanging.entry(edge.upper).or_default().push((edge, piece));
    }
    let branches = hanging.remove(&root).unwrap_or_default();
    let mut left = lighten(root, branches, bound, &mut subtrees);
    if left.weight >= bound {
        subtrees.push(std::mem::replace(&mut left, Piece::single(root)));
    }
    (left, subtrees)
}

/// Splits subtrees off below a block until less than 2 × `bound` hangs from it; returns that.
fn lighten(block: Block, mut branches: Vec<(Edge, Piece)>, bound: f64, subtrees: &mut Vec<Piece>) -> Piece {
    let weight = |branch: &(Edge, Piece)| branch.0.weight + branch.1.weight;
    while branches.iter().map(weight).sum::<f64>() >= 2.0 * bound {
        if let Some(heavy) = branches.iter().position(|(_, piece)| piece.weight >= bound) {
            subtrees.push(branches.remove(heavy).1);
            continue;
        }
        // A branch that is heavy enough by its edge alone, or as many light ones as are needed.
        let first = branches.iter().position(|branch| weight(branch) >= bound).unwrap_or(0);
        let mut subtree = Piece::single(block);
        while subtree.weight < bound {
            subtree.take_branch(branches.remove(first));
        }
        subtrees.push(subtree);
    }
    let mut rest = Piece::single(block);
    for branch in branches {
        rest.take_branch(branch);
    }
    rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    proptest! {
        #[test]
        fn pieces_are_of_weight_b_to_2_b_and_hold_every_block(
            parents in prop::collection::vec((any::<prop::sample::Index>(), 0.1_f64..1.0), 0..60),
            bound in 1.0_f64..9.0,
        ) {
            let edges: Vec<Edge> = parents
                .iter()
                .enumerate()
                .map(|(number, (parent, weight))| Edge {
                    upper: parent.index(number + 1) as Block,
                    lower: number as Block + 1,
                    joint: 0,
                    weight: *weight,
                })
                .collect();
            for split in [split_early, split_late] {
                let (leftover, subtrees) = split(0, &edges, bound);
                prop_assert!(leftover.weight < bound);
                prop_assert!(
                    subtrees.iter().all(|piece| piece.weight >= bound && piece.weight < 2.0 * bound + 1e-9)
                );
                let pieces = || subtrees.iter().chain([&leftover]);
                let blocks: BTreeSet<Block> = pieces().flat_map(Piece::blocks).collect();
                prop_assert_eq!(blocks, (0..=edges.len() as Block).collect::<BTreeSet<_>>());
                let mut lower: Vec<Block> =
                    pieces().flat_map(|piece| piece.edges.iter().map(|edge| edge.lower)).collect();
                lower.sort_unstable();
                prop_assert!(lower.windows(2).all(|pair| pair[0] < pair[1]), "an edge is in one piece only");
            }
        }
    }
}
