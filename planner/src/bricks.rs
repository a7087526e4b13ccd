//! The fewest bricks that tile the spanning graph.
//!
//! A brick is a straight run of nodes. Joining two neighbours deletes the border between them; a horizontal and a
//! vertical join at one node would make an L, which is no brick. So the joins that may be made together are an
//! independent set of the graph of conflicts, which is bipartite (horizontal joins against vertical ones):
//! bricks = nodes − joins is least for a maximum independent set, the complement of a minimum vertex cover, which
//! König's theorem reads off a maximum matching (Hopcroft and Karp, O(E √V)).

use crate::{
    matching::{Bipartite, Matching},
    spanning_graph::Node,
};
use terrain::Direction;

/// Nodes with at most one neighbour on each side.
pub(crate) trait Sided {
    /// Number of nodes.
    fn len(&self) -> usize;
    /// The neighbour of a node on a side.
    fn neighbour(&self, node: Node, side: Direction) -> Option<Node>;
}

/// The joins within bricks: a node and the direction of its neighbour (east or north).
pub(crate) type Tiling = Vec<(Node, Direction)>;

/// Tilings of a graph with the fewest bricks. The minimum is not unique; the two extreme ones of König's
/// construction are given: what is undecided joined horizontally, and vertically.
pub(crate) fn tile(graph: &impl Sided) -> [Tiling; 2] {
    let conflicts = Conflicts::new(graph);
    let matching = Matching::maximum(&conflicts.graph);
    let sets =
        [matching.independent_set(&conflicts.graph), matching.independent_set_of_right(&conflicts.graph)];
    sets.map(|(horizontal, vertical)| {
        let joins = conflicts.joins(&horizontal, &vertical);
        let possible = conflicts.horizontal.len() + conflicts.vertical.len();
        assert_eq!(joins.len(), possible - matching.size, "König: independent set + matching = all joins");
        joins
    })
}

/// Horizontal and vertical joins, and which exclude each other.
struct Conflicts {
    /// West node of each horizontal join.
    horizontal: Vec<Node>,
    /// South node of each vertical join.
    vertical: Vec<Node>,
    /// Horizontal joins on the left, vertical ones on the right.
    graph: Bipartite,
}

impl Conflicts {
    fn new(graph: &impl Sided) -> Self {
        let nodes = 0..graph.len() as Node;
        let with = |direction| {
            nodes.clone().filter(move |&node| graph.neighbour(node, direction).is_some()).collect::<Vec<_>>()
        };
        let (horizontal, vertical) = (with(Direction::East), with(Direction::North));
        let mut northward: Vec<Option<u32>> = vec![None; graph.len()];
        for (join, &node) in vertical.iter().enumerate() {
            northward[node as usize] = Some(join as u32);
        }
        let at = |node: Node| {
            let below = graph.neighbour(node, Direction::South);
            [northward[node as usize], below.and_then(|south| northward[south as usize])]
        };
        let mut edges = Vec::new();
        for (join, &west) in horizontal.iter().enumerate() {
            let east = graph.neighbour(west, Direction::East).expect("a horizontal join has an east node");
            let excluded = at(west).into_iter().chain(at(east)).flatten();
            edges.extend(excluded.map(|vertical| (join as u32, vertical)));
        }
        let graph = Bipartite::new(horizontal.len(), vertical.len(), &edges);
        Self { horizontal, vertical, graph }
    }

    fn joins(&self, horizontal: &[bool], vertical: &[bool]) -> Tiling {
        let kept = |joins: &[Node], keep: &[bool], direction| {
            let kept = joins.iter().zip(keep).filter(|&(_, &keep)| keep);
            kept.map(|(&node, _)| (node, direction)).collect::<Tiling>()
        };
        let mut all = kept(&self.horizontal, horizontal, Direction::East);
        all.extend(kept(&self.vertical, vertical, Direction::North));
        all
    }
}
