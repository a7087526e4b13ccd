//! Minimum-weight perfect matching in a complete graph: Edmonds' blossom algorithm, primal-dual, O(n³).
//!
//! ```text
//!   duals y          every edge has slack y(u) + y(v) − 2 w(u, v) ≥ 0 (w: the largest cost less its own, plus one);
//!   forest           grown from the free surface nodes along edges without slack: EVEN, ODD, EVEN, …
//!   EVEN meets EVEN  of another tree: an augmenting path; of the same tree: the odd cycle shrinks to a blossom
//!   nothing meets    duals move by the least slack: EVEN down, ODD up; an ODD blossom at 0 is opened again
//! ```
//!
//! Paper: J. Edmonds: Maximum matching and a polyhedron with 0,1-vertices, 1965; O(n³) as in H. Gabow 1976. The optimum is
//! proved by the duals: tests check it against all matchings of small graphs.

use std::collections::VecDeque;

const NOBODY: usize = usize::MAX;

/// Per vertex its partner, so that the sum of costs is least. `cost` must be symmetric and finite; its numbers are taken to a
/// thousandth.
///
/// An odd number of vertices has no perfect matching: that is a mistake of the caller.
pub(crate) fn minimum_perfect_matching(vertices: usize, cost: impl Fn(usize, usize) -> f64) -> Vec<usize> {
    assert!(vertices.is_multiple_of(2), "an odd number of vertices cannot be paired");
    let thousandths = |u: usize, v: usize| (cost(u.min(v), u.max(v)) * 1000.0).round() as i64;
    let pairs = (0..vertices).flat_map(|u| (0..u).map(move |v| (u, v)));
    let most = pairs.map(|(u, v)| thousandths(u, v)).max().unwrap_or(0);
    let mut search = Search::new(vertices, |u, v| most + 1 - thousandths(u, v));
    while search.augment() {}
    search.mates()
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Label {
    Free,
    Even,
    Odd,
}

/// An edge between two surface nodes, by its end vertices.
#[derive(Debug, Clone, Copy)]
struct Edge {
    u: usize,
    v: usize,
    weight: i64,
}

/// Nodes are vertices `0..vertices` and, above them, blossoms.
struct Search {
    vertices: usize,
    /// Per pair of nodes: the edge with the least slack between them.
    edges: Vec<Vec<Edge>>,
    dual: Vec<i64>,
    /// Per node: the vertex at the far end of its matched edge.
    mate: Vec<usize>,
    /// Per node: the outermost blossom that holds it; `NOBODY` for unused blossoms.
    surface: Vec<usize>,
    label: Vec<Label>,
    /// Per labelled node: the vertex from which the tree reached it.
    parent: Vec<usize>,
    /// Per surface node: the vertex of an EVEN node with the least slack to it.
    closest: Vec<usize>,
    /// Per blossom: its cycle of nodes, the base first.
    cycle: Vec<Vec<usize>>,
    /// Per blossom and vertex: the node of its cycle that holds the vertex.
    child: Vec<Vec<usize>>,
    queue: VecDeque<usize>,
    /// When a node was last passed in a search for a common ancestor.
    passed: Vec<u64>,
    round: u64,
}

impl Search {
    fn new(vertices: usize, weight: impl Fn(usize, usize) -> i64) -> Self {
        let nodes = vertices + vertices / 2 + 1;
        let edge = |u: usize, v: usize| {
            let real = u < vertices && v < vertices && u != v;
            Edge { u, v, weight: if real { weight(u, v) } else { 0 } }
        };
        let edges: Vec<Vec<Edge>> = (0..nodes).map(|u| (0..nodes).map(|v| edge(u, v)).collect()).collect();
        let most = edges.iter().flatten().map(|edge| edge.weight).max().unwrap_or(0);
        let dual = (0..nodes).map(|node| if node < vertices { most } else { 0 }).collect();
        let surface = (0..nodes).map(|node| if node < vertices { node } else { NOBODY }).collect();
        let mut child = vec![vec![NOBODY; vertices]; nodes];
        (0..vertices).for_each(|vertex| child[vertex][vertex] = vertex);
        Self {
            vertices,
            edges,
            dual,
            mate: vec![NOBODY; nodes],
            surface,
            label: vec![Label::Free; nodes],
            parent: vec![NOBODY; nodes],
            closest: vec![NOBODY; nodes],
            cycle: vec![Vec::new(); nodes],
            child,
            queue: VecDeque::new(),
            passed: vec![0; nodes],
            round: 0,
        }
    }

    fn mates(&self) -> Vec<usize> {
        self.mate[..self.vertices].to_vec()
    }

    /// Surface nodes in use.
    fn on_surface(&self) -> Vec<usize> {
        (0..self.surface.len()).filter(|&node| self.surface[node] == node).collect()
    }

    fn slack(&self, edge: Edge) -> i64 {
        self.dual[edge.u] + self.dual[edge.v] - 2 * self.edges[edge.u][edge.v].weight
    }

    /// One phase: a larger matching, if there is one.
    fn augment(&mut self) -> bool {
        self.label.fill(Label::Free);
        self.closest.fill(NOBODY);
        self.queue.clear();
        for node in self.on_surface() {
            if self.mate[node] == NOBODY {
                self.parent[node] = NOBODY;
                self.label[node] = Label::Even;
                self.enqueue(node);
            }
        }
        if self.queue.is_empty() {
            return false;
        }
        loop {
            while let Some(vertex) = self.queue.pop_front() {
                if self.scan(vertex) {
                    return true;
                }
            }
            self.move_duals();
            // Nodes shrink and appear on the way.
            for node in 0..self.surface.len() {
                let closest = self.closest[node];
                let on_surface = self.surface[node] == node;
                if !on_surface || closest == NOBODY || self.surface[closest] == node {
                    continue;
                }
                let edge = self.edges[closest][node];
                if self.slack(edge) == 0 && self.found(edge) {
                    return true;
                }
            }
            self.open_spent_blossoms();
        }
    }

    /// Looks along the edges of an EVEN vertex.
    fn scan(&mut self, vertex: usize) -> bool {
        if self.label[self.surface[vertex]] == Label::Odd {
            return false;
        }
        for other in 0..self.vertices {
            if self.surface[vertex] == self.surface[other] {
                continue;
            }
            let edge = self.edges[vertex][other];
            if self.slack(edge) == 0 {
                if self.found(edge) {
                    return true;
                }
            } else {
                self.approach(vertex, self.surface[other]);
            }
        }
        false
    }

    /// Notes that an EVEN vertex is near a surface node.
    fn approach(&mut self, vertex: usize, node: usize) {
        let closest = self.closest[node];
        let nearer =
            closest == NOBODY || self.slack(self.edges[vertex][node]) < self.slack(self.edges[closest][node]);
        if nearer {
            self.closest[node] = vertex;
        }
    }

    /// Finds anew which EVEN vertex is nearest to a surface node.
    fn find_closest(&mut self, node: usize) {
        self.closest[node] = NOBODY;
        for vertex in 0..self.vertices {
            let outer = self.surface[vertex];
            if outer != node && self.label[outer] == Label::Even {
                self.approach(vertex, node);
            }
        }
    }

    /// Puts all vertices of a node into the queue.
    fn enqueue(&mut self, node: usize) {
        let mut stack = vec![node];
        while let Some(node) = stack.pop() {
            if node < self.vertices {
                self.queue.push_back(node);
            } else {
                stack.extend(self.cycle[node].iter().rev());
            }
        }
    }

    fn set_surface(&mut self, node: usize, outer: usize) {
        let mut stack = vec![node];
        while let Some(node) = stack.pop() {
            self.surface[node] = outer;
            if node >= self.vertices {
                stack.extend(&self.cycle[node]);
            }
        }
    }

    /// Follows an edge without slack from an EVEN node; whether the matching grew.
    fn found(&mut self, edge: Edge) -> bool {
        let (from, to) = (self.surface[edge.u], self.surface[edge.v]);
        match self.label[to] {
            Label::Free => {
                self.parent[to] = edge.u;
                self.label[to] = Label::Odd;
                let next = self.surface[self.mate[to]];
                self.closest[to] = NOBODY;
                self.closest[next] = NOBODY;
                self.label[next] = Label::Even;
                self.enqueue(next);
                false
            }
            Label::Odd => false,
            Label::Even => {
                if let Some(base) = self.common_ancestor(from, to) {
                    self.shrink(edge.u, base, edge.v);
                    return false;
                }
                self.flip(from, to);
                self.flip(to, from);
                true
            }
        }
    }

    fn common_ancestor(&mut self, mut one: usize, mut other: usize) -> Option<usize> {
        self.round += 1;
        while one != NOBODY || other != NOBODY {
            if one != NOBODY {
                if self.passed[one] == self.round {
                    return Some(one);
                }
                self.passed[one] = self.round;
                one = self.grandparent(one);
            }
            std::mem::swap(&mut one, &mut other);
        }
        None
    }

    /// The EVEN node before an EVEN node in its tree.
    fn grandparent(&self, node: usize) -> usize {
        if self.mate[node] == NOBODY {
            return NOBODY;
        }
        let odd = self.surface[self.mate[node]];
        self.surface[self.parent[odd]]
    }

    /// Matches a node along its best edge to `other`, and mends the blossoms inside it.
    fn set_mate(&mut self, node: usize, other: usize) {
        let edge = self.edges[node][other];
        self.mate[node] = edge.v;
        if node < self.vertices {
            return;
        }
        let inner = self.child[node][edge.u];
        let place = self.rotate_to_even(node, inner);
        for at in 0..place {
            let (one, next) = (self.cycle[node][at], self.cycle[node][at ^ 1]);
            self.set_mate(one, next);
        }
        self.set_mate(inner, other);
        self.cycle[node].rotate_left(place);
    }

    /// Place of a node in the cycle of a blossom; the cycle is turned round where the way from the base to it would be odd.
    fn rotate_to_even(&mut self, blossom: usize, inner: usize) -> usize {
        let cycle = &mut self.cycle[blossom];
        let place = cycle.iter().position(|&node| node == inner).expect("the blossom holds it");
        if place % 2 == 0 {
            return place;
        }
        cycle[1..].reverse();
        cycle.len() - place
    }

    /// Changes what is matched along the way from a node to the root of its tree.
    fn flip(&mut self, mut node: usize, mut other: usize) {
        loop {
            let before = self.mate[node];
            self.set_mate(node, other);
            if before == NOBODY {
                return;
            }
            let odd = self.surface[before];
            let next = self.surface[self.parent[odd]];
            self.set_mate(odd, next);
            (node, other) = (next, odd);
        }
    }

    /// Makes a blossom of the cycle that an edge between two EVEN vertices closes.
    fn shrink(&mut self, u: usize, base: usize, v: usize) {
        let unused = (self.vertices..self.surface.len()).find(|&node| self.surface[node] == NOBODY);
        let blossom = unused.expect("n vertices make at most n / 2 blossoms");
        self.dual[blossom] = 0;
        self.label[blossom] = Label::Even;
        self.mate[blossom] = self.mate[base];
        let mut cycle = vec![base];
        self.climb(u, base, &mut cycle);
        cycle[1..].reverse();
        self.climb(v, base, &mut cycle);
        self.cycle[blossom] = cycle;
        self.set_surface(blossom, blossom);
        self.inherit_edges(blossom);
        self.find_closest(blossom);
    }

    /// Adds the nodes on the way from a vertex up to `base`, which is left out; the ODD ones become EVEN.
    fn climb(&mut self, vertex: usize, base: usize, cycle: &mut Vec<usize>) {
        let mut node = self.surface[vertex];
        while node != base {
            let odd = self.surface[self.mate[node]];
            cycle.extend([node, odd]);
            self.enqueue(odd);
            node = self.surface[self.parent[odd]];
        }
    }

    /// To every other node, a blossom has the best edge of its parts.
    fn inherit_edges(&mut self, blossom: usize) {
        let parts = self.cycle[blossom].clone();
        let nodes = self.surface.len();
        self.child[blossom].fill(NOBODY);
        for node in 0..nodes {
            let far = |edge: &Edge| edge.u < self.vertices && edge.v < self.vertices && edge.u != edge.v;
            let best = parts
                .iter()
                .map(|&part| self.edges[part][node])
                .filter(far)
                .min_by_key(|&edge| self.slack(edge));
            if let Some(edge) = best {
                self.edges[blossom][node] = edge;
                self.edges[node][blossom] = Edge { u: edge.v, v: edge.u, weight: edge.weight };
            }
        }
        for part in parts {
            for vertex in 0..self.vertices {
                if self.child[part][vertex] != NOBODY {
                    self.child[blossom][vertex] = part;
                }
            }
        }
    }

    /// Takes an ODD blossom without dual apart; its parts on the even way stay in the tree.
    fn open(&mut self, blossom: usize) {
        let parts = self.cycle[blossom].clone();
        for &part in &parts {
            self.set_surface(part, part);
        }
        let entry = self.child[blossom][self.edges[blossom][self.parent[blossom]].u];
        let place = self.rotate_to_even(blossom, entry);
        let parts = std::mem::take(&mut self.cycle[blossom]);
        for at in (0..place).step_by(2) {
            let (odd, even) = (parts[at], parts[at + 1]);
            self.parent[odd] = self.edges[even][odd].u;
            self.label[odd] = Label::Odd;
            self.label[even] = Label::Even;
            self.closest[odd] = NOBODY;
            self.find_closest(even);
            self.enqueue(even);
        }
        self.label[entry] = Label::Odd;
        self.parent[entry] = self.parent[blossom];
        for &part in &parts[place + 1..] {
            self.label[part] = Label::Free;
            self.find_closest(part);
        }
        self.surface[blossom] = NOBODY;
    }

    /// The largest step of all duals that keeps every slack.
    fn move_duals(&mut self) {
        let mut step = i64::MAX;
        for node in self.on_surface() {
            if node >= self.vertices && self.label[node] == Label::Odd {
                step = step.min(self.dual[node] / 2);
            }
            let closest = self.closest[node];
            if closest == NOBODY {
                continue;
            }
            let slack = self.slack(self.edges[closest][node]);
            match self.label[node] {
                Label::Free => step = step.min(slack),
                Label::Even => step = step.min(slack / 2),
                Label::Odd => {}
            }
        }
        for vertex in 0..self.vertices {
            self.dual[vertex] -= step * self.sign(self.surface[vertex]);
        }
        for node in self.on_surface().into_iter().filter(|&node| node >= self.vertices) {
            self.dual[node] += 2 * step * self.sign(node);
        }
    }

    fn sign(&self, node: usize) -> i64 {
        match self.label[node] {
            Label::Free => 0,
            Label::Even => 1,
            Label::Odd => -1,
        }
    }

    fn open_spent_blossoms(&mut self) {
        for node in self.vertices..self.surface.len() {
            if self.surface[node] == node && self.label[node] == Label::Odd && self.dual[node] == 0 {
                self.open(node);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The least cost of pairing what is left, by trying everything.
    fn least(costs: &[Vec<u32>], left: &[usize]) -> u32 {
        let Some((&first, rest)) = left.split_first() else { return 0 };
        let pair = |at: usize| {
            let others: Vec<usize> = rest.iter().copied().filter(|&other| other != rest[at]).collect();
            costs[first.max(rest[at])][first.min(rest[at])] + least(costs, &others)
        };
        (0..rest.len()).map(pair).min().unwrap_or(0)
    }

    fn sum(mates: &[usize], cost: impl Fn(usize, usize) -> f64) -> f64 {
        assert!((0..mates.len()).all(|vertex| mates[mates[vertex]] == vertex && mates[vertex] != vertex));
        (0..mates.len())
            .filter(|&vertex| vertex < mates[vertex])
            .map(|vertex| cost(vertex, mates[vertex]))
            .sum()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]
        #[test]
        fn no_matching_is_cheaper(
            half in 1_usize..6, spread in 1_u32..30, numbers in prop::collection::vec(any::<u32>(), 45),
        ) {
            let vertices = 2 * half;
            let mut numbers = numbers.into_iter().cycle();
            let costs: Vec<Vec<u32>> =
                (0..vertices).map(|u| numbers.by_ref().take(u).map(|number| number % spread).collect()).collect();
            let cost = |u: usize, v: usize| f64::from(costs[u.max(v)][u.min(v)]);
            let mates = minimum_perfect_matching(vertices, cost);
            let all: Vec<usize> = (0..vertices).collect();
            prop_assert_eq!(sum(&mates, cost).round() as u32, least(&costs, &all));
        }
    }

    /// Points in a plane: the best of local search is never better.
    #[test]
    fn many_points_are_matched_better_than_by_exchanges() {
        let points: Vec<(f64, f64)> =
            (0..200_u32).map(|i| (f64::from(i * 7919 % 1009), f64::from(i * 104_729 % 997))).collect();
        let cost = |u: usize, v: usize| (points[u].0 - points[v].0).hypot(points[u].1 - points[v].1);
        let best = sum(&minimum_perfect_matching(points.len(), cost), cost);
        let mut mates: Vec<usize> = (0..points.len()).map(|vertex| vertex ^ 1).collect();
        let mut changed = true;
        while std::mem::take(&mut changed) {
            for (u, v) in (0..200).flat_map(|u| (0..200).map(move |v| (u, v))) {
                let (a, b) = (mates[u], mates[v]);
                if u != v && u != b && cost(u, a) + cost(v, b) > cost(u, v) + cost(a, b) + 1e-9 {
                    (mates[u], mates[v], mates[a], mates[b]) = (v, u, b, a);
                    changed = true;
                }
            }
        }
        assert!(best <= sum(&mates, cost) + 1e-3, "{best}");
    }
}
