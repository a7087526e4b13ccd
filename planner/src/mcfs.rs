//! Smooth coverage of polygons by many robots: connected Fermat spirals, cut at any length.
//!
//! ```text
//!   PolygonInstance ──▶ tracks ──▶ one closed line ──▶ k closed lines ──▶ Plan (one per robot, from its start)
//! ```

mod drive;
mod joining;
mod joint;
mod near;
mod polygon_instance;
mod sharing;
mod smoothing;
mod swept_counts;
mod target;
mod tracks;
mod walls;
mod web;

pub use polygon_instance::{PolygonError, PolygonInstance, RingName};

use crate::{Plan, Route};
use drive::{Drives, Neighbours};
use sharing::{Share, Sharing};
use smoothing::Smoothing;
use swept_counts::SweptCounts;
use terrain::Point;
use tracks::Track;
use walls::Walls;
use web::Web;

/// Strips narrower than this share of the tool's width are left to the smoothing.
const LEAST_STRIP: f64 = 0.6;
/// How much more ground is worth than the way that sweeps it, when all is to be swept.
const FULL_GROUND_WORTH: f64 = 8.0;

/// How to cover polygons.
#[derive(Debug, Clone, PartialEq)]
pub struct McfsOptions {
    /// Share of the ground to be swept, in (0, 1]; `None`: all that can be.
    pub coverage_target: Option<f64>,
    /// Bound on the rounds in which shares are evened out.
    pub rounds: usize,
    /// How often shares are evened out anew by the lengths of the smoothed lines.
    pub corrections: usize,
    /// The paper's own pipeline in place of ours, on floors with a map; it knows no coverage target.
    pub paper: Option<crate::isograph::SpiralOptions>,
}

impl Default for McfsOptions {
    fn default() -> Self {
        Self { coverage_target: None, rounds: 8, corrections: 3, paper: None }
    }
}

/// One closed line per robot, from its start and back.
///
/// # Errors
///
/// [`PolygonError`], when the polygon or a start is not sound.
pub fn cover(instance: &PolygonInstance, options: &McfsOptions) -> Result<Plan, PolygonError> {
    instance.check()?;
    let cover = match options.coverage_target {
        None => whole(instance, options),
        Some(target) => target::cover_share(instance, options, target),
    };
    let lines = cover.ok_or(PolygonError::TooWide { width_m: 2.0 * instance.clearance_m() })?.lines;
    Ok(Plan { routes: lines.into_iter().map(|points| Route { points }).collect() })
}

/// As [`cover`], for ground that was traced from a map: robots that fit nowhere on the tracks stay where they are.
pub(crate) fn cover_ground(instance: &PolygonInstance, options: &McfsOptions) -> Vec<Vec<Point>> {
    whole(instance, options).map_or_else(Vec::new, |cover| cover.lines)
}

/// Lines, and what they sweep.
struct Cover {
    lines: Vec<Vec<Point>>,
    coverage: f64,
}

impl Cover {
    fn lengths_m(&self) -> Vec<f64> {
        self.lines.iter().map(|line| length_m(line)).collect()
    }

    fn makespan_m(&self) -> f64 {
        self.lengths_m().into_iter().fold(0.0, f64::max)
    }
}

/// Sweeps all that can be swept; `None` when there is no track.
fn whole(instance: &PolygonInstance, options: &McfsOptions) -> Option<Cover> {
    let mut tracks = tracks::tracks(instance, tracks::first_distance_m(instance));
    let strips = tracks::strips(instance, &tracks, LEAST_STRIP);
    tracks.extend(strips);
    lines_along(instance, options, &tracks, FULL_GROUND_WORTH)
}

