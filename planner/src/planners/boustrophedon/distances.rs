//! Ways between the ends of cell paths.
//!
//! From each end one search finds the ways to the ends nearest to it. Farther ones are reached through those: the
//! shortest line of ways in the graph of near ends, which is at most a little longer than the shortest way. An all-pairs
//! table of searches over the floor would take minutes where this takes a second.

use crate::transfers::{Targets, Transfers};
use std::{cmp::Reverse, collections::BinaryHeap};
use terrain::Point;

/// Ends of other cells that a search looks for.
const NEAR: usize = 16;

/// Lengths of ways between points, metres; symmetric.
#[derive(Debug, Clone)]
pub(super) struct Distances {
    count: usize,
    table: Vec<f32>,
}

impl Distances {
    pub(super) fn new(transfers: &mut Transfers<'_, '_>, points: &[Point]) -> Self {
        let targets = Targets::new(transfers.space(), points.to_vec());
        let mut graph = Graph { near: vec![Vec::new(); points.len()] };
        for (from, &point) in points.iter().enumerate() {
            graph.add(
                from,
                transfers.ways_to_nearest(point, &targets, |to| to / 4 != from / 4, f64::MAX, NEAR),
            );
        }
        // Crowds of ends that lie far apart know nothing of each other yet.
        let mut most = NEAR;
        while let Some(lonely) = graph.unreached().filter(|_| most < points.len()) {
            most *= 4;
            for from in [lonely, 0] {
                graph.add(from, transfers.ways_to_nearest(points[from], &targets, |_| true, f64::MAX, most));
            }
        }
        Self { count: points.len(), table: graph.closure() }
    }

    #[cfg(test)]
    pub(super) fn from_table(count: usize, table: Vec<f32>) -> Self {
        Self { count, table }
    }

    /// Length of the way between two ends; infinite where there is none.
    pub(super) fn between(&self, from: usize, to: usize) -> f64 {
        f64::from(self.table[from * self.count + to])
    }
}

struct Graph {
    near: Vec<Vec<(usize, f32)>>,
}

impl Graph {
    fn add(&mut self, from: usize, ways: Vec<(usize, crate::transfers::Way)>) {
        for (to, way) in ways.into_iter().filter(|(to, _)| *to != from) {
            let length_m = way.length_m as f32;
            self.near[from].push((to, length_m));
            self.near[to].push((from, length_m));
        }
    }

    /// A point that is not joined to the first one.
    fn unreached(&self) -> Option<usize> {
        let mut reached = vec![false; self.near.len()];
        let mut stack = vec![0];
        *reached.first_mut()? = true;
        while let Some(at) = stack.pop() {
            for &(next, _) in &self.near[at] {
                if !std::mem::replace(&mut reached[next], true) {
                    stack.push(next);
                }
            }
        }
        reached.iter().position(|reached| !reached)
    }

    fn closure(&self) -> Vec<f32> {
        let mut table = Vec::with_capacity(self.near.len() * self.near.len());
        (0..self.near.len()).for_each(|from| table.extend(self.from(from)));
        // The same sum in another order differs in the last digit.
        let count = self.near.len();
        for (one, other) in (0..count).flat_map(|one| (0..one).map(move |other| (one, other))) {
            table[other * count + one] = table[one * count + other];
        }
        table
    }

    /// Dijkstra's algorithm.
    fn from(&self, source: usize) -> Vec<f32> {
        let mut length = vec![f32::INFINITY; self.near.len()];
        length[source] = 0.0;
        // Lengths are not negative: their bits are ordered as they are.
        let mut queue = BinaryHeap::from([Reverse((0_u32, source))]);
        while let Some(Reverse((bits, at))) = queue.pop() {
            let so_far = f32::from_bits(bits);
            if so_far > length[at] {
                continue;
            }
            for &(next, way) in &self.near[at] {
                if so_far + way < length[next] {
                    length[next] = so_far + way;
                    queue.push(Reverse(((so_far + way).to_bits(), next)));
                }
            }
        }
        length
    }
}
