//! The optimum of the tree cover, proven, for graphs of few lines: a dynamic program over sets of vertices.
//!
//! `f(T)` = what it costs to cover at least T from a root: weights and a minimum spanning tree of a connected superset,
//! the cheapest one. `g_i(S)`, the best makespan with which robots 1 … i cover S, is the least over parts T of S of
//! `max(f_i(T), g_{i-1}(S − T))`. O(2ⁿ n²) for f, O(k 3ⁿ) for g; sets that cost no less than the search's answer, the
//! warm start, are not looked at.

use super::tree_cover::{Cover, CoverProblem, Vertex};

/// The most vertices that are tried: 3¹⁶ is 43 million.
pub(super) const VERTICES_MAX: usize = 16;

type Set = u32;

/// The optimum: `warm` itself where nothing is cheaper. Nothing when there are too many vertices, or no tree gets to some.
pub(super) fn optimum(problem: &CoverProblem, warm: &Cover) -> Option<Cover> {
    if problem.len() > VERTICES_MAX || problem.left_out_m(warm) > 0.0 {
        return None;
    }
    let limit_m = problem.makespan_m(warm) - 1e-9;
    let trees = Trees::new(problem);
    let mut tables: Vec<Table> = Vec::new();
    for &root in &problem.roots {
        let cover = trees.at_root(root);
        let table = match tables.last() {
            None => Table::of_first(&cover, limit_m),
            Some(before) => before.with(&cover, limit_m),
        };
        tables.push(table);
    }
    let all = tables.last()?.best_m.len() - 1;
    if tables.last()?.best_m[all] >= limit_m {
        return Some(warm.clone());
    }
    let mut left = all as Set;
    let mut parents = Vec::new();
    for (table, &root) in tables.iter().zip(&problem.roots).rev() {
        let part = table.part[left as usize];
        parents.push(trees.tree(root, trees.at_root(root).superset[part as usize]));
        left &= !part;
    }
    parents.reverse();
    Some(Cover { parents })
}

/// What robots up to one of them need to cover each set.
struct Table {
    best_m: Vec<f64>,
    /// The part that the last of them covers.
    part: Vec<Set>,
}

impl Table {
    fn of_first(cover: &FromRoot, limit_m: f64) -> Self {
        let best_m = cover.cost_m.iter().map(|&cost_m| if cost_m < limit_m { cost_m } else { f64::INFINITY });
        Self { best_m: best_m.collect(), part: (0..cover.cost_m.len() as Set).collect() }
    }

    fn with(&self, cover: &FromRoot, limit_m: f64) -> Self {
        let count = cover.cost_m.len();
        let mut table = Self { best_m: vec![f64::INFINITY; count], part: vec![0; count] };
        for part in (0..count).filter(|&part| cover.cost_m[part] < limit_m) {
            let outside = (count - 1) & !part;
            let mut rest = outside;
            loop {
                let cost_m = cover.cost_m[part].max(self.best_m[rest]);
                if cost_m < table.best_m[part | rest] {
                    table.best_m[part | rest] = cost_m;
                    table.part[part | rest] = part as Set;
                }
                if rest == 0 {
                    break;
                }
                rest = (rest - 1) & outside;
            }
        }
        table
    }
}

/// Cost of the cheapest tree from a root that covers at least a set, and its vertices.
struct FromRoot {
    cost_m: Vec<f64>,
    superset: Vec<Set>,
}

/// Cost of each set of vertices as a tree; infinite when it is not connected.
struct Trees<'a> {
    problem: &'a CoverProblem,
    cost_m: Vec<f64>,
}

impl<'a> Trees<'a> {
    fn new(problem: &'a CoverProblem) -> Self {
        let mut trees = Self { problem, cost_m: vec![f64::INFINITY; 1 << problem.len()] };
        for set in 1..trees.cost_m.len() as Set {
            let parents = trees.tree(set.trailing_zeros() as Vertex, set);
            if parents.iter().flatten().count() == set.count_ones() as usize {
                trees.cost_m[set as usize] = problem.cost_m(&parents);
            }
        }
        trees
    }

    /// A minimum spanning tree of the part of a set that hangs together with the root.
    fn tree(&self, root: Vertex, set: Set) -> Vec<Option<Vertex>> {
        let mut parents = vec![None; self.problem.len()];
        let mut price = vec![(f64::INFINITY, root); self.problem.len()];
        price[root] = (0.0, root);
        while let Some(at) = (0..parents.len())
            .filter(|&vertex| parents[vertex].is_none() && price[vertex].0.is_finite())
            .min_by(|&a, &b| price[a].0.total_cmp(&price[b].0))
        {
            parents[at] = Some(price[at].1);
            for &(next, edge_m) in &self.problem.neighbours[at] {
                if set >> next & 1 == 1 && parents[next].is_none() && edge_m < price[next].0 {
                    price[next] = (edge_m, at);
                }
            }
        }
        parents
    }

    fn at_root(&self, root: Vertex) -> FromRoot {
        let count = self.cost_m.len();
        let rooted_m = |set: usize| if set >> root & 1 == 1 { self.cost_m[set] } else { f64::INFINITY };
        let mut cover =
            FromRoot { cost_m: (0..count).map(rooted_m).collect(), superset: (0..count as Set).collect() };
        for bit in 0..self.problem.len() {
            for set in (0..count).filter(|set| set >> bit & 1 == 0) {
                let larger = set | 1 << bit;
                if cover.cost_m[larger] < cover.cost_m[set] {
                    cover.cost_m[set] = cover.cost_m[larger];
                    cover.superset[set] = cover.superset[larger];
                }
            }
        }
        cover
    }
}
