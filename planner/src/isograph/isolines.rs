//! Layered isolines: closed lines of equal distance to the border, with a station every tool width.
//!
//! ```text
//!   o───o───o───o        o  station: where a line may be stitched to its neighbour
//!   │           │        ·  corner in between: kept when lines are exact offsets, cut when they come from
//!   o     ·─o───o           a sampled field, as the paper does it
//!   │     │
//!   o───o─·
//! ```

use super::{distance_field::DistanceField, marching_squares::contours, walls::Walls};
use terrain::Point;

/// A closed line; the higher ground, farther from the border, is on its left.
#[derive(Debug, Clone)]
pub(super) struct Isoline {
    /// Counted from the border, the first is 0.
    pub(super) layer: u32,
    pub(super) stations: Vec<Station>,
    pub(super) length_m: f64,
}

/// A point of a line, and the corners between the station before it and itself.
#[derive(Debug, Clone)]
pub(super) struct Station {
    pub(super) point: Point,
    pub(super) corners_before: Vec<Point>,
}

/// Samples of the distance field in a tool width.
const SAMPLES_PER_TOOL: f64 = 4.0;
/// A line of fewer stations cannot be stitched to others on both sides.
const STATIONS_MIN: usize = 4;
/// The shortest line, in tool widths.
pub(super) const LENGTH_MIN: f64 = STATIONS_MIN as f64 - 0.5;

/// The paper's isolines: marching squares at l, 2 l, …, stations in place of corners.
/// A body that is larger than that keeps the first line as far off as it needs.
pub(super) fn of_field(walls: &Walls, tool_m: f64, clearance_m: f64) -> Vec<Isoline> {
    let field = DistanceField::new(walls, tool_m / SAMPLES_PER_TOOL);
    let first_m = tool_m.max(clearance_m);
    let layers = ((field.deepest_m() - first_m) / tool_m).floor() + 1.0;
    let lines = (0..layers.max(0.0) as u32).flat_map(|layer| {
        let rings = contours(&field, first_m + f64::from(layer) * tool_m);
        rings.into_iter().filter_map(move |ring| Isoline::new(layer, &ring, tool_m, false))
    });
    lines.collect()
}

/// Given lines with their layers, the higher ground on their left; corners are kept.
pub(super) fn of_rings(rings: impl Iterator<Item = (u32, Vec<Point>)>, tool_m: f64) -> Vec<Isoline> {
    rings.filter_map(|(layer, ring)| Isoline::new(layer, &ring, tool_m, true)).collect()
}

impl Isoline {
    /// Nothing when the ring is too short for stations.
    fn new(layer: u32, ring: &[Point], tool_m: f64, keeps_corners: bool) -> Option<Self> {
        let length_m: f64 = super::walls::closed(ring).map(|edge| edge.length()).sum();
        let count = (length_m / tool_m).round() as usize;
        if count < STATIONS_MIN {
            return None;
        }
        let mut stations = stations(ring, count, length_m);
        if !keeps_corners {
            for station in &mut stations {
                station.corners_before.clear();
            }
        }
        let mut line = Self { layer, stations, length_m: 0.0 };
        line.length_m = (0..count).map(|station| line.step_m(station)).sum();
        Some(line)
    }

    /// Length of the line between the station before this one and itself.
    pub(super) fn step_m(&self, station: usize) -> f64 {
        let count = self.stations.len();
        let mut at = self.stations[(station + count - 1) % count].point;
        let here = &self.stations[station];
        let way = here.corners_before.iter().chain([&here.point]);
        way.map(|&point| (point - std::mem::replace(&mut at, point)).norm()).sum()
    }
}

/// Points at equal distances along a ring.
fn stations(ring: &[Point], count: usize, length_m: f64) -> Vec<Station> {
    let step_m = length_m / count as f64;
    let mut found = vec![Station { point: ring[0], corners_before: Vec::new() }];
    let mut corners = Vec::new();
    let (mut driven_m, mut due_m) = (0.0, step_m);
    for edge in super::walls::closed(ring) {
        let edge_m = edge.length();
        while found.len() < count && due_m <= driven_m + edge_m {
            let share = if edge_m > 0.0 { (due_m - driven_m) / edge_m } else { 0.0 };
            let point = edge.from.lerp(&edge.to, share);
            found.push(Station { point, corners_before: std::mem::take(&mut corners) });
            due_m += step_m;
        }
        driven_m += edge_m;
        corners.push(edge.to);
    }
    // The last corner is the first point, a station already.
    corners.pop();
    found[0].corners_before = corners;
    found
}
