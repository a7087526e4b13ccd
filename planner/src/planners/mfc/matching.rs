//! Which robot takes which subtree: the second improvement of the paper.

use crate::matching::{Bipartite, Matching, NONE};

/// A subtree that a robot could take.
#[derive(Debug, Clone, Copy)]
pub(super) struct Offer {
    pub(super) subtree: usize,
    pub(super) robot: usize,
    /// Weight of the robot's tree with it.
    pub(super) weight: f64,
}

/// A robot for each subtree, so that the heaviest tree is as light as can be (B′ in the paper); `None` when there is no way to
/// give each subtree to a robot of its own.
pub(super) fn assign(subtrees: usize, robots: usize, offers: &[Offer]) -> Option<Vec<usize>> {
    let mut weights: Vec<f64> = offers.iter().map(|offer| offer.weight).collect();
    weights.sort_by(f64::total_cmp);
    weights.dedup();
    let mut best = matched(subtrees, robots, offers, f64::INFINITY)?;
    let (mut low, mut high) = (0, weights.len());
    while low < high {
        let middle = usize::midpoint(low, high);
        match matched(subtrees, robots, offers, weights[middle]) {
            Some(found) => {
                best = found;
                high = middle;
            }
            None => low = middle + 1,
        }
    }
    Some(best)
}

fn matched(subtrees: usize, robots: usize, offers: &[Offer], most: f64) -> Option<Vec<usize>> {
    let light = offers.iter().filter(|offer| offer.weight <= most);
    let edges: Vec<(u32, u32)> = light.map(|offer| (offer.subtree as u32, offer.robot as u32)).collect();
    let matching = Matching::maximum(&Bipartite::new(subtrees, robots, &edges));
    let all = matching.of_left.iter().all(|&robot| robot != NONE);
    all.then(|| matching.of_left.iter().map(|&robot| robot as usize).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_heaviest_tree_is_as_light_as_can_be() {
        let offer = |subtree, robot, weight| Offer { subtree, robot, weight };
        let offers = [offer(0, 0, 1.0), offer(0, 1, 5.0), offer(1, 0, 4.0), offer(1, 1, 9.0)];
        assert_eq!(assign(2, 2, &offers), Some(vec![1, 0]));
        assert_eq!(assign(2, 2, &offers[..3]), Some(vec![1, 0]));
        assert_eq!(assign(2, 1, &[offers[0], offers[2]]), None);
    }
}
