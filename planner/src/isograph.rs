//! MCFS as its paper has it: multi-robot connected Fermat spirals on an isograph.
//!
//! **Problem.** Cover a polygon with holes by k round tools; each robot drives one smooth closed path, the longest as
//! short as can be.
//! **Idea.** Isolines at equal distances from the border are the vertices of the isograph, with an edge where two can be
//! stitched. A min-max rooted tree cover gives each robot a tree of isolines; stitched along the tree they become one
//! path, a connected Fermat spiral. Augmentation adds edges that skip layers, so that a robot need not cover what it only
//! passes. Refinement splits pairs of isolines into as many closed lines as robots share them. So robots are balanced by
//! parts of lines, though the tree cover knows whole lines only.
//!
//! ```text
//!   polygon ─▶ isolines ─▶ isograph ─▶ augmentation ─▶ tree cover ─▶ refinement ─▶ connected Fermat spirals
//!              lines of     edges,      edges that      whole lines   parts of      one closed path
//!              stations     tuples      skip layers     per robot     two lines     per robot
//! ```
//!
//! **Guarantee.** Every isoline that some robot can get to lies on a path. With [`TreeCover::Exact`] the cover is optimal for
//! up to 16 isolines. Paths keep the isolines' distance from the border, connections half a tool.
//! **Complexity.** O(n log n) for n stations and samples of the field; O(moves · v²) for the search over v isolines;
//! O(k! · n) for each split among k robots (24 orders at most), v splits; O(2ᵛ v² + k 3ᵛ) for the proof.
//! **Paper.** J. Tang, H. Ma: Multi-robot connected Fermat spiral coverage. International Conference on Automated Planning
//! and Scheduling (ICAPS), 2024.
//! **Departures.** Contours come from a field of signed distances at a quarter of the tool's width that reaches beyond the
//! border, so they are closed and where they should be. A station is a number, never compared by coordinates. Where the
//! isograph falls apart, lines of one layer that face each other are stitched, and what is left is joined by straight ways
//! that are driven twice. The cover is found by local search, or by a dynamic program, in place of a mixed-integer solver. An
//! edge over k layers is charged 2 (k − 1) l, what its connections add. A split chooses among measured-out divisions in place
//! of all k-tuples, by a p-norm of all robots' costs in place of the deviation of those concerned. Refinement is done several
//! times with other choices. Equation 3 says arg max of the added curvature, the text says minimise: the maximum turns more
//! than random choice on every instance (`oxplow bench mcfs`), so it is the minimum.
//! **Symbols.** `l`: tool width, `tool_m`. `I_v`: [`isolines::Isoline`]. `O_{u,v}`: tuples of [`graph::Edge`]. `B(p)`:
//! `before`. δ: `hops_max`. π: [`path::ClosedPath`]. `T_i`: [`loop_tree::LoopTree`]. `f`: [`Selector`].

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

use crate::mcfs::{PolygonError, PolygonInstance, numbered_tracks};
use graph::{Isograph, StationId};
use isolines::Isoline;
use loop_tree::LoopTree;
use path::ClosedPath;
use schemars::JsonSchema;
use selector::Selection;
use serde::{Deserialize, Serialize};
use terrain::{Point, Segment};
use thiserror::Error;
use tree_cover::{Cover, CoverProblem};
use walls::Walls;
use ways::Ways;

/// Where isolines come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Isolines {
    /// Exact offsets of the polygon, the first half a tool (or a body) from the border.
    Exact,
    /// Contours of a sampled distance field, the first a whole tool from the border: the paper's.
    #[default]
    MarchingSquares,
}

/// How the tree cover is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TreeCover {
    /// Local search.
    #[default]
    Search,
    /// The search's answer, made optimal and proven so, where there are at most 16 isolines.
    #[serde(alias = "mip")]
    Exact,
}

