//! Sets of nodes that are joined already: what keeps a growing forest free of cycles.

use crate::spanning_graph::Node;

/// Each node points towards the smallest node of its set.
pub(crate) struct DisjointSets {
    parent: Vec<Node>,
}

impl DisjointSets {
    /// Every node alone.
    pub(crate) fn new(nodes: usize) -> Self {
        Self { parent: (0..nodes as Node).collect() }
    }

    /// The smallest node of the set that holds `node`.
    pub(crate) fn find(&mut self, node: Node) -> Node {
        let mut at = node;
        while self.parent[at as usize] != at {
            self.parent[at as usize] = self.parent[self.parent[at as usize] as usize];
            at = self.parent[at as usize];
        }
        at
    }

    /// Makes one set of two.
    pub(crate) fn unite(&mut self, a: Node, b: Node) {
        let (a, b) = (self.find(a), self.find(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}
