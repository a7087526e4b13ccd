//! The fewest bricks that tile the spanning graph.
//!
//! A brick is a straight run of nodes. Joining two neighbours deletes the border between them; a horizontal and a
//! vertical join at one node would make an L, which is no brick. So the joins that may be made together are an
//! independent set of the graph of conflicts, which is bipartite (horizontal joins against vertical ones):
//! bricks = nodes − joins is least for a maximum independent set, the complement of a minimum vertex cover, which
//! König's theorem reads off a maximum matching (Hopcroft and Karp, O(E √V)).

use crate::spanning_graph::{Node, SpanningGraph};
use std::collections::VecDeque;
use terrain::Direction;

const NONE: u32 = u32::MAX;

/// The joins within bricks: a node and the direction of its neighbour (east or north).
pub(crate) type Tiling = Vec<(Node, Direction)>;

/// Tilings of a graph with the fewest bricks. The minimum is not unique; the two extreme ones of König's
/// construction are given: what is undecided joined horizontally, and vertically.
pub(crate) fn tile(graph: &SpanningGraph) -> [Tiling; 2] {
    let conflicts = Conflicts::new(graph);
    let matching = Matching::maximum(&conflicts);
    let sets = [matching.independent_set(&conflicts), matching.vertical_independent_set(&conflicts)];
    sets.map(|set| joins(&conflicts, &matching, &set))
}

fn joins(conflicts: &Conflicts, matching: &Matching, set: &(Vec<bool>, Vec<bool>)) -> Tiling {
    let (keep_horizontal, keep_vertical) = set;
    let joins: Tiling = (0..conflicts.horizontal.len())
        .filter(|&join| keep_horizontal[join])
        .map(|join| (conflicts.horizontal[join], Direction::East))
        .chain(
            (0..conflicts.vertical.len())
                .filter(|&join| keep_vertical[join])
                .map(|join| (conflicts.vertical[join], Direction::North)),
        )
        .collect();
    let possible = conflicts.horizontal.len() + conflicts.vertical.len();
    assert_eq!(joins.len(), possible - matching.size, "König: independent set + matching = all joins");
    joins
}

/// Horizontal and vertical joins, and which exclude each other.
struct Conflicts {
    /// West node of each horizontal join.
    horizontal: Vec<Node>,
    /// South node of each vertical join.
    vertical: Vec<Node>,
    /// Per horizontal join: vertical joins at either of its nodes.
    of_horizontal: Vec<[u32; 4]>,
    /// Per vertical join: horizontal joins at either of its nodes.
    of_vertical: Vec<[u32; 4]>,
}

impl Conflicts {
    fn new(graph: &SpanningGraph) -> Self {
        let nodes = 0..graph.len() as Node;
        let with = |direction| {
            nodes.clone().filter(move |&node| graph.neighbour(node, direction).is_some()).collect::<Vec<_>>()
        };
        let (horizontal, vertical) = (with(Direction::East), with(Direction::North));
        let mut northward = vec![NONE; graph.len()];
        for (join, &node) in vertical.iter().enumerate() {
            northward[node as usize] = join as u32;
        }
        let at = |node: Node| {
            let below =
                graph.neighbour(node, Direction::South).map_or(NONE, |south| northward[south as usize]);
            [northward[node as usize], below]
        };
        let of_horizontal = horizontal
            .iter()
            .map(|&west| {
                let east =
                    graph.neighbour(west, Direction::East).expect("a horizontal join has an east node");
                let ([a, b], [c, d]) = (at(west), at(east));
                [a, b, c, d]
            })
            .collect::<Vec<[u32; 4]>>();
        let of_vertical = Self::turned_around(&of_horizontal, vertical.len());
        Self { horizontal, vertical, of_horizontal, of_vertical }
    }

    fn turned_around(of_horizontal: &[[u32; 4]], vertical: usize) -> Vec<[u32; 4]> {
        let mut of_vertical = vec![[NONE; 4]; vertical];
        for (join, others) in of_horizontal.iter().enumerate() {
            for &other in others.iter().filter(|&&other| other != NONE) {
                let slots = &mut of_vertical[other as usize];
                let free = slots.iter().position(|&slot| slot == NONE).expect("at most four exclude a join");
                slots[free] = join as u32;
            }
        }
        of_vertical
    }

    fn of(&self, join: u32) -> impl Iterator<Item = u32> + '_ {
        self.of_horizontal[join as usize].into_iter().filter(|&other| other != NONE)
    }
}

/// A matching between horizontal and vertical joins.
struct Matching {
    of_horizontal: Vec<u32>,
    of_vertical: Vec<u32>,
    size: usize,
}