/// How to plan.
#[derive(Debug, Clone, PartialEq)]
pub struct SpiralOptions {
    /// Where isolines come from.
    pub isolines: Isolines,
    /// Where they are stitched.
    pub selector: Selector,
    /// δ: edges over up to so many layers are added; none for 1.
    pub hops_max: u32,
    /// Whether isolines are split among robots.
    pub refine: bool,
    /// How isolines are given to robots.
    pub tree_cover: TreeCover,
    /// Factor on the moves of the search.
    pub effort: u32,
    /// Seed of all that is drawn.
    pub seed: u64,
}

impl Default for SpiralOptions {
    /// What the paper calls BOTH.
    fn default() -> Self {
        Self {
            isolines: Isolines::default(),
            selector: Selector::default(),
            hops_max: 4,
            refine: true,
            tree_cover: TreeCover::default(),
            effort: 1,
            seed: 0,
        }
    }
}

/// Why there are no paths.
#[derive(Debug, Clone, Error, PartialEq)]
pub enum SpiralError {
    /// The instance is not sound.
    #[error(transparent)]
    Polygon(#[from] PolygonError),
    /// Nowhere is it wide enough for a line.
    #[error(
        "no isoline of {length_m:.3} m or more lies between the walls: take a narrower tool, or exact isolines"
    )]
    NoIsoline {
        /// The shortest that counts.
        length_m: f64,
    },
    /// A robot that cannot drive to any isoline straight.
    #[error("robot {robot} sees no isoline from its start: move it, or take exact isolines")]
    CutOff {
        /// Number of the robot.
        robot: usize,
    },
}

/// What was planned.
#[derive(Debug, Clone, PartialEq)]
pub struct Spirals {
    /// Per robot: its closed path, the first point repeated at the end.
    pub paths: Vec<Vec<Point>>,
    /// Per robot: the way from its start to the first point of its path.
    pub drives: Vec<Vec<Point>>,
    /// Number of isolines, and of edges between them.
    pub size: [usize; 2],
    /// Cost of the costliest tree before refinement.
    pub trees_m: f64,
    /// No cover by whole isolines is cheaper.
    pub trees_bound_m: f64,
    /// Length of the isolines that no robot can get to.
    pub left_out_m: f64,
}

impl Spirals {
    /// Per robot: from its start over its path and back.
    pub fn round_trips(&self) -> Vec<Vec<Point>> {
        let trip = |(drive, path): (&Vec<Point>, &Vec<Point>)| {
            let way = drive.iter().chain(path.iter().skip(1));
            way.chain(drive.iter().rev().skip(1)).copied().collect()
        };
        self.drives.iter().zip(&self.paths).map(trip).collect()
    }
}

/// Plans one closed path per robot.
///
/// # Errors
///
/// [`SpiralError`]; what no robot can get to is no error but said in the answer.
pub fn plan_spirals(instance: &PolygonInstance, options: &SpiralOptions) -> Result<Spirals, SpiralError> {
    instance.check()?;
    let tool_m = instance.tool_width_m;
    let walls = Walls::new(&rings(instance));
    let lines = isolines_of(instance, &walls, options.isolines);
    if lines.is_empty() {
        return Err(SpiralError::NoIsoline { length_m: isolines::LENGTH_MIN * tool_m });
    }
    let mut graph = Isograph::new(lines, &walls, tool_m, instance.clearance_m());
    augmentation::augment(&mut graph, &walls, options.hops_max);
    let starts = instance.starts.iter().enumerate();
    let entries: Vec<StationId> = starts
        .map(|(robot, &start)| entry(&graph, &walls, start).ok_or(SpiralError::CutOff { robot }))
        .collect::<Result<_, _>>()?;
    Ok(Planning { graph: &graph, ways: Ways::new(&graph), starts: &instance.starts, options }.plan(&entries))
}

fn rings(instance: &PolygonInstance) -> Vec<Vec<Point>> {
    let corners = |ring: &geo::LineString<f64>| ring.0[1..].iter().map(|at| Point::new(at.x, at.y)).collect();
    instance.rings().map(|(_, ring)| corners(ring)).collect()
}

fn isolines_of(instance: &PolygonInstance, walls: &Walls, kind: Isolines) -> Vec<Isoline> {
    match kind {
        Isolines::MarchingSquares => isolines::of_field(walls, instance.tool_width_m, instance.clearance_m()),
        Isolines::Exact => isolines::of_rings(numbered_tracks(instance).into_iter(), instance.tool_width_m),
    }
}

