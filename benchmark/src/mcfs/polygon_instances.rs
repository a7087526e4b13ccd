//! The seven polygons of the MCFS paper, and the paths that its authors stored.

use crate::{BenchmarkError, content, read_json};
use geo::{LineString, Polygon};
use planner::mcfs::PolygonInstance;
use serde::Deserialize;
use std::path::Path;
use terrain::Point;

/// Names of the files, in the order of the paper's tables.
pub const NAMES: [&str; 7] = ["I", "C", "A", "P", "S", "double_torus", "office"];

type Corners = Vec<[f64; 2]>;

#[derive(Deserialize)]
struct Rings {
    exterior: Corners,
    #[serde(default)]
    holes: Vec<Corners>,
}

#[derive(Deserialize)]
struct Robot {
    start: [f64; 2],
}

#[derive(Deserialize)]
struct File {
    tool_width: f64,
    polygon: Rings,
    robots: Vec<Robot>,
    alternative_starts: AlternativeStarts,
}

#[derive(Deserialize)]
struct AlternativeStarts {
    nominal: Corners,
}

#[derive(Deserialize)]
struct StoredPaths {
    paths: Vec<Corners>,
}

/// Reads `<folder>/mcfs/<name>.json`.
///
/// # Errors
///
/// [`BenchmarkError`], when it cannot be read or is not sound.
pub fn load(folder: &Path, name: &str) -> Result<PolygonInstance, BenchmarkError> {
    let path = folder.join(format!("mcfs/{name}.json"));
    let file: File = read_json(&path)?;
    let starts = file.robots.iter().map(|robot| Point::from(robot.start)).collect();
    instance(&path, file, starts)
}

/// The same with the starts that the authors name: points of the isolines where trees are rooted.
///
/// # Errors
///
/// As [`load`].
pub fn load_with_nominal_starts(folder: &Path, name: &str) -> Result<PolygonInstance, BenchmarkError> {
    let path = folder.join(format!("mcfs/{name}.json"));
    let file: File = read_json(&path)?;
    let starts = file.alternative_starts.nominal.iter().copied().map(Point::from).collect();
    instance(&path, file, starts)
}

fn instance(path: &Path, file: File, starts: Vec<Point>) -> Result<PolygonInstance, BenchmarkError> {
    let ring = |corners: Corners| LineString::from(corners);
    let instance = PolygonInstance {
        ground: Polygon::new(ring(file.polygon.exterior), file.polygon.holes.into_iter().map(ring).collect()),
        tool_width_m: file.tool_width,
        body_radius_m: file.tool_width / 2.0,
        starts,
    };
    instance.check().map_err(|error| content(path, error.to_string()))?;
    Ok(instance)
}

/// Reads `<folder>/mcfs/peer_paths/<name>.json`: one open line per robot.
///
/// # Errors
///
/// [`BenchmarkError`], when it cannot be read.
pub fn stored_paths(folder: &Path, name: &str) -> Result<Vec<Vec<Point>>, BenchmarkError> {
    let file: StoredPaths = read_json(&folder.join(format!("mcfs/peer_paths/{name}.json")))?;
    Ok(file.paths.into_iter().map(|path| path.into_iter().map(Point::from).collect()).collect())
}
