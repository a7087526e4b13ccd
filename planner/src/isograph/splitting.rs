//! Pairwise isovertices splitting: two neighbouring lines u and v become as many closed lines as robots share them.
//!
//! ```text
//!   u ──▶───────┐ ┌───▶──────┐ ┌───▶──      Each stitch between u and v cuts the ring of ground that they enclose: k of
//!               │ │          │ │            them make k closed lines, one for each robot, each a piece of u, a piece of v
//!   v ──────────┘ └──────────┘ └──────      and two connections.
//! ```
//!
//! The paper tries every choice of k tuples. Here, for each order of the robots around the ring and a number of places to
//! begin, the pieces are measured out so that the robots' costs even out (water filling); the best are improved by moving
//! one cut at a time. So the work grows with the number of tuples, not with its k-th power.

use super::{
    graph::{Isograph, LineId, StationId, Tuple},
    loop_tree::{Loop, LoopTree, cheapest_edge},
};

/// Places to begin that are tried for each order of robots.
const BEGINNINGS: usize = 40;
/// Orders that are tried: all for up to five robots.
const ORDERS_MAX: usize = 24;
/// Divisions that are improved step by step.
const IMPROVED: usize = 6;
/// p of the norm by which costs are compared.
const NORM: f64 = 30.0;
/// A piece has at least so many stations of each line.
const STATIONS_MIN: usize = 2;

/// A robot's tree without the lines to be split.
struct Share {
    tree: usize,
    /// Of all that is not to be split.
    cost_m: f64,
    /// Per group of loops that must be joined to the piece: the gaps between cuts where this can be done.
    groups: Vec<Vec<usize>>,
}

/// A pair of lines, the places where they may be cut, and who shares them.
pub(super) struct Splitting<'a> {
    graph: &'a Isograph,
    lines: [LineId; 2],
    /// Possible cuts in the order in which both lines run.
    cuts: Vec<Tuple>,
    /// Per cut: length of both lines from the first cut on.
    along_m: Vec<f64>,
    total_m: f64,
    shares: Vec<Share>,
    /// Costs of the robots that do not share the lines.
    others_m: Vec<f64>,
}

/// Who takes which piece: shares in their order around the ring, and the cut at which each begins.
#[derive(Debug, Clone)]
pub(super) struct Division {
    order: Vec<usize>,
    begins: Vec<usize>,
    /// What the costs of all robots amount to, ways between loops included.
    pub(super) norm_m: f64,
}

impl<'a> Splitting<'a> {
    /// Nothing when the lines cannot be cut often enough.
    pub(super) fn new(
        graph: &'a Isograph,
        trees: &[LoopTree],
        costs_m: &[f64],
        lines: [LineId; 2],
    ) -> Option<Self> {
        let holds =
            |tree: &LoopTree| tree.loops.iter().any(|part| lines.iter().any(|&line| part.is_whole(line)));
        let sharers: Vec<usize> = (0..trees.len()).filter(|&tree| holds(&trees[tree])).collect();
        let cuts = cuts(graph, lines);
        if sharers.len() < 2 || cuts.len() < sharers.len() * STATIONS_MIN {
            return None;
        }
        let along_m = along_m(graph, lines, &cuts);
        let total_m = lines.iter().map(|&line| graph.lines[line as usize].length_m).sum();
        let others = (0..trees.len()).filter(|tree| !sharers.contains(tree));
        let others_m = others.map(|tree| costs_m[tree]).collect();
        let mut splitting = Self { graph, lines, cuts, along_m, total_m, shares: Vec::new(), others_m };
        splitting.shares = sharers.into_iter().map(|tree| splitting.share(tree, &trees[tree])).collect();
        Some(splitting)
    }

    fn share(&self, index: usize, tree: &LoopTree) -> Share {
        let others: Vec<&Loop> =
            tree.loops.iter().filter(|part| !self.lines.iter().any(|&line| part.is_whole(line))).collect();
        let mut cost_m = others.iter().map(|part| part.length_m).sum();
        let mut groups = Vec::new();
        for group in groups_of(self.graph, &others) {
            let (gaps, joint_m) = self.gaps(&group);
            cost_m += joint_m + group_joints_m(self.graph, &group);
            groups.push(gaps);
        }
        Share { tree: index, cost_m, groups }
    }

