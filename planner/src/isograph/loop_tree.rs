//! What one robot covers: closed lines, whole or in part, and how they hang together.

use super::graph::{Edge, Isograph, LineId, StationId, Tuple};

/// A closed line: an isoline, or parts of two that were split.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Loop {
    pub(super) ring: Vec<StationId>,
    /// The isolines that it has stations of: one when it is whole.
    pub(super) lines: Vec<LineId>,
    pub(super) length_m: f64,
}

impl Loop {
    pub(super) fn whole(graph: &Isograph, line: LineId) -> Self {
        let length_m = graph.lines[line as usize].length_m;
        Self { ring: graph.stations(line).collect(), lines: vec![line], length_m }
    }

    pub(super) fn is_whole(&self, line: LineId) -> bool {
        self.lines == [line]
    }
}

/// The loops of one robot. Any two that share stitching tuples may be joined.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LoopTree {
    pub(super) loops: Vec<Loop>,
    /// Number of the loop where the robot starts.
    pub(super) root: usize,
}

impl LoopTree {
    /// Whole isolines.
    pub(super) fn of_lines(graph: &Isograph, lines: impl Iterator<Item = LineId>, root: LineId) -> Self {
        let loops: Vec<Loop> = lines.map(|line| Loop::whole(graph, line)).collect();
        let root = loops.iter().position(|part| part.is_whole(root)).expect("a tree has its root");
        Self { loops, root }
    }

    /// The parent of each loop in the tree with the cheapest edges; the root, and a loop that hangs on nothing, is its
    /// own. Among equal edges the one with most tuples is taken.
    pub(super) fn parents(&self, graph: &Isograph) -> Vec<usize> {
        let count = self.loops.len();
        let mut parents: Vec<usize> = (0..count).collect();
        let mut price = vec![(f64::INFINITY, 0); count];
        price[self.root] = (0.0, 0);
        let mut open = vec![true; count];
        while let Some(at) = (0..count)
            .filter(|&index| open[index] && price[index].0.is_finite())
            .min_by(|&a, &b| price[a].0.total_cmp(&price[b].0).then(price[b].1.cmp(&price[a].1)))
        {
            open[at] = false;
            for next in (0..count).filter(|&index| open[index]) {
                let Some(edge) = cheapest_edge(graph, &self.loops[at], &self.loops[next]) else { continue };
                if edge.0 < price[next].0 {
                    price[next] = edge;
                    parents[next] = at;
                }
            }
        }
        parents
    }

    /// The tree without a line; nothing when that is its root or it would fall apart.
    pub(super) fn without(&self, graph: &Isograph, line: LineId) -> Option<Self> {
        let place =
            self.loops.iter().position(|part| part.is_whole(line)).filter(|&place| place != self.root)?;
        let mut rest = self.clone();
        rest.loops.remove(place);
        rest.root -= usize::from(place < self.root);
        let tops = rest.parents(graph).into_iter().enumerate().filter(|&(child, parent)| child == parent);
        (tops.count() == 1).then_some(rest)
    }

    /// Length of the loops and of what joins them; loops that hang on nothing are not charged for the way.
    pub(super) fn cost_m(&self, graph: &Isograph) -> f64 {
        let parents = self.parents(graph);
        let joints = parents.iter().enumerate().filter_map(|(child, &parent)| {
            cheapest_edge(graph, &self.loops[child], &self.loops[parent]).filter(|_| child != parent)
        });
        joints.map(|edge| edge.0).sum::<f64>() + self.loops.iter().map(|part| part.length_m).sum::<f64>()
    }
}

/// What the cheapest way to join two loops adds, and by how many tuples it can be done.
pub(super) fn cheapest_edge(graph: &Isograph, one: &Loop, other: &Loop) -> Option<(f64, usize)> {
    let inside = Membership::new(graph, one, other);
    let edges = edges_between(graph, one, other);
    let counted = edges.map(|edge| {
        let bridges = edge.bridge.filter(|&steps| inside.spans(Tuple { steps, faces: false })).iter().count();
        (edge.weight_m, bridges + edge.tuples.iter().filter(|&&tuple| inside.spans(tuple)).count())
    });
    counted.filter(|edge| edge.1 > 0).min_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)))
}

/// All tuples with a step in each loop.
pub(super) fn tuples_between(graph: &Isograph, one: &Loop, other: &Loop) -> Vec<Tuple> {
    let inside = Membership::new(graph, one, other);
    let all = edges_between(graph, one, other).flat_map(|edge| edge.tuples.iter().copied());
    all.filter(|&tuple| inside.spans(tuple)).collect()
}

fn edges_between<'a>(graph: &'a Isograph, one: &'a Loop, other: &'a Loop) -> impl Iterator<Item = &'a Edge> {
    let joins = |[a, b]: [LineId; 2]| {
        (one.lines.contains(&a) && other.lines.contains(&b))
            || (one.lines.contains(&b) && other.lines.contains(&a))
    };
    graph.edges.iter().filter(move |edge| joins(edge.lines))
}

/// Which stations two loops have. Whole lines need no list.
struct Membership<'a> {
    graph: &'a Isograph,
    loops: [&'a Loop; 2],
    parts: [Option<Vec<StationId>>; 2],
}

impl<'a> Membership<'a> {
    fn new(graph: &'a Isograph, one: &'a Loop, other: &'a Loop) -> Self {
        let part = |part: &Loop| {
            (part.lines.len() > 1).then(|| {
                let mut ring = part.ring.clone();
                ring.sort_unstable();
                ring
            })
        };
        Self { graph, loops: [one, other], parts: [part(one), part(other)] }
    }

    fn has(&self, side: usize, step: StationId) -> bool {
        match &self.parts[side] {
            None => self.loops[side].lines[0] == self.graph.line_of(step),
            // The step itself must be there, not its head alone.
            Some(ring) => {
                ring.binary_search(&step).is_ok() && ring.binary_search(&self.graph.before(step)).is_ok()
            }
        }
    }

    fn spans(&self, tuple: Tuple) -> bool {
        let [p, q] = tuple.steps;
        (self.has(0, p) && self.has(1, q)) || (self.has(0, q) && self.has(1, p))
    }
}
