//! Closed lines being stitched together: which two stations each station is tied to.
//!
//! A stitch is a swap of two steps for two connections. Nothing is matched by coordinates; lines that are given in part
//! (see `splitting.rs`) are closed lines like any other.

use super::graph::{Isograph, StationId, Tuple};
use terrain::{Point, Vector};

const NONE: StationId = StationId::MAX;

/// The lines of one robot while they are stitched.
#[derive(Debug, Clone)]
pub(super) struct Weave<'a> {
    graph: &'a Isograph,
    ties: Vec<[StationId; 2]>,
}

impl<'a> Weave<'a> {
    pub(super) fn new(graph: &'a Isograph) -> Self {
        Self { graph, ties: vec![[NONE; 2]; graph.station_count()] }
    }

    /// Lays a closed line.
    pub(super) fn lay(&mut self, ring: &[StationId]) {
        for (index, &station) in ring.iter().enumerate() {
            let before = ring[(index + ring.len() - 1) % ring.len()];
            self.ties[station as usize] = [before, ring[(index + 1) % ring.len()]];
        }
    }

    /// Whether the step of an isoline that ends in `station` is still there.
    pub(super) fn has_step(&self, station: StationId) -> bool {
        self.ties[station as usize].contains(&self.graph.before(station))
    }

    /// Whether the stitch can still be made.
    pub(super) fn allows(&self, tuple: Tuple) -> bool {
        tuple.steps.iter().all(|&step| self.has_step(step))
    }

    /// Stitches: two steps go, two connections come.
    pub(super) fn stitch(&mut self, tuple: Tuple) {
        let connections = self.graph.connections(tuple);
        for step in tuple.steps {
            let before = self.graph.before(step);
            self.replace(step, before, other_end(&connections, step));
            self.replace(before, step, other_end(&connections, before));
        }
    }

    fn replace(&mut self, station: StationId, old: StationId, new: StationId) {
        let ties = &mut self.ties[station as usize];
        let place = ties.iter().position(|&tie| tie == old).expect("the step is there");
        ties[place] = new;
    }

    /// How much more the path turns when it is stitched here, radians (equation 3).
    pub(super) fn added_turning_rad(&self, tuple: Tuple) -> f64 {
        let mut stitched = StitchedTies { weave: self, tuple, connections: self.graph.connections(tuple) };
        let ends = stitched.connections.as_flattened().to_vec();
        let after: f64 = ends.iter().map(|&end| self.turning_rad(end, stitched.ties(end))).sum();
        let before: f64 = ends.iter().map(|&end| self.turning_rad(end, self.ties[end as usize])).sum();
        after - before
    }

    fn turning_rad(&self, station: StationId, [one, other]: [StationId; 2]) -> f64 {
        let here = self.graph.point(station);
        let (came, goes) =
            (here - self.first_towards(station, one), self.first_towards(station, other) - here);
        turning_rad(came, goes)
    }

    /// The first point on the way to a neighbouring station.
    fn first_towards(&self, station: StationId, to: StationId) -> Point {
        self.graph.corners_between(station, to).first().copied().unwrap_or_else(|| self.graph.point(to))
    }

    /// The stations from this one around its closed line.
    pub(super) fn ring(&self, start: StationId) -> Vec<StationId> {
        let mut ring = vec![start];
        let (mut before, mut at) = (start, self.ties[start as usize][1]);
        while at != start {
            ring.push(at);
            let [one, other] = self.ties[at as usize];
            let next = if one == before { other } else { one };
            (before, at) = (at, next);
        }
        ring
    }
}

/// The ties as they would be after a stitch.
struct StitchedTies<'a, 'b> {
    weave: &'b Weave<'a>,
    tuple: Tuple,
    connections: [[StationId; 2]; 2],
}

impl StitchedTies<'_, '_> {
    fn ties(&mut self, station: StationId) -> [StationId; 2] {
        let graph = self.weave.graph;
        let step =
            self.tuple.steps.into_iter().find(|&step| step == station || graph.before(step) == station);
        let step = step.expect("only ends of the stitch are asked for");
        let old = if step == station { graph.before(step) } else { step };
        let new = other_end(&self.connections, station);
        self.weave.ties[station as usize].map(|tie| if tie == old { new } else { tie })
    }
}

fn other_end(connections: &[[StationId; 2]; 2], station: StationId) -> StationId {
    let [a, b] =
        *connections.iter().find(|pair| pair.contains(&station)).expect("it is an end of the stitch");
    if a == station { b } else { a }
}

/// The angle between two directions, 0 … π; 0 where one of them is none.
pub(super) fn turning_rad(came: Vector, goes: Vector) -> f64 {
    if came.norm_squared() == 0.0 || goes.norm_squared() == 0.0 {
        return 0.0;
    }
    came.perp(&goes).atan2(came.dot(&goes)).abs()
}