/// Joins tracks, shares them out and smooths them.
fn lines_along(
    instance: &PolygonInstance,
    options: &McfsOptions,
    tracks: &[Track],
    ground_worth: f64,
) -> Option<Cover> {
    if tracks.is_empty() {
        return None;
    }
    let walls = Walls::new(instance);
    let mut web = Web::new(tracks, instance.tool_width_m);
    joining::join(&mut web, &walls);
    let neighbours = Neighbours::new(&web, &walls);
    let drives: Vec<Option<Drives>> =
        instance.starts.iter().map(|&start| Drives::new(&web, &neighbours, &walls, start)).collect();
    let mut shares = Vec::new();
    let corrections_m = vec![0.0; instance.starts.len()];
    let lines = web.closed_lines();
    let mut sharing =
        Sharing { web: &mut web, walls: &walls, neighbours: &neighbours, drives: &drives, corrections_m };
    for line in lines {
        let robots: Vec<usize> = (0..instance.starts.len())
            .filter(|&robot| sharing.drive_m(robot, &line[..1]).is_finite())
            .collect();
        if !robots.is_empty() {
            shares.extend(sharing.peel(line, robots));
        }
    }
    sharing.settle(&mut shares, options.rounds);
    let mut best = smoothed(instance, &sharing, &shares, ground_worth);
    let mut lengths_m = best.lengths_m();
    for _ in 0..options.corrections {
        for share in &shares {
            let raw_m = sharing.cost_m(share) - sharing.corrections_m[share.robot];
            sharing.corrections_m[share.robot] = lengths_m[share.robot] - raw_m;
        }
        sharing.settle(&mut shares, options.rounds);
            let again = smoothed(instance, &sharing, &shares, ground_worth);
        lengths_m = again.lengths_m();
        if again.makespan_m() < best.makespan_m() {
            best = again;
        }
    }
    Some(best)
}

/// The shares as lines from the starts and back, smoothed.
fn smoothed(
    instance: &PolygonInstance,
    sharing: &Sharing<'_>,
    shares: &[Share],
    ground_worth: f64,
) -> Cover {
    let mut lines: Vec<Vec<Point>> = instance.starts.iter().map(|&start| vec![start]).collect();
    for share in shares {
        if let Some(drives) = &sharing.drives[share.robot] {
            let start = instance.starts[share.robot];
            lines[share.robot] = round_trip(sharing.web, sharing.walls, drives, share, start);
        }
    }
    let mut swept = SweptCounts::new(&instance.ground, instance.tool_width_m);
    for pair in lines.iter().flat_map(|line| line.windows(2)) {
        swept.put_in(pair[0], pair[1]);
    }
    let (walls, width_m) = (sharing.walls, instance.tool_width_m);
    Smoothing { swept: &mut swept, walls, width_m, ground_worth }.smooth(&mut lines);
    Cover { coverage: swept.coverage(), lines }
}

fn length_m(line: &[Point]) -> f64 {
    line.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

/// From the start into a closed line where that is shortest, along it, and back.
fn round_trip(web: &Web, walls: &Walls, drives: &Drives, share: &Share, start: Point) -> Vec<Point> {
    let line = &share.line;
    let after = |at: usize| line[(at + 1) % line.len()];
    let detour_m = |at: usize| {
        let (place, next) = (line[at], after(at));
        drives.distance_m[place as usize] + drives.distance_m[next as usize] - web.distance_m(place, next)
    };
    let leaves = (0..line.len()).min_by(|&a, &b| detour_m(a).total_cmp(&detour_m(b))).unwrap_or(0);
    let mut points = drives.way(web, walls, start, after(leaves));
    points.extend((2..=line.len()).map(|step| web.at[line[(leaves + step) % line.len()] as usize]));
    points.extend(drives.way(web, walls, start, line[leaves]).into_iter().rev().skip(1));
    points
}

/// The tracks of full coverage with their numbers from the walls inwards, ground on the left: isolines for the paper's
/// own pipeline.
pub(crate) fn numbered_tracks(instance: &PolygonInstance) -> Vec<(u32, Vec<Point>)> {
    let tracks = tracks::tracks(instance, tracks::first_distance_m(instance));
    tracks.into_iter().map(|track| (track.depth as u32, track.corners)).collect()
}
