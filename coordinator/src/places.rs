//! From the lines of a plan to the places of a route, and to the cells that a route sweeps.
//!
//! ```text
//!   plan     ●─────────────────────────●╲ ╱●      any points, near or far apart
//!   places   ●────────●────────●───────●──●      none farther apart than a cell, so that ground is released in small
//!                                                pieces; none nearer than it takes to stay within THINNING_M of the
//!                                                plan, so that an order reaches far
//! ```
//!
//! Who is to cover a cell is told by the footprint: the robot whose route sweeps most of what is missing there.

use crate::{Coordinator, ledger::RobotIndex, route::Waypoint};
use std::collections::BTreeMap;
use terrain::{Cell, Point, Segment, for_each_swept};

/// Points are left out that lie as near as this to the line without them, metres.
const THINNING_M: f64 = 0.001;
/// Two places as near as this are one, metres.
const SAME_M: f64 = 1e-6;
/// The tool is on so far before and behind where something is missing: evidence begins with the next fix, metres.
const TOOL_LEAD_M: f64 = 0.35;

impl Coordinator {
    /// The cell of which a point is the centre.
    pub(crate) fn cell_centred_at(&self, point: Point) -> Option<Cell> {
        let lattice = self.floor.lattice();
        lattice.cell_at(point).filter(|&cell| (lattice.center(cell) - point).norm() < SAME_M)
    }

    /// The places of a route that goes on from `from` along `points`.
    pub(crate) fn places_along(&self, from: Point, points: &[Point]) -> Vec<Waypoint> {
        let mut line = vec![from];
        line.extend(points.iter().copied());
        line.dedup_by(|a, b| (*a - *b).norm() < SAME_M);
        let farthest_m = self.floor.lattice().cell_m;
        let places = spaced(&thinned(&line, farthest_m), farthest_m);
        let active = self.tool_along(&places);
        places[1..]
            .iter()
            .zip(active)
            .map(|(&point, tool_active)| Waypoint { point, cell: self.cell_centred_at(point), tool_active })
            .collect()
    }

    /// Per edge: whether the tool is to be on.
    fn tool_along(&self, places: &[Point]) -> Vec<bool> {
        let edges: Vec<Segment> = places.windows(2).map(|pair| Segment::new(pair[0], pair[1])).collect();
        let missing: Vec<bool> = edges.iter().map(|&edge| self.sweeps_something_missing(edge)).collect();
        let mut active = missing.clone();
        for at in (0..edges.len()).filter(|&at| missing[at]) {
            spread(&mut active, &edges, (0..at).rev());
            spread(&mut active, &edges, at + 1..edges.len());
        }
        active
    }

    fn sweeps_something_missing(&self, edge: Segment) -> bool {
        self.cells_swept(edge).into_iter().any(|(index, samples)| samples & self.ledger.missing(index) != 0)
    }

    /// What the tool sweeps along an edge, as far as it counts: numbers of cells, and samples.
    pub(crate) fn cells_swept(&self, edge: Segment) -> Vec<(usize, u64)> {
        let mut swept = Vec::new();
        let radius_m = self.floor.tool_width_m() / 2.0;
        for_each_swept(self.floor.lattice(), edge, radius_m, |index, samples| swept.push((index, samples)));
        swept
    }

    /// What a line of edges sweeps with the tool on.
    pub(crate) fn swept_by(&self, edges: impl IntoIterator<Item = Segment>) -> BTreeMap<usize, u64> {
        let mut swept = BTreeMap::new();
        for edge in edges {
            for (index, samples) in self.cells_swept(edge) {
                *swept.entry(index).or_default() |= samples;
            }
        }
        swept
    }

    /// Gives each open cell that belongs to nobody to the robot whose horizon sweeps most of what is missing there.
    pub(crate) fn assign_by_footprint(&mut self, robots: &[RobotIndex]) {
        let mut best: BTreeMap<usize, (u32, RobotIndex)> = BTreeMap::new();
        for &robot in robots {
            for (index, samples) in self.swept_by(self.horizon_edges(robot)) {
                let share = (samples & self.ledger.missing(index)).count_ones();
                if share > best.get(&index).map_or(0, |&(most, _)| most) {
                    best.insert(index, (share, robot));
                }
            }
        }
        for (index, (_, robot)) in best {
            if self.ledger.is_unclaimed(index) {
                self.ledger.assign(index, robot);
            }
        }
    }

