//! Local search over rooted forests: the default way to solve the tree cover.
//!
//! Begin with trees that grow, the cheapest first. Then again and again: cut a subtree off one tree and hang it on
//! another, over vertices in between where the two do not touch; what is left a leaf and covered by another tree, too,
//! is dropped. Accepted as in simulated annealing, where the energy is a p-norm of the costs whose p rises: near
//! balance it weighs the total, so that overlap goes and costs even out at once. Bounded by the number of moves.

use super::tree_cover::{Cover, CoverProblem, Vertex};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const STARTS: u64 = 4;
const MOVES: u32 = 12_000;
/// p of the norm at the beginning and in the end.
const NORM: [f64; 2] = [8.0, 100.0];
/// Temperature at the beginning and in the end, as a share of the mean cost.
const TEMPERATURE: [f64; 2] = [0.05, 0.0005];

/// The best cover of several searches.
pub(super) fn search(problem: &CoverProblem, effort: u32, seed: u64) -> Cover {
    let runs = (0..STARTS)
        .map(|start| Search::new(problem, seed.wrapping_mul(STARTS).wrapping_add(start)).run(effort));
    let best = runs.min_by(|one, other| problem.makespan_m(one).total_cmp(&problem.makespan_m(other)));
    best.expect("there is at least one start")
}

struct Search<'a> {
    problem: &'a CoverProblem,
    trees: Vec<Vec<Option<Vertex>>>,
    costs_m: Vec<f64>,
    /// Trees that each vertex belongs to.
    covered: Vec<u32>,
    rng: ChaCha8Rng,
}

impl<'a> Search<'a> {
    fn new(problem: &'a CoverProblem, seed: u64) -> Self {
        let trees = problem.roots.iter().map(|&root| {
            let mut tree = vec![None; problem.len()];
            tree[root] = Some(root);
            tree
        });
        let mut search = Self {
            problem,
            trees: trees.collect(),
            costs_m: problem.roots.iter().map(|&root| problem.weights_m[root]).collect(),
            covered: vec![0; problem.len()],
            rng: ChaCha8Rng::seed_from_u64(seed),
        };
        for &root in &problem.roots {
            search.covered[root] += 1;
        }
        search.grow();
        search
    }

    /// The cheapest tree that can takes the next vertex that nobody has; where all it touches is taken, one more tree
    /// may pass through what others have.
    fn grow(&mut self) {
        while let Some((tree, vertex, parent)) = self.next_growth() {
            self.trees[tree][vertex] = Some(parent);
            self.covered[vertex] += 1;
            self.costs_m[tree] = self.problem.cost_m(&self.trees[tree]);
        }
    }

    fn next_growth(&self) -> Option<(usize, Vertex, Vertex)> {
        let mut best: Option<(f64, usize, Vertex, Vertex)> = None;
        for (tree, parents) in self.trees.iter().enumerate() {
            for parent in (0..self.problem.len()).filter(|&vertex| parents[vertex].is_some()) {
                for &(vertex, edge_m) in &self.problem.neighbours[parent] {
                    let cost_m = self.costs_m[tree] + edge_m + self.problem.weights_m[vertex];
                    if self.covered[vertex] == 0 && best.is_none_or(|best| cost_m < best.0) {
                        best = Some((cost_m, tree, vertex, parent));
                    }
                }
            }
        }
        best.map(|(_, tree, vertex, parent)| (tree, vertex, parent))
    }

    fn run(mut self, effort: u32) -> Cover {
        let mut best = (self.makespan_m(), self.trees.clone());
        if self.trees.len() > 1 {
            let moves = MOVES.saturating_mul(effort.max(1));
            for step in 0..moves {
                let share = f64::from(step) / f64::from(moves);
                self.step(between(NORM, share), between(TEMPERATURE, share));
                if self.makespan_m() < best.0 - 1e-9 {
                    best = (self.makespan_m(), self.trees.clone());
                }
            }
        }
        Cover { parents: best.1 }
    }

    fn makespan_m(&self) -> f64 {
        self.costs_m.iter().copied().fold(0.0, f64::max)
    }

    fn step(&mut self, norm: f64, temperature: f64) {
        let Some((from, to, top)) = self.draw() else { return };
        let Some(trees) = self.transferred(from, to, top) else { return };
        let old_m = norm_of(&self.costs_m, norm);
        let mut costs_m = self.costs_m.clone();
        costs_m[from] = self.problem.cost_m(&trees[0]);
        costs_m[to] = self.problem.cost_m(&trees[1]);
        let mean_m = self.costs_m.iter().sum::<f64>() / self.costs_m.len() as f64;
        let worse = (norm_of(&costs_m, norm) - old_m) / mean_m;
        if worse <= 0.0 || self.rng.random::<f64>() < (-worse / temperature).exp() {
            self.costs_m = costs_m;
            [self.trees[from], self.trees[to]] = trees;
            self.count();
        }
    }

    /// Two trees and a vertex of the first that is not its root.
    fn draw(&mut self) -> Option<(usize, usize, Vertex)> {
        let from = self.rng.random_range(0..self.trees.len());
        let to = (from + self.rng.random_range(1..self.trees.len())) % self.trees.len();
        let root = self.problem.roots[from];
        let tree = &self.trees[from];
        let below: Vec<Vertex> =
            (0..tree.len()).filter(|&vertex| vertex != root && tree[vertex].is_some()).collect();
        (!below.is_empty()).then(|| (from, to, below[self.rng.random_range(0..below.len())]))
    }