    /// The gaps in which a group of loops has tuples with one of the lines, and what a joint there adds.
    fn gaps(&self, group: &[&Loop]) -> (Vec<usize>, f64) {
        let mut gaps: Vec<usize> = Vec::new();
        let mut least_m = f64::INFINITY;
        let wholes = self.lines.map(|line| Loop::whole(self.graph, line));
        for (side, part) in group.iter().flat_map(|&part| [(0, part), (1, part)]) {
            let Some((joint_m, _)) = cheapest_edge(self.graph, part, &wholes[side]) else { continue };
            least_m = least_m.min(joint_m);
            let tuples = super::loop_tree::tuples_between(self.graph, part, &wholes[side]);
            let steps = tuples.into_iter().filter_map(|tuple| {
                tuple.steps.into_iter().find(|&step| self.graph.line_of(step) == self.lines[side])
            });
            gaps.extend(steps.filter_map(|step| self.gap(side, step)));
        }
        gaps.sort_unstable();
        gaps.dedup();
        (gaps, if least_m.is_finite() { least_m } else { 0.0 })
    }

    /// The number of the cut before a step; nothing for a step that is a cut itself.
    fn gap(&self, side: usize, step: StationId) -> Option<usize> {
        let offset = |station: StationId| self.offset(side, station);
        let after = self.cuts.partition_point(|cut| offset(cut.steps[side]) <= offset(step));
        (offset(self.cuts[after - 1].steps[side]) != offset(step)).then(|| after - 1)
    }

    /// Stations of a line from the first cut on.
    fn offset(&self, side: usize, station: StationId) -> StationId {
        offset(self.graph, self.cuts[0].steps[side], station)
    }

    /// The best division that is found.
    pub(super) fn best(&self) -> Option<Division> {
        let mut found: Vec<Division> = Vec::new();
        for order in orders(self.shares.len()) {
            let stride = self.cuts.len().div_ceil(BEGINNINGS);
            for first in (0..self.cuts.len()).step_by(stride) {
                found.extend(self.measured_out(&order, first));
            }
        }
        found.sort_by(|one, other| one.norm_m.total_cmp(&other.norm_m));
        found.truncate(IMPROVED);
        let improved = found.into_iter().map(|division| self.improved(division));
        improved.min_by(|one, other| one.norm_m.total_cmp(&other.norm_m))
    }

    /// Pieces one after the other, so long that the costs even out.
    fn measured_out(&self, order: &[usize], first: usize) -> Option<Division> {
        let level_m = self.level_m();
        let mut begins = vec![first];
        let mut due_m = self.along_m[first];
        for &share in &order[..order.len() - 1] {
            due_m += self.piece_m(share, level_m);
            let turns = (due_m / self.total_m).floor();
            let cut = self.along_m.partition_point(|&at_m| at_m + turns * self.total_m < due_m);
            begins.push(cut % self.cuts.len());
        }
        self.priced(order.to_vec(), begins)
    }

    fn piece_m(&self, share: usize, level_m: f64) -> f64 {
        (level_m - self.shares[share].cost_m).max(4.0 * STATIONS_MIN as f64 * self.graph.tool_m)
    }

    /// The cost that all robots come to when both lines are shared out.
    fn level_m(&self) -> f64 {
        let (mut low_m, mut high_m) =
            (0.0, self.total_m + self.shares.iter().map(|share| share.cost_m).sum::<f64>());
        for _ in 0..40 {
            let middle_m = f64::midpoint(low_m, high_m);
            let filled_m: f64 = (0..self.shares.len()).map(|share| self.piece_m(share, middle_m)).sum();
            if filled_m < self.total_m { low_m = middle_m } else { high_m = middle_m }
        }
        high_m
    }

    /// The division with its norm; nothing when a piece is too short.
    fn priced(&self, order: Vec<usize>, begins: Vec<usize>) -> Option<Division> {
        let mut costs_m = self.others_m.clone();
        for (index, &share) in order.iter().enumerate() {
            let (begin, end) = (begins[index], begins[(index + 1) % begins.len()]);
            let length_m = self.length_m(begin, end)?;
            let ways_m: f64 = self.shares[share].groups.iter().map(|gaps| self.way_m(gaps, begin, end)).sum();
            costs_m.push(self.shares[share].cost_m + length_m + ways_m);
        }
        // The pieces go around once.
        let around = (0..begins.len()).map(|index| {
            (begins[(index + 1) % begins.len()] + self.cuts.len() - begins[index]) % self.cuts.len()
        });
        (around.sum::<usize>() == self.cuts.len()).then(|| Division {
            order,
            begins,
            norm_m: norm_m(&costs_m),
        })
    }

