//! The isograph: isolines as vertices, an edge where two of them can be stitched.
//!
//! ```text
//!   u  ──▶──B(p)──▶──p──▶──      A stitch takes the steps to p and to q away and joins p with q and B(p) with B(q):
//!              ┆      ┆          two closed lines become one, which runs around v the other way. Neighbouring lines
//!   v  ──▶──B(q)──▶──q──▶──      run the same way; lines of one layer that face each other over a ridge run against
//!                                each other, and p is joined with the tail of the other step.
//! ```

use super::{isolines::Isoline, station_index::StationIndex, walls::Walls};
use crate::disjoint_sets::DisjointSets;
use terrain::{Point, Segment};

/// Number of a station among those of all lines. It also names the step of the line that ends in it.
pub(super) type StationId = u32;
/// Number of an isoline: a vertex of the isograph.
pub(super) type LineId = u32;

/// Where two lines can be stitched: the steps that are taken away.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Tuple {
    pub(super) steps: [StationId; 2],
    /// The steps run against each other: the head of one is joined with the tail of the other.
    pub(super) faces: bool,
}

impl Tuple {
    /// With the step of the line of the lower number first.
    pub(super) fn sorted(mut self, graph: &Isograph) -> Self {
        self.steps.sort_by_key(|&step| graph.line_of(step));
        self
    }
}

/// Two lines that can be stitched.
#[derive(Debug, Clone)]
pub(super) struct Edge {
    pub(super) lines: [LineId; 2],
    /// The step of the first line comes first in each.
    pub(super) tuples: Vec<Tuple>,
    /// Number of layers in between plus one.
    pub(super) hops: u32,
    /// What a stitch adds to the path; of a bridge, the way there and back.
    pub(super) weight_m: f64,
    /// A straight line by which lines are joined that no stitch can join: it is driven there and back.
    pub(super) bridge: Option<[StationId; 2]>,
}

/// Isolines and how they can be stitched.
#[derive(Debug)]
pub(super) struct Isograph {
    pub(super) lines: Vec<Isoline>,
    pub(super) edges: Vec<Edge>,
    pub(super) tool_m: f64,
    /// How near to the wall a connection may come.
    pub(super) clearance_m: f64,
    first_station: Vec<StationId>,
    line_of: Vec<LineId>,
}

/// Stations farther apart than this many tool widths are no neighbours.
pub(super) const REACH: f64 = 2.0;
/// The share of the clearance that connections must keep: isolines are rounded, too.
const KEPT: f64 = 0.998;

impl Isograph {
    /// Edges between adjacent layers; and others where the graph would fall apart without.
    pub(super) fn new(lines: Vec<Isoline>, walls: &Walls, tool_m: f64, clearance_m: f64) -> Self {
        let mut graph = Self::without_edges(lines, tool_m, KEPT * clearance_m);
        let index = StationIndex::new(&graph);
        graph.add_sound(index.stitches(&graph), walls);
        graph.join_pieces(index.facing(&graph), walls);
        graph.bridge_pieces(&index, walls);
        graph
    }

    fn without_edges(lines: Vec<Isoline>, tool_m: f64, clearance_m: f64) -> Self {
        let mut first_station = Vec::with_capacity(lines.len());
        let mut line_of = Vec::new();
        for (line, isoline) in lines.iter().enumerate() {
            first_station.push(line_of.len() as StationId);
            line_of.resize(line_of.len() + isoline.stations.len(), line as LineId);
        }
        Self { lines, edges: Vec::new(), tool_m, clearance_m, first_station, line_of }
    }

    /// Edges between facing lines of one layer, but only those that join pieces of the graph.
    fn join_pieces(&mut self, facing: Vec<Tuple>, walls: &Walls) {
        let mut pieces = DisjointSets::new(self.lines.len());
        for edge in &self.edges {
            pieces.unite(edge.lines[0], edge.lines[1]);
        }
        let apart: Vec<Tuple> = facing
            .into_iter()
            .filter(|tuple| {
                let [u, v] = tuple.steps.map(|step| self.line_of(step));
                pieces.find(u) != pieces.find(v)
            })
            .collect();
        self.add_sound(apart, walls);
    }

    /// Joins what is still in pieces by the shortest straight lines that keep off the walls.
    fn bridge_pieces(&mut self, index: &StationIndex, walls: &Walls) {
        let pieces = self.pieces();
        if pieces.iter().all(|&piece| piece == pieces[0]) {
            return;
        }
        let mut joined = DisjointSets::new(self.lines.len());
        for edge in &self.edges {
            joined.unite(edge.lines[0], edge.lines[1]);
        }
        for ends in index.bridges(self, &pieces) {
            let lines = ends.map(|end| self.line_of(end));
            let way = Segment::new(self.point(ends[0]), self.point(ends[1]));
            let is_new = joined.find(lines[0]) != joined.find(lines[1]);
            if is_new && walls.keeps_clear(way, self.clearance_m) {
                joined.unite(lines[0], lines[1]);
                let weight_m = 2.0 * way.length();
                self.edges.push(Edge { lines, tuples: Vec::new(), hops: 1, weight_m, bridge: Some(ends) });
            }
        }
    }

