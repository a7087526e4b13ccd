//! Min-max rooted tree cover: one tree per robot, every isoline in one at least, the costliest as cheap as can be.

use super::graph::Isograph;

/// Number of a vertex.
pub(super) type Vertex = usize;

/// A graph with weights on vertices and edges, and a root for each tree.
#[derive(Debug, Clone)]
pub(super) struct CoverProblem {
    pub(super) weights_m: Vec<f64>,
    /// Per vertex: neighbours, and what the edge adds.
    pub(super) neighbours: Vec<Vec<(Vertex, f64)>>,
    pub(super) roots: Vec<Vertex>,
}

/// Trees, one per root: the parent of each vertex in it; the root is its own.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Cover {
    pub(super) parents: Vec<Vec<Option<Vertex>>>,
}

impl CoverProblem {
    pub(super) fn new(graph: &Isograph, roots: Vec<Vertex>) -> Self {
        let mut neighbours = vec![Vec::new(); graph.lines.len()];
        for edge in &graph.edges {
            let [u, v] = edge.lines.map(|line| line as Vertex);
            neighbours[u].push((v, edge.weight_m));
            neighbours[v].push((u, edge.weight_m));
        }
        Self { weights_m: graph.lines.iter().map(|line| line.length_m).collect(), neighbours, roots }
    }

    pub(super) fn len(&self) -> usize {
        self.weights_m.len()
    }

    /// Weight of the edge between two neighbours.
    pub(super) fn edge_m(&self, one: Vertex, other: Vertex) -> f64 {
        let edge = self.neighbours[one].iter().find(|(vertex, _)| *vertex == other);
        edge.expect("trees use edges of the graph").1
    }

    pub(super) fn cost_m(&self, parents: &[Option<Vertex>]) -> f64 {
        let priced = parents.iter().enumerate().filter_map(|(vertex, parent)| Some((vertex, (*parent)?)));
        let cost = |(vertex, parent)| {
            let edge_m = if vertex == parent { 0.0 } else { self.edge_m(vertex, parent) };
            self.weights_m[vertex] + edge_m
        };
        priced.map(cost).sum()
    }

    /// Cost of the costliest tree.
    pub(super) fn makespan_m(&self, cover: &Cover) -> f64 {
        cover.parents.iter().map(|tree| self.cost_m(tree)).fold(0.0, f64::max)
    }

    /// Weight of the vertices that no tree has.
    pub(super) fn left_out_m(&self, cover: &Cover) -> f64 {
        let left = (0..self.len()).filter(|&vertex| cover.parents.iter().all(|tree| tree[vertex].is_none()));
        left.map(|vertex| self.weights_m[vertex]).sum()
    }

    /// No cover is cheaper: the work shared evenly, and the way to the farthest vertex.
    pub(super) fn lower_bound_m(&self) -> f64 {
        let shared_m = self.weights_m.iter().sum::<f64>() / self.roots.len() as f64;
        shared_m.max(self.farthest_m())
    }

    fn farthest_m(&self) -> f64 {
        let ways = self.ways_m(&self.roots);
        ways.into_iter().filter(|way| way.is_finite()).fold(0.0, f64::max)
    }

    /// Cost of the cheapest path from one of some vertices to each, that to the vertex itself included.
    fn ways_m(&self, from: &[Vertex]) -> Vec<f64> {
        let mut ways = vec![f64::INFINITY; self.len()];
        for &vertex in from {
            ways[vertex] = self.weights_m[vertex];
        }
        let mut open: Vec<bool> = vec![true; self.len()];
        while let Some(at) = cheapest(&ways, &open) {
            open[at] = false;
            for &(next, edge_m) in &self.neighbours[at] {
                ways[next] = ways[next].min(ways[at] + edge_m + self.weights_m[next]);
            }
        }
        ways
    }
}

fn cheapest(ways: &[f64], open: &[bool]) -> Option<Vertex> {
    let candidates = (0..ways.len()).filter(|&vertex| open[vertex] && ways[vertex].is_finite());
    candidates.min_by(|&one, &other| ways[one].total_cmp(&ways[other]))
}