    /// Length of the closed line between two cuts.
    fn length_m(&self, begin: usize, end: usize) -> Option<f64> {
        let graph = self.graph;
        let (first, last) = (self.cuts[begin], self.cuts[end]);
        for side in 0..2 {
            let line = graph.lines[self.lines[side] as usize].stations.len();
            let count = offset(graph, first.steps[side], last.steps[side]) as usize;
            if begin == end || count < STATIONS_MIN || count + STATIONS_MIN > line {
                return None;
            }
        }
        let wrapped_m = if end < begin { self.total_m } else { 0.0 };
        let removed_m: f64 = last.steps.iter().map(|&step| graph.step_m(step)).sum();
        let joined_m =
            distance_m(graph, first.steps) + distance_m(graph, last.steps.map(|step| graph.before(step)));
        Some(self.along_m[end] + wrapped_m - self.along_m[begin] - removed_m + joined_m)
    }

    /// What it takes to drive from a piece along the lines to where a group can be joined, and back.
    fn way_m(&self, gaps: &[usize], begin: usize, end: usize) -> f64 {
        let count = self.cuts.len();
        let length = (end + count - begin) % count;
        let nearest = gaps.iter().map(|&gap| {
            let place = (gap + count - begin) % count;
            if place < length { 0 } else { (place + 1 - length).min(count - place) }
        });
        let cuts_away = nearest.min().unwrap_or(0) as f64;
        // Both lines count in total_m, and the way is driven twice.
        cuts_away * self.total_m / count as f64
    }

    /// Moves one cut at a time as long as that helps.
    fn improved(&self, mut best: Division) -> Division {
        let count = self.cuts.len();
        let mut stride = (count / 8).max(1);
        loop {
            let mut found = None;
            for index in 0..best.begins.len() {
                for moved in [best.begins[index] + stride, best.begins[index] + count - stride % count] {
                    let mut begins = best.begins.clone();
                    begins[index] = moved % count;
                    found = self
                        .priced(best.order.clone(), begins)
                        .filter(|new| new.norm_m < best.norm_m - 1e-9)
                        .or(found);
                }
            }
            match found {
                Some(better) => best = better,
                None if stride == 1 => return best,
                None => stride = (stride / 2).max(1),
            }
        }
    }

    /// Puts the pieces in the place of the lines.
    pub(super) fn apply(&self, division: &Division, trees: &mut [LoopTree]) {
        for (index, &share) in division.order.iter().enumerate() {
            let end = division.begins[(index + 1) % division.begins.len()];
            let piece = self.piece(division.begins[index], end);
            let tree = &mut trees[self.shares[share].tree];
            let goes = |part: &Loop| self.lines.iter().any(|&line| part.is_whole(line));
            let root = tree.loops[tree.root].clone();
            tree.loops.retain(|part| !goes(part));
            tree.loops.push(piece);
            let kept = tree.loops.iter().position(|part| *part == root);
            tree.root = kept.unwrap_or(tree.loops.len() - 1);
        }
    }

    /// One line forward, the other back.
    fn piece(&self, begin: usize, end: usize) -> Loop {
        let stretch = |side: usize| {
            let mut stations = Vec::new();
            let mut at = self.cuts[begin].steps[side];
            while at != self.cuts[end].steps[side] {
                stations.push(at);
                at = self.graph.after(at);
            }
            stations
        };
        let mut ring = stretch(0);
        ring.extend(stretch(1).into_iter().rev());
        let length_m = self.length_m(begin, end).expect("only sound divisions are applied");
        Loop { ring, lines: self.lines.to_vec(), length_m }
    }
}

/// The stitches between two lines in which both run on: the longest such series.
fn cuts(graph: &Isograph, lines: [LineId; 2]) -> Vec<Tuple> {
    let mut sorted = lines;
    sorted.sort_unstable();
    let Some(edge) = graph.edges.iter().find(|edge| edge.lines == sorted && edge.hops == 1) else {
        return Vec::new();
    };
    let side = |line: LineId| usize::from(edge.lines[1] == line);
    let mut tuples: Vec<Tuple> = edge.tuples.iter().copied().filter(|tuple| !tuple.faces).collect();
    for tuple in &mut tuples {
        tuple.steps = lines.map(|line| tuple.steps[side(line)]);
    }
    tuples.sort_by_key(|tuple| tuple.steps[0]);
    let Some(first) = tuples.first().copied() else { return tuples };
    let places: Vec<StationId> =
        tuples.iter().map(|tuple| offset(graph, first.steps[1], tuple.steps[1])).collect();
    longest_rise(&places).into_iter().map(|index| tuples[index]).collect()
}

