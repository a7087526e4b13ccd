//! Splits trees into subtrees of weight B to 2 B.

use super::cover::Edge;
use crate::block_trees::Block;

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

    /// Its blocks; those with several edges more than once.
    pub(super) fn blocks(&self) -> impl Iterator<Item = Block> + '_ {
        std::iter::once(self.block).chain(self.edges.iter().flat_map(|edge| [edge.upper, edge.lower]))
    }
}

/// Splits a tree. `edges` lead away from the root, each after the one above it. What is left at the root comes first;
/// it weighs less than `bound`, the others less than 2 × `bound` (no edge weighs more than `bound`).
pub(super) fn split(root: Block, edges: &[Edge], bound: f64) -> (Piece, Vec<Piece>) {
    let mut subtrees = Vec::new();
    // Per block below which something hangs: what has been gathered there so far.
    let mut gathered: std::collections::BTreeMap<Block, Piece> = std::collections::BTreeMap::new();
    for &edge in edges.iter().rev() {
        let mut piece = gathered.remove(&edge.lower).unwrap_or_else(|| Piece::single(edge.lower));
        piece.edges.push(edge);
        piece.weight += edge.weight;
        let at_upper = gathered.entry(edge.upper).or_insert_with(|| Piece::single(edge.upper));
        if piece.weight >= bound {
            subtrees.push(piece);
            continue;
        }
        at_upper.weight += piece.weight;
        at_upper.edges.append(&mut piece.edges);
        if at_upper.weight >= bound {
            subtrees.push(std::mem::replace(at_upper, Piece::single(edge.upper)));
        }
    }
    (gathered.remove(&root).unwrap_or_else(|| Piece::single(root)), subtrees)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn pieces_are_of_weight_b_to_2_b_and_hold_every_edge(
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
            let (leftover, subtrees) = split(0, &edges, bound);
            prop_assert!(leftover.weight < bound);
            prop_assert!(subtrees.iter().all(|piece| piece.weight >= bound && piece.weight < 2.0 * bound));
            let mut lower: Vec<Block> =
                subtrees.iter().chain([&leftover]).flat_map(|piece| piece.edges.iter().map(|edge| edge.lower)).collect();
            lower.sort_unstable();
            prop_assert_eq!(lower, (1..=edges.len() as Block).collect::<Vec<_>>());
        }
    }
}
