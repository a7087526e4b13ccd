//! Multi-robot connected Fermat spirals as their paper has them: isolines, isograph, tree cover, refinement.

mod distance_field;
mod fermat_spiral;
mod graph;
mod isolines;
mod marching_squares;
mod selector;
mod station_index;
mod walls;
mod weave;

pub use selector::Selector;

use fermat_spiral::{Loop, LoopTree, spiral};
use graph::Isograph;
use terrain::Point;

pub fn single(rings: &[Vec<Point>], tool_m: f64, selector: Selector, seed: u64) -> Vec<Point> {
    let walls = walls::Walls::new(rings);
    let lines = isolines::of_field(&walls, tool_m);
    let graph = Isograph::new(lines, &walls, tool_m);
    let parents = depth_first_tree(&graph, 0);
    let loops = (0..graph.lines.len()).map(|line| Loop::whole(&graph, line as u32)).collect();
    let tree = LoopTree { loops, parents };
    let mut selection = selector::Selection::new(selector, seed);
    let spiral = spiral(&graph, &tree, &mut selection);
    println!("lines {} edges {} apart {:?} pieces {:?}", graph.lines.len(), graph.edges.len(), spiral.apart, graph.pieces().iter().filter(|&&p| p != 0).count());
    let ring = spiral.weave.ring(0);
    spiral.weave.points(&ring)
}

fn depth_first_tree(graph: &Isograph, root: usize) -> Vec<usize> {
    let edges = graph.edges_of_lines();
    let mut parents = vec![usize::MAX; graph.lines.len()];
    parents[root] = root;
    visit(graph, &edges, root, &mut parents);
    for (line, parent) in parents.iter_mut().enumerate() {
        if *parent == usize::MAX { *parent = line; }
    }
    parents
}
fn visit(graph: &Isograph, edges: &[Vec<usize>], at: usize, parents: &mut Vec<usize>) {
    for &edge in &edges[at] {
        let other = graph.edges[edge].lines.iter().map(|&l| l as usize).find(|&l| l != at).unwrap();
        if parents[other] == usize::MAX {
            parents[other] = at;
            visit(graph, edges, other, parents);
        }
    }
}
