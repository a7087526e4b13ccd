//! Multi-robot connected Fermat spirals as their paper has them: isolines, isograph, tree cover, refinement.

mod augmentation;
mod distance_field;
mod fermat_spiral;
mod graph;
mod isolines;
mod loop_tree;
mod marching_squares;
mod path;
mod refinement;
mod selector;
mod splitting;
mod station_index;
mod tree_cover;
mod tree_exact;
mod tree_search;
mod walls;
mod ways;
mod weave;

pub use selector::Selector;

use graph::{Isograph, StationId};
use loop_tree::LoopTree;
use path::ClosedPath;
use selector::Selection;
use terrain::{Point, Segment};
use tree_cover::{Cover, CoverProblem};
use walls::Walls;
use ways::Ways;

/// Closed lines, the higher ground on their left, layer by layer from the border inwards.
pub type Layers = Vec<Vec<Vec<Point>>>;

/// How the tree cover is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TreeCover {
    /// Local search.
    #[default]
    Search,
    /// The search's answer, made optimal; proven where there are few isolines.
    Exact,
}

/// What to do beyond stitching.
#[derive(Debug, Clone, PartialEq)]
pub struct SpiralOptions {
    /// Where to stitch.
    pub selector: Selector,
    /// Augmentation: edges over up to so many layers; 1 for none.
    pub hops_max: u32,
    /// Whether lines are split among robots.
    pub refine: bool,
    /// How lines are given to robots.
    pub tree_cover: TreeCover,
    /// Factor on the number of moves of the search.
    pub effort: u32,
    /// Seed of all that is drawn.
    pub seed: u64,
}

/// What was planned.
#[derive(Debug, Clone, PartialEq)]
pub struct Spirals {
    /// Per robot: its closed path on the isolines, the first point repeated at the end.
    pub paths: Vec<Vec<Point>>,
    /// Per robot: the way from its start to the first point of its path.
    pub drives: Vec<Vec<Point>>,
    /// Cost of the costliest tree before refinement.
    pub trees_m: f64,
    /// No tree cover is cheaper than this.
    pub trees_bound_m: f64,
    /// Number of isolines, and of edges between them.
    pub size: [usize; 2],
}

/// Plans on the isolines of a sampled distance field, or on lines that are given.
pub fn plan_spirals(
    rings: &[Vec<Point>],
    tool_m: f64,
    starts: &[Point],
    layers: Option<&Layers>,
    options: &SpiralOptions,
) -> Spirals {
    let walls = Walls::new(rings);
    let lines = match layers {
        Some(layers) => isolines::of_rings(layers, tool_m),
        None => isolines::of_field(&walls, tool_m),
    };
    let mut graph = Isograph::new(lines, &walls, tool_m);
    augmentation::augment(&mut graph, &walls, options.hops_max);
    let entries: Vec<StationId> = starts.iter().map(|&start| entry(&graph, &walls, start)).collect();
    let roots = entries.iter().map(|&entry| graph.line_of(entry) as usize).collect();
    let problem = CoverProblem::new(&graph, roots);
    let (cover, proven) = covered(&problem, options);
    let trees_m = problem.makespan_m(&cover);
    let mut trees = loop_trees(&graph, &problem, &cover);
    let ways = Ways::new(&graph);
    let stitched = |trees: &[LoopTree]| -> Vec<ClosedPath> {
        let mut selection = Selection::new(options.selector, options.seed);
        trees.iter().map(|tree| ClosedPath::new(&graph, &ways, tree, &mut selection)).collect()
    };
    if options.refine {
        trees = refinement::refine(&graph, &trees, options.seed, |trees| {
            stitched(trees).iter().map(|path| path.length_m(&graph)).fold(0.0, f64::max)
        });
    }
    let mut paths = stitched(&trees);
    let drives = paths.iter_mut().zip(&entries).map(|(path, &entry)| drive(&graph, &ways, path, entry)).collect();
    Spirals {
        paths: paths.iter().map(|path| path.points(&graph)).collect(),
        drives,
        trees_m,
        trees_bound_m: if proven { trees_m } else { problem.lower_bound_m() },
        size: [graph.lines.len(), graph.edges.len()],
    }
}

/// The station where a robot comes onto the lines: the nearest that it can drive to straight.
fn entry(graph: &Isograph, walls: &Walls, start: Point) -> StationId {
    let distance_m = |station: StationId| (graph.point(station) - start).norm();
    let mut nearest: Vec<StationId> = (0..graph.station_count() as StationId).collect();
    nearest.sort_by(|&one, &other| distance_m(one).total_cmp(&distance_m(other)));
    let clear = |station: &&StationId| {
        walls.keeps_clear(Segment::new(start, graph.point(**station)), graph.tool_m * 0.49)
    };
    *nearest.iter().find(clear).unwrap_or(&nearest[0])
}

fn covered(problem: &CoverProblem, options: &SpiralOptions) -> (Cover, bool) {
    let found = tree_search::search(problem, options.effort, options.seed);
    let optimum = match options.tree_cover {
        TreeCover::Search => None,
        TreeCover::Exact => tree_exact::optimum(problem, &found),
    };
    let proven = optimum.is_some();
    (optimum.unwrap_or(found), proven)
}

fn loop_trees(graph: &Isograph, problem: &CoverProblem, cover: &Cover) -> Vec<LoopTree> {
    let tree = |(parents, &root): (&Vec<Option<usize>>, &usize)| {
        let lines = (0..parents.len()).filter(|&line| parents[line].is_some()).map(|line| line as u32);
        LoopTree::of_lines(graph, lines, root as u32)
    };
    cover.parents.iter().zip(&problem.roots).map(tree).collect()
}

/// Turns a path so that it begins where the robot gets to it soonest, and the way there.
fn drive(graph: &Isograph, ways: &Ways<'_>, path: &mut ClosedPath, entry: StationId) -> Vec<Point> {
    let mut on_path = vec![false; graph.station_count()];
    path.stations.iter().for_each(|&station| on_path[station as usize] = true);
    let way = ways.shortest([entry], |station| on_path[station as usize]).unwrap_or_else(|| vec![path.stations[0]]);
    let first = path.stations.iter().position(|station| way.last() == Some(station)).unwrap_or(0);
    path.stations.rotate_left(first);
    way.iter().map(|&station| graph.point(station)).collect()
}
