//! Depth first search: the tree of the first STC papers.

use crate::{
    bricks::Sided as _,
    circumnavigation::Forest,
    spanning_graph::{Node, SpanningGraph},
};
use terrain::Direction;

/// A forest grown depth first, trying directions in a fixed order.
pub(crate) fn depth_first(graph: &SpanningGraph, order: [Direction; 4]) -> Forest {
    let mut forest = Forest::new(graph);
    let mut reached = vec![false; graph.len()];
    for root in 0..graph.len() as Node {
        if reached[root as usize] {
            continue;
        }
        reached[root as usize] = true;
        let mut stack = vec![(root, 0)];
        while let Some((node, tried)) = stack.pop() {
            let Some(&direction) = order.get(tried) else { continue };
            stack.push((node, tried + 1));
            if let Some(next) = graph.neighbour(node, direction).filter(|&next| !reached[next as usize]) {
                reached[next as usize] = true;
                forest.join(node, direction, next);
                stack.push((next, 0));
            }
        }
    }
    forest
}
