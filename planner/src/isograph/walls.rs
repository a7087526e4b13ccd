//! The border of a polygon, found fast: distances to it, and what keeps clear of it.

use rstar::{AABB, PointDistance, RTree, RTreeObject};
use terrain::{Point, Segment};

/// All edges of the rings.
#[derive(Debug)]
pub(super) struct Walls {
    edges: RTree<Edge>,
    rings: Vec<Vec<Point>>,
}

#[derive(Debug, Clone, Copy)]
struct Edge(Segment);

impl RTreeObject for Edge {
    type Envelope = AABB<[f64; 2]>;
    fn envelope(&self) -> Self::Envelope {
        AABB::from_corners(self.0.from.into(), self.0.to.into())
    }
}

impl PointDistance for Edge {
    fn distance_2(&self, point: &[f64; 2]) -> f64 {
        let point = Point::from(*point);
        (self.0.nearest(point) - point).norm_squared()
    }
}

impl Walls {
    pub(super) fn new(rings: &[Vec<Point>]) -> Self {
        let edges = rings.iter().flat_map(|ring| closed(ring)).map(Edge).collect();
        Self { edges: RTree::bulk_load(edges), rings: rings.to_vec() }
    }

    /// The lowest and the highest corner of the box around the polygon.
    pub(super) fn bounds(&self) -> (Point, Point) {
        let envelope = self.edges.root().envelope();
        (envelope.lower().into(), envelope.upper().into())
    }

    /// Distance to the border.
    pub(super) fn distance_m(&self, point: Point) -> f64 {
        let nearest = self.edges.nearest_neighbor(&point.into());
        nearest.map_or(f64::INFINITY, |edge| edge.0.distance_to_point(point))
    }

    /// Whether a straight line stays at least this far from the border.
    pub(super) fn keeps_clear(&self, line: Segment, clearance_m: f64) -> bool {
        let low = line.from.inf(&line.to).map(|x| x - clearance_m);
        let high = line.from.sup(&line.to).map(|x| x + clearance_m);
        let near = AABB::from_corners(low.into(), high.into());
        self.edges.locate_in_envelope_intersecting(&near).all(|edge| edge.0.distance(&line) >= clearance_m)
    }

    /// Where a horizontal line crosses the border, from left to right: inside lies between the first and the second,
    /// the third and the fourth, and so on.
    pub(super) fn crossings(&self, y: f64) -> Vec<f64> {
        let mut found = Vec::new();
        for edge in self.rings.iter().flat_map(|ring| closed(ring)) {
            let (from, to) = (edge.from, edge.to);
            if (from.y <= y) != (to.y <= y) {
                found.push(from.x + (to.x - from.x) * (y - from.y) / (to.y - from.y));
            }
        }
        found.sort_by(f64::total_cmp);
        found
    }
}

/// The edges of a ring, the closing one last.
pub(super) fn closed(ring: &[Point]) -> impl Iterator<Item = Segment> {
    (0..ring.len()).map(|index| Segment::new(ring[index], ring[(index + 1) % ring.len()]))
}
