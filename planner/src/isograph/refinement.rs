//! Solution refinement (algorithm 2): lines that several robots drive are split among them, and lines of the costliest
//! robot are shared with cheaper ones.
//!
//! Each line is split once at most, with one neighbour; so it ends after at most half as many rounds as there are lines.
//! Unlike in the paper, what is shared is split at once, may go to several robots, and the whole is done several times
//! with other choices, of which the best is kept.

use super::{
    graph::{Isograph, LineId},
    loop_tree::{Loop, LoopTree},
    splitting::{Division, Splitting, norm_m},
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Runs with other choices, the first of which always takes the best one.
const RUNS: u64 = 12;
/// The share of choices that are not the best one, in later runs.
const CHANCE: f64 = 0.3;

/// Refines; the answer is the best that was met on the way, by `evaluate`, the makespan of finished paths.
pub(super) fn refine(
    graph: &Isograph,
    trees: &[LoopTree],
    seed: u64,
    evaluate: impl Fn(&[LoopTree]) -> f64,
) -> Vec<LoopTree> {
    let mut best = (evaluate(trees), trees.to_vec());
    for run in 0..RUNS {
        let rng = ChaCha8Rng::seed_from_u64(seed.wrapping_mul(RUNS).wrapping_add(run));
        let chance = if run == 0 { 0.0 } else { CHANCE };
        let mut refinement =
            Refinement { graph, trees: trees.to_vec(), used: vec![false; graph.lines.len()], rng, chance };
        while refinement.round() {
            let makespan_m = evaluate(&refinement.trees);
            if makespan_m < best.0 {
                best = (makespan_m, refinement.trees.clone());
            }
        }
    }
    best.1
}

struct Refinement<'a> {
    graph: &'a Isograph,
    trees: Vec<LoopTree>,
    /// Lines that were split, or cannot be.
    used: Vec<bool>,
    rng: ChaCha8Rng,
    chance: f64,
}

/// A split that may be made, of a line that may first be given to more trees.
struct Choice<'a> {
    splitting: Splitting<'a>,
    division: Division,
    lines: [LineId; 2],
    given_to: Vec<usize>,
}

impl<'a> Refinement<'a> {
    /// One split; false when there is nothing left to do.
    fn round(&mut self) -> bool {
        match self.most_repeated() {
            Some(line) => {
                self.used[line as usize] = true;
                let choices = self.choices(line, &[]);
                if choices.is_empty() {
                    self.leave_to_one(line);
                } else {
                    self.take(choices);
                }
                true
            }
            None => self.share_work(),
        }
    }

    /// The line that most trees have, of those not yet used.
    fn most_repeated(&self) -> Option<LineId> {
        let open = (0..self.graph.lines.len() as LineId).filter(|&line| !self.used[line as usize]);
        let counts = open.map(|line| (self.trees.iter().filter(|tree| has(tree, line)).count(), line));
        let repeated = counts.filter(|(count, _)| *count > 1);
        repeated.max_by_key(|&(count, line)| (count, std::cmp::Reverse(line))).map(|(_, line)| line)
    }

    fn costs_m(&self) -> Vec<f64> {
        self.trees.iter().map(|tree| tree.cost_m(self.graph)).collect()
    }

