//! The unified connected Fermat spiral (algorithm 1): a tree of closed lines becomes one closed path.
//!
//! Depth first from the root, each line is stitched to its parent where the selector says. A step can be taken away
//! once; where all tuples of an edge of the tree are used up, the line is stitched to any other line of the path.

use super::{
    graph::{Isograph, StationId, Tuple},
    loop_tree::{LoopTree, tuples_between},
    selector::Selection,
    weave::Weave,
};

/// The loops of a tree stitched together, and those that could not be.
pub(super) struct Spiral<'a> {
    pub(super) weave: Weave<'a>,
    /// Loops that hang on no other by any open tuple.
    pub(super) apart: Vec<usize>,
}

/// Stitches the loops of a tree.
pub(super) fn spiral<'a>(graph: &'a Isograph, tree: &LoopTree, selection: &mut Selection) -> Spiral<'a> {
    let mut builder = Builder::new(graph, tree);
    let parents = tree.parents(graph);
    for child in depth_first(&parents, tree.root) {
        let parent = parents[child];
        if parent == child || !builder.attach(parent, child, selection) {
            builder.spiral.apart.push(child);
        }
    }
    // What was cut off may be reached from lines that came later.
    for child in std::mem::take(&mut builder.spiral.apart) {
        let hosts = (0..tree.loops.len()).filter(|&host| builder.line_of[host] == builder.line_of[tree.root]);
        let hosts: Vec<usize> = hosts.collect();
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
    /// The closed line that each loop has become part of, by one of its loops.
    line_of: Vec<usize>,
}

impl<'a, 't> Builder<'a, 't> {
    fn new(graph: &'a Isograph, tree: &'t LoopTree) -> Self {
        let mut weave = Weave::new(graph);
        tree.loops.iter().for_each(|part| weave.lay(&part.ring));
        let spiral = Spiral { weave, apart: Vec::new() };
        let count = tree.loops.len();
        Self { graph, tree, spiral, entries: vec![None; count], line_of: (0..count).collect() }
    }

    /// Stitches a loop to another, on a closed line of its own; false when no tuple is open.
    fn attach(&mut self, parent: usize, child: usize, selection: &mut Selection) -> bool {
        // Within one closed line a stitch would part it.
        assert_ne!(self.line_of[parent], self.line_of[child], "only separate lines are stitched");
        let [above, below] = [parent, child].map(|index| &self.tree.loops[index]);
        let open: Vec<Tuple> = tuples_between(self.graph, above, below)
            .into_iter()
            .filter(|&tuple| self.spiral.weave.allows(tuple))
            .collect();
        let picked = selection.pick(self.graph, &self.spiral.weave, &open, self.entries[parent]);
        let Some(tuple) = picked else { return false };
        self.spiral.weave.stitch(tuple);
        self.entries[child] = tuple.steps.into_iter().find(|step| below.ring.contains(step));
        let (kept, joined) = (self.line_of[parent], self.line_of[child]);
        self.line_of.iter_mut().filter(|line| **line == joined).for_each(|line| *line = kept);
        true
    }
}

/// Loops in the order of a depth first walk from the root, without it; then those that hang on nothing, each with what
/// hangs on it.
fn depth_first(parents: &[usize], root: usize) -> Vec<usize> {
    let mut children = vec![Vec::new(); parents.len()];
    let mut stack = Vec::new();
    for (child, &parent) in parents.iter().enumerate() {
        if parent == child { stack.push(child) } else { children[parent].push(child) }
    }
    stack.sort_by_key(|&top| (top == root, std::cmp::Reverse(top)));
    let mut order = Vec::with_capacity(parents.len());
    while let Some(at) = stack.pop() {
        order.push(at);
        stack.extend(children[at].iter().rev());
    }
    order.retain(|&index| index != root);
    order
}