/// Indices of a longest series that rises, beginning with the first number.
fn longest_rise(numbers: &[StationId]) -> Vec<usize> {
    let mut length = vec![1; numbers.len()];
    let mut before = vec![usize::MAX; numbers.len()];
    for at in 1..numbers.len() {
        length[at] = 0;
        for earlier in (0..at).filter(|&earlier| numbers[earlier] < numbers[at]) {
            if length[earlier] > 0 && length[earlier] + 1 > length[at] {
                length[at] = length[earlier] + 1;
                before[at] = earlier;
            }
        }
    }
    let mut at = (0..numbers.len()).max_by_key(|&index| length[index]).unwrap_or(0);
    let mut series = vec![at];
    while before[at] != usize::MAX {
        at = before[at];
        series.push(at);
    }
    series.reverse();
    series
}

/// Stations from one to another of the same line, the way it runs.
fn offset(graph: &Isograph, from: StationId, to: StationId) -> StationId {
    let count = graph.lines[graph.line_of(from) as usize].stations.len() as StationId;
    (to + count - from) % count
}

fn along_m(graph: &Isograph, lines: [LineId; 2], cuts: &[Tuple]) -> Vec<f64> {
    let mut sums = vec![0.0; cuts.len()];
    for (side, &line) in lines.iter().enumerate() {
        let count = graph.stations(line).len() as StationId;
        let first = cuts[0].steps[side];
        let mut reached_m = vec![0.0; count as usize];
        let mut at = first;
        for place in 1..count as usize {
            at = graph.after(at);
            reached_m[place] = reached_m[place - 1] + graph.step_m(at);
        }
        for (sum, cut) in sums.iter_mut().zip(cuts) {
            *sum += reached_m[offset(graph, first, cut.steps[side]) as usize];
        }
    }
    sums
}

fn distance_m(graph: &Isograph, [one, other]: [StationId; 2]) -> f64 {
    (graph.point(one) - graph.point(other)).norm()
}

/// Loops that hang together without the lines to be split.
fn groups_of<'a>(graph: &Isograph, loops: &[&'a Loop]) -> Vec<Vec<&'a Loop>> {
    let mut left: Vec<&Loop> = loops.to_vec();
    let mut groups = Vec::new();
    while let Some(first) = left.pop() {
        let mut group = vec![first];
        let mut next = 0;
        while let Some(&at) = group.get(next) {
            next += 1;
            let (joined, rest): (Vec<_>, Vec<_>) =
                left.into_iter().partition(|part| cheapest_edge(graph, at, part).is_some());
            group.extend(joined);
            left = rest;
        }
        groups.push(group);
    }
    groups
}

fn group_joints_m(graph: &Isograph, group: &[&Loop]) -> f64 {
    let loops: Vec<Loop> = group.iter().map(|&part| part.clone()).collect();
    let lengths_m: f64 = loops.iter().map(|part| part.length_m).sum();
    LoopTree { loops, root: 0 }.cost_m(graph) - lengths_m
}

/// Orders of things around a ring: the first stays.
fn orders(count: usize) -> Vec<Vec<usize>> {
    let mut orders = vec![vec![0]];
    for next in 1..count {
        let longer = orders.iter().flat_map(|order| {
            (1..=order.len()).map(move |place| {
                let mut longer = order.clone();
                longer.insert(place, next);
                longer
            })
        });
        orders = longer.collect();
        // Spread over all of them where there are too many.
        let stride = orders.len().div_ceil(ORDERS_MAX);
        orders = orders.into_iter().step_by(stride).collect();
    }
    orders
}

/// The p-norm, as a mean.
pub(super) fn norm_m(costs_m: &[f64]) -> f64 {
    let most_m = costs_m.iter().copied().fold(0.0, f64::max);
    let mean = costs_m.iter().map(|cost_m| (cost_m / most_m).powf(NORM)).sum::<f64>() / costs_m.len() as f64;
    most_m * mean.powf(1.0 / NORM)
}
