//! Tracks: closed lines at equal distances from the walls, each at its distance from the polygon itself.
//!
//! ```text
//!   wall ├─ r ─┼── l ──┼── l ──┼ …      r: clearance, at least half the tool; l: width of the tool
//!              1       2       3        number of the track
//! ```

use super::PolygonInstance;
use geo::algorithm::buffer::{BufferStyle, LineJoin};
use geo::{Area, BooleanOps, Buffer, LineString, MultiPolygon, Simplify};
use terrain::Point;

/// How far a track may be moved to have fewer corners, as a share of the tool's width.
const SIMPLIFIED: f64 = 1.0 / 1250.0;
/// Share of the tool's width that tracks are farther from walls than they need, for all that is rounded.
const MARGIN: f64 = 1.0 / 1000.0;
/// The most tracks that may lie inside each other.
const DEPTH_MAX: usize = 10_000;
/// Gaps up to this share of the tool's width are seams that rounding makes.
const SEAM: f64 = 0.04;

/// A closed line; its first corner is not repeated.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Track {
    /// Number from the walls inwards.
    pub(super) depth: usize,
    pub(super) corners: Vec<Point>,
}

impl Track {
    pub(super) fn length_m(&self) -> f64 {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().zip(next).map(|(a, b)| (b - a).norm()).sum()
    }
}

/// All tracks, from the walls inwards; the first is `first_m` from them.
pub(super) fn tracks(instance: &PolygonInstance, first_m: f64) -> Vec<Track> {
    let mut tracks = Vec::new();
    for depth in 0..DEPTH_MAX {
        let distance_m = first_m + depth as f64 * instance.tool_width_m;
        let rings = tracks_at(instance, distance_m);
        if rings.is_empty() {
            break;
        }
        tracks.extend(rings.into_iter().map(|corners| Track { depth, corners }));
    }
    tracks
}

/// Thin closed lines on the ground that the tracks leave between them: where a pocket ends more than half a tool
/// beyond the innermost track. Strips narrower than `least` tool widths are left out.
pub(super) fn strips(instance: &PolygonInstance, tracks: &[Track], least: f64) -> Vec<Track> {
    let (width_m, first_m) = (instance.tool_width_m, first_distance_m(instance));
    let depths = tracks.iter().map(|track| track.depth + 1).max().unwrap_or(0);
    let left = (0..depths).flat_map(|depth| left_between(instance, first_m + depth as f64 * width_m));
    let left = MultiPolygon::new(left.collect());
    let style = BufferStyle::new(-0.5 * least * width_m).line_join(LineJoin::Round(0.5));
    let wide = left.buffer_with_style(style);
    let rings = wide.iter().filter(|part| part.unsigned_area() > 0.1 * width_m * width_m);
    let rings = rings.map(|part| corners(&part.exterior().simplify(0.05 * width_m)));
    rings.filter(|corners| corners.len() >= 3).map(|corners| Track { depth: 0, corners }).collect()
}

/// What the tool leaves between the tracks at a distance from the walls and the next ones inwards. A seam is no gap.
fn left_between(instance: &PolygonInstance, distance_m: f64) -> MultiPolygon<f64> {
    let width_m = instance.tool_width_m;
    let tolerance_m = 0.02 * width_m;
    let reach_m = (0.5 + SEAM / 2.0) * width_m;
    let within = shrunk(instance, distance_m + reach_m, tolerance_m);
    let style = BufferStyle::new(reach_m).line_join(LineJoin::Round(0.2));
    let next = shrunk(instance, distance_m + width_m, tolerance_m).buffer_with_style(style);
    within.difference(&next)
}

/// Distance of the first track from the walls, metres.
pub(super) fn first_distance_m(instance: &PolygonInstance) -> f64 {
    instance.clearance_m() + MARGIN * instance.tool_width_m
}

/// The closed lines at a distance from the walls.
fn tracks_at(instance: &PolygonInstance, distance_m: f64) -> Vec<Vec<Point>> {
    let tolerance_m = SIMPLIFIED * instance.tool_width_m;
    let shrunk = shrunk(instance, distance_m, tolerance_m);
    let rings = shrunk.iter().flat_map(|part| std::iter::once(part.exterior()).chain(part.interiors()));
    let corners = rings.map(|ring| corners(&ring.simplify(tolerance_m)));
    corners.filter(|corners| corners.len() >= 3).collect()
}

/// The ground less all that is nearer than `distance_m` to a wall. Arcs around corners are drawn with chords that
/// come nearer by less than `tolerance_m` / 4.
pub(super) fn shrunk(instance: &PolygonInstance, distance_m: f64, tolerance_m: f64) -> MultiPolygon<f64> {
    let arc_rad = 2.0 * (1.0 - tolerance_m / (4.0 * distance_m)).max(0.9).acos();
    let style = BufferStyle::new(-distance_m).line_join(LineJoin::Round(arc_rad));
    instance.ground.buffer_with_style(style)
}

fn corners(ring: &LineString<f64>) -> Vec<Point> {
    let open = &ring.0[..ring.0.len().saturating_sub(1)];
    open.iter().map(|corner| Point::new(corner.x, corner.y)).collect()
}
