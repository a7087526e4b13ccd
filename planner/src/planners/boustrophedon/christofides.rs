//! Christofides' tour: a minimum spanning tree, a minimum-weight perfect matching of its odd nodes, an Euler tour of both
//! together, and short cuts past nodes seen before. At most 1.5 times the shortest tour where distances are metric.

use crate::perfect_matching::minimum_perfect_matching;

/// The nodes in the order of the tour, the first one first. `distance` must be symmetric.
pub(super) fn christofides(nodes: usize, distance: impl Fn(usize, usize) -> f64) -> Vec<usize> {
    if nodes < 3 {
        return (0..nodes).collect();
    }
    let mut edges = spanning_tree(nodes, &distance);
    let mut degree = vec![0; nodes];
    for &(one, other) in &edges {
        degree[one] += 1;
        degree[other] += 1;
    }
    let odd: Vec<usize> = (0..nodes).filter(|&node| degree[node] % 2 == 1).collect();
    let mates = minimum_perfect_matching(odd.len(), |one, other| distance(odd[one], odd[other]));
    edges.extend((0..odd.len()).filter(|&at| at < mates[at]).map(|at| (odd[at], odd[mates[at]])));
    let mut seen = vec![false; nodes];
    let mut tour = euler_tour(nodes, &edges);
    tour.retain(|&node| !std::mem::replace(&mut seen[node], true));
    tour
}

/// Prim's algorithm.
fn spanning_tree(nodes: usize, distance: &impl Fn(usize, usize) -> f64) -> Vec<(usize, usize)> {
    let mut nearest: Vec<(f64, usize)> = (0..nodes).map(|node| (distance(0, node), 0)).collect();
    let mut open: Vec<usize> = (1..nodes).collect();
    let mut edges = Vec::new();
    while !open.is_empty() {
        let at = (0..open.len()).min_by(|&a, &b| nearest[open[a]].0.total_cmp(&nearest[open[b]].0));
        let node = open.remove(at.expect("nodes are open"));
        edges.push((nearest[node].1, node));
        for &other in &open {
            let length = distance(node, other);
            if length < nearest[other].0 {
                nearest[other] = (length, node);
            }
        }
    }
    edges
}

/// Hierholzer's algorithm, from node 0.
fn euler_tour(nodes: usize, edges: &[(usize, usize)]) -> Vec<usize> {
    let mut of: Vec<Vec<usize>> = vec![Vec::new(); nodes];
    for (number, &(one, other)) in edges.iter().enumerate() {
        of[one].push(number);
        of[other].push(number);
    }
    let mut driven = vec![false; edges.len()];
    let (mut stack, mut tour) = (vec![0], Vec::new());
    while let Some(&at) = stack.last() {
        match of[at].pop() {
            Some(edge) if !driven[edge] => {
                driven[edge] = true;
                let (one, other) = edges[edge];
                stack.push(if one == at { other } else { one });
            }
            Some(_) => {}
            None => tour.extend(stack.pop()),
        }
    }
    tour.reverse();
    tour
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn shortest(at: usize, left: &mut Vec<usize>, way: &impl Fn(usize, usize) -> f64) -> f64 {
        if left.is_empty() {
            return way(at, 0);
        }
        let mut least = f64::INFINITY;
        for number in 0..left.len() {
            let next = left.swap_remove(number);
            least = least.min(way(at, next) + shortest(next, left, way));
            left.push(next);
            let last = left.len() - 1;
            left.swap(number, last);
        }
        least
    }

    proptest! {
        #[test]
        fn a_tour_is_at_most_half_longer_than_the_shortest(
            points in prop::collection::vec((0.0..10.0_f64, 0.0..10.0_f64), 3..8),
        ) {
            let way = |one: usize, other: usize| {
                (points[one].0 - points[other].0).hypot(points[one].1 - points[other].1)
            };
            let tour = christofides(points.len(), way);
            let mut all = tour.clone();
            all.sort_unstable();
            prop_assert_eq!(all, (0..points.len()).collect::<Vec<_>>());
            let next = tour.iter().cycle().skip(1);
            let length: f64 = tour.iter().zip(next).map(|(&one, &other)| way(one, other)).sum();
            let best = shortest(0, &mut (1..points.len()).collect(), &way);
            prop_assert!(length <= 1.5 * best + 0.01, "{} {}", length, best);
        }
    }
}
