//! Maximum matching in a bipartite graph (Hopcroft and Karp 1973, O(E √V)), and the independent sets that König's
//! theorem reads off it.

use std::collections::VecDeque;

/// No partner.
pub(crate) const NONE: u32 = u32::MAX;

/// A bipartite graph: per left node its right nodes, and the other way round.
#[derive(Debug)]
pub(crate) struct Bipartite {
    of_left: Adjacency,
    of_right: Adjacency,
}

/// Lists of neighbours, one after another.
#[derive(Debug)]
struct Adjacency {
    begins: Vec<u32>,
    others: Vec<u32>,
}

impl Adjacency {
    fn new(nodes: usize, edges: impl Iterator<Item = (u32, u32)> + Clone) -> Self {
        let mut begins = vec![0_u32; nodes + 1];
        for (node, _) in edges.clone() {
            begins[node as usize + 1] += 1;
        }
        for node in 0..nodes {
            begins[node + 1] += begins[node];
        }
        let mut next = begins.clone();
        let mut others = vec![NONE; begins[nodes] as usize];
        for (node, other) in edges {
            others[next[node as usize] as usize] = other;
            next[node as usize] += 1;
        }
        Self { begins, others }
    }

    fn of(&self, node: u32) -> &[u32] {
        &self.others[self.begins[node as usize] as usize..self.begins[node as usize + 1] as usize]
    }

    fn len(&self) -> usize {
        self.begins.len() - 1
    }
}

impl Bipartite {
    /// A graph from its edges, as pairs of a left and a right node.
    pub(crate) fn new(left: usize, right: usize, edges: &[(u32, u32)]) -> Self {
        Self {
            of_left: Adjacency::new(left, edges.iter().copied()),
            of_right: Adjacency::new(right, edges.iter().map(|&(left, right)| (right, left))),
        }
    }

    /// Number of left and of right nodes.
    pub(crate) fn sizes(&self) -> (usize, usize) {
        (self.of_left.len(), self.of_right.len())
    }
}

/// Partners, at most one each.
#[derive(Debug, Clone)]
pub(crate) struct Matching {
    /// Per left node: its right partner, or [`NONE`].
    pub(crate) of_left: Vec<u32>,
    /// Per right node: its left partner, or [`NONE`].
    pub(crate) of_right: Vec<u32>,
    /// Number of pairs.
    pub(crate) size: usize,
}

impl Matching {
    /// A matching with the most pairs: shortest augmenting paths in phases, without recursion.
    pub(crate) fn maximum(graph: &Bipartite) -> Self {
        let (left, right) = graph.sizes();
        let mut matching = Self { of_left: vec![NONE; left], of_right: vec![NONE; right], size: 0 };
        let mut layer = vec![NONE; left];
        while matching.lay(graph, &mut layer) {
            for node in 0..left as u32 {
                if matching.of_left[node as usize] == NONE && matching.augment(graph, &mut layer, node) {
                    matching.size += 1;
                }
            }
        }
        matching
    }

    /// Breadth first layers from the free left nodes; whether a free right node is reached.
    fn lay(&self, graph: &Bipartite, layer: &mut [u32]) -> bool {
        let mut queue = VecDeque::new();
        for (node, layer) in layer.iter_mut().enumerate() {
            let free = self.of_left[node] == NONE;
            *layer = if free { 0 } else { NONE };
            if free {
                queue.push_back(node as u32);
            }
        }
        let mut found = false;
        while let Some(node) = queue.pop_front() {
            for &right in graph.of_left.of(node) {
                let next = self.of_right[right as usize];
                if next == NONE {
                    found = true;
                } else if layer[next as usize] == NONE {
                    layer[next as usize] = layer[node as usize] + 1;
                    queue.push_back(next);
                }
            }
        }
        found
    }

    /// Depth first along the layers; a node that leads nowhere is left out of the phase.
    fn augment(&mut self, graph: &Bipartite, layer: &mut [u32], from: u32) -> bool {
        let mut path: Vec<(u32, usize)> = vec![(from, 0)];
        while let Some((node, tried)) = path.last_mut() {
            let Some(&right) = graph.of_left.of(*node).get(*tried) else {
                layer[*node as usize] = NONE;
                path.pop();
                continue;
            };
            *tried += 1;
            let next = self.of_right[right as usize];
            if next == NONE {
                self.flip(graph, &path);
                return true;
            }
            let depth = layer[*node as usize];
            if depth != NONE && layer[next as usize] == depth + 1 {
                path.push((next, 0));
            }
        }
        false
    }

    fn flip(&mut self, graph: &Bipartite, path: &[(u32, usize)]) {
        for &(node, tried) in path {
            let right = graph.of_left.of(node)[tried - 1];
            self.of_left[node as usize] = right;
            self.of_right[right as usize] = node;
        }
    }

    /// A maximum independent set (left, right): as many left nodes as any has.
    pub(crate) fn independent_set(&self, graph: &Bipartite) -> (Vec<bool>, Vec<bool>) {
        let (left, right) = alternate(&graph.of_left, &self.of_left, &self.of_right);
        (left, right.iter().map(|&reached| !reached).collect())
    }

    /// A maximum independent set (left, right): as many right nodes as any has.
    pub(crate) fn independent_set_of_right(&self, graph: &Bipartite) -> (Vec<bool>, Vec<bool>) {
        let (right, left) = alternate(&graph.of_right, &self.of_right, &self.of_left);
        (left.iter().map(|&reached| !reached).collect(), right)
    }
}

/// What alternating paths from the free nodes of one side reach, on that side and on the other.
fn alternate(of: &Adjacency, partner: &[u32], partner_of_other: &[u32]) -> (Vec<bool>, Vec<bool>) {
    let mut here: Vec<bool> = partner.iter().map(|&partner| partner == NONE).collect();
    let mut there = vec![false; partner_of_other.len()];
    let mut stack: Vec<u32> = (0..here.len() as u32).filter(|&node| here[node as usize]).collect();
    while let Some(node) = stack.pop() {
        for &other in of.of(node) {
            if std::mem::replace(&mut there[other as usize], true) {
                continue;
            }
            let next = partner_of_other[other as usize];
            if next != NONE && !here[next as usize] {
                here[next as usize] = true;
                stack.push(next);
            }
        }
    }
    (here, there)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// König: matching + independent set = all nodes, and no edge joins two of the set. Both together prove
        /// that the one is maximum and so is the other.
        #[test]
        fn an_independent_set_proves_the_matching(
            edges in prop::collection::vec((0_u32..9, 0_u32..7), 0..40),
        ) {
            let mut edges = edges;
            edges.sort_unstable();
            edges.dedup();
            let graph = Bipartite::new(9, 7, &edges);
            let matching = Matching::maximum(&graph);
            for (left, right) in
                [matching.independent_set(&graph), matching.independent_set_of_right(&graph)]
            {
                let kept = left.iter().chain(&right).filter(|&&kept| kept).count();
                prop_assert_eq!(kept + matching.size, 16);
                prop_assert!(edges.iter().all(|&(a, b)| !(left[a as usize] && right[b as usize])));
            }
        }
    }
}
