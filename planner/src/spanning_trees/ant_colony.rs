//! Ant colony optimisation: ants grow trees depth first, drawn by the pheromone of good trees and by going straight on.
//!
//! After Gao and others (as cited and compared in the TMSTC* paper), whose parameters are not printed there: ours are
//! below. Each ant starts at a random node of each piece; at every node the next edge is drawn with probability
//! pheromone^α · attraction^β. After each round pheromone evaporates, and the best tree so far gains some.

use crate::{
    bricks::Sided as _,
    circumnavigation::Forest,
    spanning_graph::{Node, SpanningGraph},
};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use terrain::Direction;

const ROUNDS: usize = 40;
const ANTS: usize = 10;
/// Exponent of the pheromone.
const ALPHA: f64 = 1.0;
/// How much better straight on is than a corner (attraction to the power of β).
const STRAIGHT: f64 = 8.0;
/// Share of the pheromone that is left after a round.
const LEFT: f64 = 0.9;
const DEPOSIT: f64 = 1.0;

/// The tree with the fewest turns that the colony found.
pub(crate) fn ant_colony(graph: &SpanningGraph, seed: u64) -> Forest {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut pheromone = vec![[1.0_f64; 4]; graph.len()];
    let mut best = grow(graph, &pheromone, &mut rng);
    for _ in 0..ROUNDS {
        for _ in 0..ANTS {
            let found = grow(graph, &pheromone, &mut rng);
            if found.turns() < best.turns() {
                best = found;
            }
        }
        for (node, edges) in pheromone.iter_mut().enumerate() {
            for direction in Direction::ALL {
                let deposit = if best.has(node as Node, direction) { DEPOSIT } else { 0.0 };
                edges[direction as usize] = LEFT * edges[direction as usize] + deposit;
            }
        }
    }
    best
}

/// One ant's trees, depth first from a random node of each piece.
fn grow(graph: &SpanningGraph, pheromone: &[[f64; 4]], rng: &mut ChaCha8Rng) -> Forest {
    let mut forest = Forest::new(graph);
    let mut reached = vec![false; graph.len()];
    let first = if graph.len() == 0 { 0 } else { rng.random_range(0..graph.len()) };
    for root in (first..graph.len()).chain(0..first) {
        if std::mem::replace(&mut reached[root], true) {
            continue;
        }
        let mut stack: Vec<(Node, Option<Direction>)> = vec![(root as Node, None)];
        while let Some(&(node, came)) = stack.last() {
            let open = |direction: &Direction| {
                graph.neighbour(node, *direction).is_some_and(|next| !reached[next as usize])
            };
            let weight = |direction: Direction| {
                let straight = if came == Some(direction) { STRAIGHT } else { 1.0 };
                pheromone[node as usize][direction as usize].powf(ALPHA) * straight
            };
            let weights: Vec<(Direction, f64)> =
                Direction::ALL.into_iter().filter(open).map(|way| (way, weight(way))).collect();
            let Some(direction) = draw(&weights, rng) else {
                stack.pop();
                continue;
            };
            let next = graph.neighbour(node, direction).expect("open directions have a neighbour");
            reached[next as usize] = true;
            forest.join(node, direction, next);
            stack.push((next, Some(direction)));
        }
    }
    forest
}

fn draw(weights: &[(Direction, f64)], rng: &mut ChaCha8Rng) -> Option<Direction> {
    let all: f64 = weights.iter().map(|&(_, weight)| weight).sum();
    let mut left = rng.random::<f64>() * all;
    for &(direction, weight) in weights {
        left -= weight;
        if left < 0.0 {
            return Some(direction);
        }
    }
    weights.last().map(|&(direction, _)| direction)
}