    /// Ways to split a line with each neighbour, after it was given to some trees.
    fn choices(&self, line: LineId, given_to: &[usize]) -> Vec<Choice<'a>> {
        let mut trees = self.trees.clone();
        for &tree in given_to {
            trees[tree].loops.push(Loop::whole(self.graph, line));
        }
        let costs_m = self.costs_m();
        let choice = |partner| {
            let lines = [line, partner];
            let splitting = Splitting::new(self.graph, &trees, &costs_m, lines)?;
            let division = splitting.best()?;
            Some(Choice { splitting, division, lines, given_to: given_to.to_vec() })
        };
        self.partners(line).filter_map(choice).collect()
    }

    /// A line that cannot be split goes to the cheapest of its trees, as far as the others hang together without.
    fn leave_to_one(&mut self, line: LineId) {
        let costs_m = self.costs_m();
        let mut holders: Vec<usize> =
            (0..self.trees.len()).filter(|&tree| has(&self.trees[tree], line)).collect();
        holders.sort_by(|&one, &other| costs_m[other].total_cmp(&costs_m[one]));
        let mut left = holders.len();
        for tree in holders {
            let without = self.trees[tree].without(self.graph, line);
            if let Some(without) = without.filter(|_| left > 1) {
                self.trees[tree] = without;
                left -= 1;
            }
        }
    }

    /// Neighbours that were not split yet.
    fn partners(&self, line: LineId) -> impl Iterator<Item = LineId> {
        let edges = self.graph.edges.iter().filter(move |edge| edge.hops == 1 && edge.lines.contains(&line));
        edges.flat_map(|edge| edge.lines).filter(move |&other| other != line && !self.used[other as usize])
    }

    /// Makes the best of the splits, or now and then another one.
    fn take(&mut self, mut choices: Vec<Choice<'a>>) {
        choices.sort_by(|one, other| one.division.norm_m.total_cmp(&other.division.norm_m));
        let mut taken = 0;
        while taken + 1 < choices.len() && self.rng.random::<f64>() < self.chance {
            taken += 1;
        }
        let Some(choice) = choices.get(taken) else { return };
        for &tree in &choice.given_to {
            self.trees[tree].loops.push(Loop::whole(self.graph, choice.lines[0]));
        }
        for line in choice.lines {
            self.used[line as usize] = true;
        }
        choice.splitting.apply(&choice.division, &mut self.trees);
    }

    /// Adding an improving repetition: a line of the costliest tree is given to others, too, and split with them. False
    /// when no such split evens out the costs.
    fn share_work(&mut self) -> bool {
        let costs_m = self.costs_m();
        let before_m = norm_m(&costs_m);
        let costliest = (0..costs_m.len()).max_by(|&one, &other| costs_m[one].total_cmp(&costs_m[other]));
        let Some(costliest) = costliest else { return false };
        let whole = |part: &&Loop| part.lines.len() == 1 && !self.used[part.lines[0] as usize];
        let lines: Vec<LineId> =
            self.trees[costliest].loops.iter().filter(whole).map(|part| part.lines[0]).collect();
        let mut choices = Vec::new();
        for line in lines {
            let cheap = self.cheaper_neighbours(line, &costs_m);
            choices.extend((1..=cheap.len()).flat_map(|count| self.choices(line, &cheap[..count])));
            choices.extend(cheap.iter().skip(1).flat_map(|&tree| self.choices(line, &[tree])));
        }
        choices.retain(|choice| choice.division.norm_m < before_m - 1e-9);
        let found = !choices.is_empty();
        self.take(choices);
        found
    }

    /// Trees that touch a line they do not have and cost less than the mean, the cheapest first.
    fn cheaper_neighbours(&self, line: LineId, costs_m: &[f64]) -> Vec<usize> {
        let mean_m = costs_m.iter().sum::<f64>() / costs_m.len() as f64;
        let edges: Vec<_> = self.graph.edges.iter().filter(|edge| edge.lines.contains(&line)).collect();
        let touches = |tree: &LoopTree| {
            tree.loops.iter().any(|part| {
                part.lines.iter().any(|own| *own != line && edges.iter().any(|edge| edge.lines.contains(own)))
            })
        };
        let cheaper = (0..self.trees.len()).filter(|&tree| {
            costs_m[tree] < mean_m && !has(&self.trees[tree], line) && touches(&self.trees[tree])
        });
        let mut cheaper: Vec<usize> = cheaper.collect();
        cheaper.sort_by(|&one, &other| costs_m[one].total_cmp(&costs_m[other]));
        cheaper
    }
}

fn has(tree: &LoopTree, line: LineId) -> bool {
    tree.loops.iter().any(|part| part.is_whole(line))
}