    fn add_sound(&mut self, mut tuples: Vec<Tuple>, walls: &Walls) {
        tuples.retain(|&tuple| self.is_sound(tuple, walls, 1));
        for tuple in tuples {
            self.add(tuple, 1, 0.0);
        }
    }

    /// Adds a tuple to the edge between its lines.
    pub(super) fn add(&mut self, tuple: Tuple, hops: u32, weight_m: f64) {
        let lines = tuple.steps.map(|step| self.line_of(step));
        let known = self.edges.iter().position(|edge| edge.lines == lines);
        let index = known.unwrap_or_else(|| {
            self.edges.push(Edge { lines, tuples: Vec::new(), hops, weight_m, bridge: None });
            self.edges.len() - 1
        });
        self.edges[index].tuples.push(tuple);
    }

    /// Whether both connections are short, do not cross each other and keep off the walls.
    pub(super) fn is_sound(&self, tuple: Tuple, walls: &Walls, hops: u32) -> bool {
        let [one, other] = self.connections(tuple).map(|[a, b]| Segment::new(self.point(a), self.point(b)));
        let longest_m = (f64::from(hops) + REACH - 1.0) * self.tool_m;
        one.length().max(other.length()) <= longest_m
            && one.distance(&other) > 0.0
            && [one, other].iter().all(|line| walls.keeps_clear(*line, self.clearance_m))
    }

    /// The pairs of stations that a stitch joins.
    pub(super) fn connections(&self, tuple: Tuple) -> [[StationId; 2]; 2] {
        let [p, q] = tuple.steps;
        let (before_p, before_q) = (self.before(p), self.before(q));
        if tuple.faces { [[p, before_q], [before_p, q]] } else { [[p, q], [before_p, before_q]] }
    }

    pub(super) fn station_count(&self) -> usize {
        self.line_of.len()
    }

    pub(super) fn line_of(&self, station: StationId) -> LineId {
        self.line_of[station as usize]
    }

    /// All stations of a line, the way it runs.
    pub(super) fn stations(&self, line: LineId) -> std::ops::Range<StationId> {
        let first = self.first_station[line as usize];
        first..first + self.lines[line as usize].stations.len() as StationId
    }

    fn place_on_line(&self, station: StationId) -> (&Isoline, usize) {
        let line = self.line_of(station) as usize;
        (&self.lines[line], (station - self.first_station[line]) as usize)
    }

    pub(super) fn point(&self, station: StationId) -> Point {
        let (line, place) = self.place_on_line(station);
        line.stations[place].point
    }

    /// The corners between the station before this one and itself.
    pub(super) fn corners_before(&self, station: StationId) -> &[Point] {
        let (line, place) = self.place_on_line(station);
        &line.stations[place].corners_before
    }

    /// The corners on the way from a station to its neighbour on the line; none between other stations.
    pub(super) fn corners_between(&self, from: StationId, to: StationId) -> Vec<Point> {
        if self.before(to) == from {
            self.corners_before(to).to_vec()
        } else if self.before(from) == to {
            self.corners_before(from).iter().rev().copied().collect()
        } else {
            Vec::new()
        }
    }

    /// The points of a way over stations, corners included.
    pub(super) fn points_along(&self, way: &[StationId]) -> Vec<Point> {
        let mut points: Vec<Point> = way.first().map(|&first| self.point(first)).into_iter().collect();
        for pair in way.windows(2) {
            points.extend(self.corners_between(pair[0], pair[1]));
            points.push(self.point(pair[1]));
        }
        points
    }

    /// Length of the step to this station.
    pub(super) fn step_m(&self, station: StationId) -> f64 {
        let (line, place) = self.place_on_line(station);
        line.step_m(place)
    }

    /// B(p): the station before this one on its line.
    pub(super) fn before(&self, station: StationId) -> StationId {
        let stations = self.stations(self.line_of(station));
        if station == stations.start { stations.end - 1 } else { station - 1 }
    }

    /// The station after this one on its line.
    pub(super) fn after(&self, station: StationId) -> StationId {
        let stations = self.stations(self.line_of(station));
        if station + 1 == stations.end { stations.start } else { station + 1 }
    }

    /// Per line, the number of its connected piece.
    pub(super) fn pieces(&self) -> Vec<LineId> {
        let mut pieces = DisjointSets::new(self.lines.len());
        for edge in &self.edges {
            pieces.unite(edge.lines[0], edge.lines[1]);
        }
        (0..self.lines.len() as LineId).map(|line| pieces.find(line)).collect()
    }
}
