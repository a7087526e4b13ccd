//! Maximum flow and minimum cut, by Dinic's method.
//!
//! Levels by breadth-first search from the source, then augmenting ways that go up one level with each edge, until none is
//! left; repeated while the sink is reached. With edges of capacity 1, O(E √V).

use std::collections::VecDeque;

/// A network of numbered nodes.
#[derive(Debug, Clone)]
pub(crate) struct Network {
    /// Edges in pairs: number `e ^ 1` is the way back of `e`.
    edges: Vec<Edge>,
    edges_of: Vec<Vec<u32>>,
}

#[derive(Debug, Clone, Copy)]
struct Edge {
    to: u32,
    spare: u32,
}

impl Network {
    pub(crate) fn new(nodes: usize) -> Self {
        Self { edges: Vec::new(), edges_of: vec![Vec::new(); nodes] }
    }

    /// An edge that takes `capacity` in its direction.
    pub(crate) fn add(&mut self, from: usize, to: usize, capacity: u32) {
        self.edges_of[from].push(self.edges.len() as u32);
        self.edges_of[to].push(self.edges.len() as u32 + 1);
        self.edges.push(Edge { to: to as u32, spare: capacity });
        self.edges.push(Edge { to: from as u32, spare: 0 });
    }

    /// The largest flow, and per node whether it lies on the source's side of a minimum cut.
    pub(crate) fn minimum_cut(mut self, source: usize, sink: usize) -> (u64, Vec<bool>) {
        let mut flow = 0;
        loop {
            let level = self.levels(source);
            if level[sink] == u32::MAX {
                return (flow, level.iter().map(|&level| level != u32::MAX).collect());
            }
            let mut next = vec![0_usize; self.edges_of.len()];
            while let Some(way) = self.augmenting_way(source, sink, &level, &mut next) {
                let amount = way.iter().map(|&edge| self.edges[edge].spare).min().unwrap_or(0);
                for edge in way {
                    self.edges[edge].spare -= amount;
                    self.edges[edge ^ 1].spare += amount;
                }
                flow += u64::from(amount);
            }
        }
    }

    fn levels(&self, source: usize) -> Vec<u32> {
        let mut level = vec![u32::MAX; self.edges_of.len()];
        level[source] = 0;
        let mut queue = VecDeque::from([source]);
        while let Some(node) = queue.pop_front() {
            for &edge in &self.edges_of[node] {
                let Edge { to, spare } = self.edges[edge as usize];
                if spare > 0 && level[to as usize] == u32::MAX {
                    level[to as usize] = level[node] + 1;
                    queue.push_back(to as usize);
                }
            }
        }
        level
    }

    /// Edges of a way up the levels; `next` is the first edge of each node that has not failed.
    fn augmenting_way(
        &self,
        source: usize,
        sink: usize,
        level: &[u32],
        next: &mut [usize],
    ) -> Option<Vec<usize>> {
        let mut way: Vec<usize> = Vec::new();
        let mut node = source;
        while node != sink {
            if let Some(&edge) = self.edges_of[node].get(next[node]) {
                let Edge { to, spare } = self.edges[edge as usize];
                if spare > 0 && level[to as usize] == level[node] + 1 {
                    way.push(edge as usize);
                    node = to as usize;
                } else {
                    next[node] += 1;
                }
            } else {
                let back = way.pop()?;
                node = self.edges[back ^ 1].to as usize;
                next[node] += 1;
            }
        }
        Some(way)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_flow_is_the_capacity_of_the_cut_and_no_cut_is_smaller(
            edges in prop::collection::vec((0_usize..6, 0_usize..6, 0_u32..5), 0..20)
        ) {
            let mut network = Network::new(6);
            let edges: Vec<_> = edges.into_iter().filter(|(from, to, _)| from != to).collect();
            for &(from, to, capacity) in &edges {
                network.add(from, to, capacity);
            }
            let (flow, near) = network.minimum_cut(0, 5);
            let crossing = |side: &dyn Fn(usize) -> bool| -> u64 {
                edges.iter().filter(|(from, to, _)| side(*from) && !side(*to)).map(|edge| u64::from(edge.2)).sum()
            };
            prop_assert_eq!(flow, crossing(&|node| near[node]));
            for side in (0..64_u32).filter(|side| side & 1 == 1 && side >> 5 & 1 == 0) {
                prop_assert!(flow <= crossing(&|node| side >> node & 1 == 1));
            }
        }
    }
}