impl Matching {
    /// Hopcroft and Karp: shortest augmenting paths in phases, without recursion.
    fn maximum(conflicts: &Conflicts) -> Self {
        let mut matching = Self {
            of_horizontal: vec![NONE; conflicts.horizontal.len()],
            of_vertical: vec![NONE; conflicts.vertical.len()],
            size: 0,
        };
        let mut layer = vec![NONE; conflicts.horizontal.len()];
        while matching.lay(conflicts, &mut layer) {
            for join in 0..conflicts.horizontal.len() as u32 {
                if matching.of_horizontal[join as usize] == NONE
                    && matching.augment(conflicts, &mut layer, join)
                {
                    matching.size += 1;
                }
            }
        }
        matching
    }

    /// Breadth first layers from the free horizontal joins; whether a free vertical join is reached.
    fn lay(&self, conflicts: &Conflicts, layer: &mut [u32]) -> bool {
        let mut queue = VecDeque::new();
        for (join, layer) in layer.iter_mut().enumerate() {
            let free = self.of_horizontal[join] == NONE;
            *layer = if free { 0 } else { NONE };
            if free {
                queue.push_back(join as u32);
            }
        }
        let mut found = false;
        while let Some(join) = queue.pop_front() {
            for vertical in conflicts.of(join) {
                let next = self.of_vertical[vertical as usize];
                if next == NONE {
                    found = true;
                } else if layer[next as usize] == NONE {
                    layer[next as usize] = layer[join as usize] + 1;
                    queue.push_back(next);
                }
            }
        }
        found
    }

    /// Depth first along the layers; a join that leads nowhere is left out of the phase.
    fn augment(&mut self, conflicts: &Conflicts, layer: &mut [u32], from: u32) -> bool {
        let mut path: Vec<(u32, usize)> = vec![(from, 0)];
        while let Some(&(join, tried)) = path.last() {
            let candidate = conflicts.of_horizontal[join as usize].get(tried).copied();
            let Some(vertical) = candidate else {
                layer[join as usize] = NONE;
                path.pop();
                continue;
            };
            path.last_mut().expect("it was just looked at").1 += 1;
            if vertical == NONE {
                continue;
            }
            let next = self.of_vertical[vertical as usize];
            if next == NONE {
                self.flip(conflicts, &path);
                return true;
            }
            let deeper = layer[join as usize] != NONE && layer[next as usize] == layer[join as usize] + 1;
            if deeper {
                path.push((next, 0));
            }
        }
        false
    }

    fn flip(&mut self, conflicts: &Conflicts, path: &[(u32, usize)]) {
        for &(join, tried) in path {
            let vertical = conflicts.of_horizontal[join as usize][tried - 1];
            self.of_horizontal[join as usize] = vertical;
            self.of_vertical[vertical as usize] = join;
        }
    }

    /// König: what alternating paths from free horizontal joins reach tells the minimum vertex cover; its
    /// complement is kept.
    fn independent_set(&self, conflicts: &Conflicts) -> (Vec<bool>, Vec<bool>) {
        let mut horizontal: Vec<bool> = self.of_horizontal.iter().map(|&matched| matched == NONE).collect();
        let mut vertical = vec![false; self.of_vertical.len()];
        let mut stack: Vec<u32> =
            (0..horizontal.len() as u32).filter(|&join| horizontal[join as usize]).collect();
        while let Some(join) = stack.pop() {
            for reached in conflicts.of(join) {
                if vertical[reached as usize] {
                    continue;
                }
                vertical[reached as usize] = true;
                let next = self.of_vertical[reached as usize];
                if next != NONE && !horizontal[next as usize] {
                    horizontal[next as usize] = true;
                    stack.push(next);
                }
            }
        }
        (horizontal, vertical.iter().map(|&reached| !reached).collect())
    }

    /// The same from the free vertical joins.
    fn vertical_independent_set(&self, conflicts: &Conflicts) -> (Vec<bool>, Vec<bool>) {
        let mut vertical: Vec<bool> = self.of_vertical.iter().map(|&matched| matched == NONE).collect();
        let mut horizontal = vec![false; self.of_horizontal.len()];
        let mut stack: Vec<u32> =
            (0..vertical.len() as u32).filter(|&join| vertical[join as usize]).collect();
        while let Some(join) = stack.pop() {
            for &reached in conflicts.of_vertical[join as usize].iter().filter(|&&reached| reached != NONE) {
                if horizontal[reached as usize] {
                    continue;
                }
                horizontal[reached as usize] = true;
                let next = self.of_horizontal[reached as usize];
                if next != NONE && !vertical[next as usize] {
                    vertical[next as usize] = true;
                    stack.push(next);
                }
            }
        }
        (horizontal.iter().map(|&reached| !reached).collect(), vertical)
    }
}