    /// Both trees after the subtree under `top` went from one to the other; nothing when a vertex would be lost.
    fn transferred(&mut self, from: usize, to: usize, top: Vertex) -> Option<[Vec<Option<Vertex>>; 2]> {
        let subtree = subtree(&self.trees[from], top);
        let mut giver = self.trees[from].clone();
        (0..giver.len()).filter(|&vertex| subtree[vertex]).for_each(|vertex| giver[vertex] = None);
        let mut taker = self.trees[to].clone();
        let alone: Vec<bool> =
            subtree.iter().zip(&self.covered).map(|(&moves, &covered)| moves && covered == 1).collect();
        let is_open = |vertex: Vertex, taker: &[Option<Vertex>]| alone[vertex] && taker[vertex].is_none();
        while (0..taker.len()).any(|vertex| is_open(vertex, &taker)) {
            let way = self.way_to(&taker, |vertex| is_open(vertex, &taker))?;
            for pair in way.windows(2) {
                taker[pair[1]] = Some(pair[0]);
            }
        }
        self.prune(&mut taker, &giver, from, to);
        let mut kept = giver.clone();
        self.prune(&mut kept, &taker, to, from);
        Some([kept, taker])
    }

    /// The cheapest path from a tree to a vertex that is wanted, noise of ten in a hundred added.
    fn way_to(&mut self, tree: &[Option<Vertex>], wanted: impl Fn(Vertex) -> bool) -> Option<Vec<Vertex>> {
        let problem = self.problem;
        let count = problem.len();
        let noise: Vec<f64> = (0..count).map(|_| 1.0 + 0.1 * self.rng.random::<f64>()).collect();
        let mut ways = vec![f64::INFINITY; count];
        let mut before = vec![usize::MAX; count];
        let mut open = vec![true; count];
        (0..count).filter(|&vertex| tree[vertex].is_some()).for_each(|vertex| ways[vertex] = 0.0);
        loop {
            let candidates = (0..count).filter(|&vertex| open[vertex] && ways[vertex].is_finite());
            let at = candidates.min_by(|&one, &other| ways[one].total_cmp(&ways[other]))?;
            if tree[at].is_none() && wanted(at) {
                return Some(traced(&before, at));
            }
            open[at] = false;
            for &(next, edge_m) in &problem.neighbours[at] {
                let free = if wanted(next) { 0.2 } else { 1.0 };
                let way_m = ways[at] + (edge_m + free * problem.weights_m[next]) * noise[next];
                if way_m < ways[next] {
                    ways[next] = way_m;
                    before[next] = at;
                }
            }
        }
    }

    /// Drops leaves of a tree that others cover, too, the heaviest first.
    fn prune(&self, tree: &mut [Option<Vertex>], other: &[Option<Vertex>], other_index: usize, index: usize) {
        let old = [&self.trees[index], &self.trees[other_index]];
        let elsewhere = |vertex: Vertex| {
            let mine = old.iter().filter(|old| old[vertex].is_some()).count() as u32;
            self.covered[vertex] > mine || other[vertex].is_some()
        };
        loop {
            let mut children = vec![0_u32; tree.len()];
            for (vertex, &parent) in tree.iter().enumerate() {
                if let Some(parent) = parent.filter(|&parent| parent != vertex) {
                    children[parent] += 1;
                }
            }
            let leaf = |&vertex: &Vertex| {
                tree[vertex].is_some_and(|parent| parent != vertex)
                    && children[vertex] == 0
                    && elsewhere(vertex)
            };
            let weights = &self.problem.weights_m;
            let heaviest = (0..tree.len()).filter(leaf).max_by(|&a, &b| weights[a].total_cmp(&weights[b]));
            let Some(heaviest) = heaviest else { return };
            tree[heaviest] = None;
        }
    }

    fn count(&mut self) {
        for (vertex, covered) in self.covered.iter_mut().enumerate() {
            *covered = self.trees.iter().filter(|tree| tree[vertex].is_some()).count() as u32;
        }
    }
}

fn between([first, last]: [f64; 2], share: f64) -> f64 {
    first * (last / first).powf(share)
}

/// The p-norm, as a mean: of equal costs it is that cost.
fn norm_of(costs_m: &[f64], p: f64) -> f64 {
    let most_m = costs_m.iter().copied().fold(0.0, f64::max);
    let mean = costs_m.iter().map(|cost_m| (cost_m / most_m).powf(p)).sum::<f64>() / costs_m.len() as f64;
    most_m * mean.powf(1.0 / p)
}

/// Which vertices hang below and including `top`.
fn subtree(parents: &[Option<Vertex>], top: Vertex) -> Vec<bool> {
    let hangs = |mut at: Vertex| {
        while let Some(parent) = parents[at] {
            if at == top || parent == at {
                return at == top;
            }
            at = parent;
        }
        false
    };
    (0..parents.len()).map(hangs).collect()
}

fn traced(before: &[Vertex], end: Vertex) -> Vec<Vertex> {
    let mut way = vec![end];
    while let Some(&at) = before.get(way[way.len() - 1]).filter(|&&at| at != usize::MAX) {
        way.push(at);
    }
    way.reverse();
    way
}
