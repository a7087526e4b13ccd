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
pub(crate) mod tracks;
mod walls;
mod web;

pub use polygon_instance::{PolygonError, PolygonInstance, RingName};

use crate::{Plan, Route};
use drive::{Drives, Neighbours};
use sharing::{Share, Sharing};
use smoothing::Smoothing;
use swept_counts::SweptCounts;
use terrain::Point;
use walls::Walls;
use web::Web;

/// How to cover polygons.
#[derive(Debug, Clone, PartialEq)]
pub struct McfsOptions {
    /// Bound on the rounds in which shares are evened out.
    pub rounds: usize,
}

impl Default for McfsOptions {
    fn default() -> Self {
        Self { rounds: 12 }
    }
}

/// One closed line per robot, from its start and back.
///
/// # Errors
///
/// [`PolygonError`], when the polygon or a start is not sound.
pub fn cover(instance: &PolygonInstance, options: &McfsOptions) -> Result<Plan, PolygonError> {
    instance.check()?;
    let tracks = tracks::tracks(instance);
    if tracks.is_empty() {
        return Err(PolygonError::TooWide { width_m: 2.0 * instance.clearance_m() });
    }
    let walls = Walls::new(instance);
    let mut web = Web::new(&tracks, instance.tool_width_m);
    joining::join(&mut web, &walls);
    let neighbours = Neighbours::new(&web, &walls);
    let drives: Vec<Option<Drives>> =
        instance.starts.iter().map(|&start| Drives::new(&web, &neighbours, &walls, start)).collect();
    let mut shares = Vec::new();
    for line in web.closed_lines() {
        let reaches = |&robot: &usize| {
            drives[robot].as_ref().is_some_and(|drives| drives.distance_m[line[0] as usize].is_finite())
        };
        let robots: Vec<usize> = (0..instance.starts.len()).filter(reaches).collect();
        if !robots.is_empty() {
            let mut sharing =
                Sharing { web: &mut web, walls: &walls, neighbours: &neighbours, drives: &drives };
            shares.extend(sharing.share_out(line, &robots, options.rounds));
        }
    }
    let mut lines: Vec<Vec<Point>> = instance.starts.iter().map(|&start| vec![start]).collect();
    for share in &shares {
        if let Some(drives) = &drives[share.robot] {
            lines[share.robot] = round_trip(&web, &walls, drives, share, instance.starts[share.robot]);
        }
    }
    let mut swept = SweptCounts::new(&instance.ground, instance.tool_width_m);
    for pair in lines.iter().flat_map(|line| line.windows(2)) {
        swept.put_in(pair[0], pair[1]);
    }
    Smoothing { swept: &mut swept, walls: &walls, width_m: instance.tool_width_m }.smooth(&mut lines);
    Ok(Plan { routes: lines.into_iter().map(|points| Route { points }).collect() })
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