    /// The edges that a robot will drive with its tool on, behind its base or when it is charged.
    fn horizon_edges(&self, robot: RobotIndex) -> Vec<Segment> {
        let places = self.places_ahead(robot);
        let covers = |pair: &&[Waypoint]| pair[1].tool_active;
        places.windows(2).filter(covers).map(|pair| Segment::new(pair[0].point, pair[1].point)).collect()
    }

    /// The edges of a robot's base on which its tool is on.
    pub(crate) fn base_edges(&self, robot: RobotIndex) -> Vec<Segment> {
        let places: Vec<Waypoint> = self.robots[robot].route.base().copied().collect();
        let covers = |pair: &&[Waypoint]| pair[1].tool_active;
        places.windows(2).filter(covers).map(|pair| Segment::new(pair[0].point, pair[1].point)).collect()
    }
}

/// Turns the tool on along edges in this order, as far as its lead reaches.
fn spread(active: &mut [bool], edges: &[Segment], order: impl Iterator<Item = usize>) {
    let mut left_m = TOOL_LEAD_M;
    for at in order {
        if left_m <= 0.0 || active[at] {
            return;
        }
        active[at] = true;
        left_m -= edges[at].length();
    }
}

/// Leaves out points that hardly change the line; what is left is not farther apart than `farthest_m` for that.
fn thinned(line: &[Point], farthest_m: f64) -> Vec<Point> {
    let mut kept = vec![line[0]];
    let mut from = 0;
    while from + 1 < line.len() {
        let mut to = from + 1;
        while to + 1 < line.len()
            && (line[to + 1] - line[from]).norm() <= farthest_m
            && stays_near(&line[from..=to + 1])
        {
            to += 1;
        }
        kept.push(line[to]);
        from = to;
    }
    kept
}

fn stays_near(points: &[Point]) -> bool {
    let straight = Segment::new(points[0], points[points.len() - 1]);
    points.iter().all(|&point| straight.distance_to_point(point) <= THINNING_M)
}

/// Puts points between those that are farther apart than `farthest_m`.
fn spaced(line: &[Point], farthest_m: f64) -> Vec<Point> {
    let mut places = vec![line[0]];
    for pair in line.windows(2) {
        let way = pair[1] - pair[0];
        let pieces = (way.norm() / farthest_m - 1e-6).ceil().max(1.0) as u32;
        places.extend((1..pieces).map(|piece| pair[0] + way * (f64::from(piece) / f64::from(pieces))));
        places.push(pair[1]);
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arc(spacing_m: f64) -> Vec<Point> {
        let count = (3.0 / spacing_m) as u32;
        let place = |at: u32| f64::from(at) * spacing_m;
        (0..=count).map(place).map(|a| Point::new(a.sin(), 1.0 - a.cos())).collect()
    }

    #[test]
    fn long_lines_are_divided_and_dense_ones_thinned() {
        let long = spaced(&[Point::origin(), Point::new(3.3, 0.0)], 0.5);
        assert_eq!(long.len(), 8);
        assert!(long.windows(2).all(|pair| (pair[1] - pair[0]).norm() <= 0.5 + 1e-9));
        let dense = arc(0.004);
        let thin = thinned(&dense, 0.5);
        assert!(thin.len() < dense.len() / 10, "{}", thin.len());
        for &point in &dense {
            let apart = |pair: &[Point]| Segment::new(pair[0], pair[1]).distance_to_point(point);
            assert!(thin.windows(2).map(apart).fold(f64::INFINITY, f64::min) <= THINNING_M + 1e-9);
        }
    }

    #[test]
    fn a_spur_there_and_back_is_kept() {
        let spur = [(0.0, 0.0), (0.3, 0.0), (0.34, 0.0), (0.3, 0.0), (0.1, 0.0)];
        let line: Vec<Point> = spur.iter().map(|&(x, y)| Point::new(x, y)).collect();
        assert!(thinned(&line, 0.5).contains(&line[2]));
    }
}
