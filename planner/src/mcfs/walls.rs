//! The walls of a polygon, to ask whether a straight way keeps its distance from them.

use super::PolygonInstance;
use super::near::Near;
use geo::LinesIter;
use terrain::{Point, Segment};

/// Rounding that a distance may have, metres.
const SLACK_M: f64 = 1e-6;

/// All edges, found by place.
pub(super) struct Walls {
    edges: Vec<Segment>,
    near: Near,
    clearance_m: f64,
}

impl Walls {
    pub(super) fn new(instance: &PolygonInstance) -> Self {
        let point = |corner: geo::Coord<f64>| Point::new(corner.x, corner.y);
        let edges: Vec<Segment> = instance
            .ground
            .lines_iter()
            .map(|edge| Segment::new(point(edge.start), point(edge.end)))
            .collect();
        let clearance_m = instance.body_radius_m;
        let mut near = Near::new(edges.iter().flat_map(|edge| [edge.from, edge.to]), 4.0 * clearance_m);
        for (number, edge) in edges.iter().enumerate() {
            near.insert_box(edge.from, edge.to, number as u32);
        }
        Self { edges, near, clearance_m }
    }

    /// Whether a disc of the clearance's radius keeps within the ground all along a straight way that begins in it.
    pub(super) fn is_clear(&self, from: Point, to: Point) -> bool {
        let way = Segment::new(from, to);
        let least_m = self.clearance_m - SLACK_M;
        let margin = terrain::Vector::repeat(self.clearance_m);
        let (low, high) = (from.inf(&to) - margin, from.sup(&to) + margin);
        !self.near.in_box(low, high).any(|number| self.edges[number as usize].distance(&way) < least_m)
    }
}