/// The station where a robot comes onto the lines: the nearest that it can drive to straight.
fn entry(graph: &Isograph, walls: &Walls, start: Point) -> Option<StationId> {
    let distance_m = |station: StationId| (graph.point(station) - start).norm();
    let mut nearest: Vec<StationId> = (0..graph.station_count() as StationId).collect();
    nearest.sort_by(|&one, &other| distance_m(one).total_cmp(&distance_m(other)));
    let clear = |&station: &StationId| {
        walls.keeps_clear(Segment::new(start, graph.point(station)), graph.clearance_m)
    };
    nearest.into_iter().find(clear)
}

/// An isograph, and the robots on it.
struct Planning<'a> {
    graph: &'a Isograph,
    ways: Ways<'a>,
    starts: &'a [Point],
    options: &'a SpiralOptions,
}

impl Planning<'_> {
    fn plan(&self, entries: &[StationId]) -> Spirals {
        let graph = self.graph;
        let roots = entries.iter().map(|&entry| graph.line_of(entry) as usize).collect();
        let problem = CoverProblem::new(graph, roots);
        let (cover, proven) = self.cover(&problem);
        let trees_m = problem.makespan_m(&cover);
        let mut trees = loop_trees(graph, &problem, &cover);
        if self.options.refine {
            let makespan_m = |trees: &[LoopTree]| {
                self.stitched(trees).iter().map(|path| path.length_m(graph)).fold(0.0, f64::max)
            };
            trees = refinement::refine(graph, &trees, self.options.seed, makespan_m);
        }
        let mut paths = self.stitched(&trees);
        let drives = paths.iter_mut().zip(entries).enumerate();
        let drives = drives.map(|(robot, (path, &entry))| self.drive(robot, path, entry)).collect();
        Spirals {
            paths: paths.iter().map(|path| path.points(graph)).collect(),
            drives,
            size: [graph.lines.len(), graph.edges.len()],
            trees_m,
            trees_bound_m: if proven { trees_m } else { problem.lower_bound_m() },
            left_out_m: problem.left_out_m(&cover),
        }
    }

    fn cover(&self, problem: &CoverProblem) -> (Cover, bool) {
        let found = tree_search::search(problem, self.options.effort, self.options.seed);
        let optimum = match self.options.tree_cover {
            TreeCover::Search => None,
            TreeCover::Exact => tree_exact::optimum(problem, &found),
        };
        let proven = optimum.is_some();
        (optimum.unwrap_or(found), proven)
    }

    fn stitched(&self, trees: &[LoopTree]) -> Vec<ClosedPath> {
        let mut selection = Selection::new(self.options.selector, self.options.seed);
        trees.iter().map(|tree| ClosedPath::new(self.graph, &self.ways, tree, &mut selection)).collect()
    }

    /// Turns a path so that it begins where the robot gets to it soonest, and the way there.
    fn drive(&self, robot: usize, path: &mut ClosedPath, entry: StationId) -> Vec<Point> {
        let mut on_path = vec![false; self.graph.station_count()];
        path.stations.iter().for_each(|&station| on_path[station as usize] = true);
        let way = self.ways.shortest([entry], |station| on_path[station as usize]).unwrap_or_default();
        let first = path.stations.iter().position(|station| way.last() == Some(station));
        path.stations.rotate_left(first.unwrap_or(0));
        let mut points = vec![self.starts[robot]];
        points.extend(self.graph.points_along(&way));
        points
    }
}

fn loop_trees(graph: &Isograph, problem: &CoverProblem, cover: &Cover) -> Vec<LoopTree> {
    let tree = |(parents, &root): (&Vec<Option<usize>>, &usize)| {
        let lines = (0..parents.len()).filter(|&line| parents[line].is_some()).map(|line| line as u32);
        LoopTree::of_lines(graph, lines, root as u32)
    };
    cover.parents.iter().zip(&problem.roots).map(tree).collect()
}

#[cfg(test)]
mod tests;
