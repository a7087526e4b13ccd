//! The unified connected Fermat spiral (algorithm 1): a tree of closed lines becomes one closed path.
//!
//! Depth first from the root, each line is stitched to its parent where the selector says. A step can be taken away
//! once; where all tuples of an edge of the tree are used up, the line is stitched to any other line of the path.

use super::{
    graph::{Isograph, LineId, StationId, Tuple},
    selector::Selection,
    weave::Weave,
};

/// A closed line of a tree: an isoline, or a part of two of them.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Loop {
    pub(super) ring: Vec<StationId>,
    /// The isolines that it has stations of.
    pub(super) lines: Vec<LineId>,
}

impl Loop {
    pub(super) fn whole(graph: &Isograph, line: LineId) -> Self {
        Self { ring: graph.stations(line).collect(), lines: vec![line] }
    }
}

/// What one robot covers.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LoopTree {
    pub(super) loops: Vec<Loop>,
    /// Parent of each; that of the root is itself.
    pub(super) parents: Vec<usize>,
}

/// The loops of a tree stitched together, and those that could not be.
pub(super) struct Spiral<'a> {
    pub(super) weave: Weave<'a>,
    /// Loops that hang on no other by any open tuple.
    pub(super) apart: Vec<usize>,
}

/// Stitches the loops of a tree.
pub(super) fn spiral<'a>(graph: &'a Isograph, tree: &LoopTree, selection: &mut Selection) -> Spiral<'a> {
    let mut builder = Builder::new(graph, tree);
    for child in depth_first(&tree.parents) {
        let parent = tree.parents[child];
        if parent == child {
            builder.connected.push(child);
        } else if !builder.attach(parent, child, selection) {
            builder.spiral.apart.push(child);
        }
    }
    // What was cut off may be reached from lines that came later.
    for child in std::mem::take(&mut builder.spiral.apart) {
        let hosts = builder.connected.clone();
        if !hosts.into_iter().any(|host| builder.attach(host, child, selection)) {
            builder.spiral.apart.push(child);
        }
    }
    builder.spiral
}

struct Builder<'a, 't> {
    graph: &'a Isograph,
    tree: &'t LoopTree,
    spiral: Spiral<'a>,
    /// Where each loop was entered.
    entries: Vec<Option<StationId>>,
    connected: Vec<usize>,
}

impl<'a, 't> Builder<'a, 't> {
    fn new(graph: &'a Isograph, tree: &'t LoopTree) -> Self {
        let mut weave = Weave::new(graph);
        tree.loops.iter().for_each(|part| weave.lay(&part.ring));
        let spiral = Spiral { weave, apart: Vec::new() };
        Self { graph, tree, spiral, entries: vec![None; tree.loops.len()], connected: Vec::new() }
    }

    /// Stitches a loop to one that is connected; false when no tuple is open.
    fn attach(&mut self, parent: usize, child: usize, selection: &mut Selection) -> bool {
        let [above, below] = [parent, child].map(|index| &self.tree.loops[index]);
        let open: Vec<Tuple> = tuples_between(self.graph, above, below)
            .into_iter()
            .filter(|&tuple| self.spiral.weave.allows(tuple))
            .collect();
        let picked = selection.pick(self.graph, &self.spiral.weave, &open, self.entries[parent]);
        let Some(tuple) = picked else { return false };
        self.spiral.weave.stitch(tuple);
        self.entries[child] = tuple.steps.into_iter().find(|step| below.ring.contains(step));
        self.connected.push(child);
        true
    }
}

/// All tuples with a step in each loop.
pub(super) fn tuples_between(graph: &Isograph, one: &Loop, other: &Loop) -> Vec<Tuple> {
    let joins = |lines: [LineId; 2]| {
        let [a, b] = lines.map(|line| (one.lines.contains(&line), other.lines.contains(&line)));
        (a.0 && b.1) || (a.1 && b.0)
    };
    let edges = graph.edges.iter().filter(|edge| joins(edge.lines));
    let mut places = vec![0_u8; graph.station_count()];
    one.ring.iter().for_each(|&station| places[station as usize] |= 1);
    other.ring.iter().for_each(|&station| places[station as usize] |= 2);
    let spans = |tuple: &Tuple| tuple.steps.iter().map(|&step| places[step as usize]).sum::<u8>() == 3;
    edges.flat_map(|edge| edge.tuples.iter().copied().filter(spans)).collect()
}

/// Loops in the order of a depth first walk from the root.
fn depth_first(parents: &[usize]) -> Vec<usize> {
    let mut children = vec![Vec::new(); parents.len()];
    let mut stack = Vec::new();
    for (child, &parent) in parents.iter().enumerate() {
        if parent == child { stack.push(child) } else { children[parent].push(child) }
    }
    let mut order = Vec::with_capacity(parents.len());
    while let Some(at) = stack.pop() {
        order.push(at);
        stack.extend(children[at].iter().rev());
    }
    order
}
