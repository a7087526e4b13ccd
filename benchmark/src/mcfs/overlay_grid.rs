//! Grid planners on the coarse grids that the paper lays over its polygons: its baselines.

use crate::{BenchmarkError, content, cpu::timed, read, read_json, task::Task};
use planner::{Mode, Start};
use serde::Deserialize;
use std::path::Path;
use terrain::{Floor, GridMap, Lattice, MotionModel, Point, parse_movingai};

#[derive(Deserialize)]
struct Grid {
    origin: [f64; 2],
    resolution: f64,
}

#[derive(Deserialize)]
struct Starts {
    grid_baseline: Vec<[f64; 2]>,
}

#[derive(Deserialize)]
struct File {
    tool_width: f64,
    alternative_starts: Starts,
    grid: Grid,
    stc_grid: Grid,
}

/// A grid planner, and what it stands for in the paper.
#[derive(Debug, Clone, Copy)]
pub(super) struct Baseline {
    pub(super) planner: &'static str,
    pub(super) method: &'static str,
    /// Whether the grid is the one of large cells, four of the tool's.
    large_cells: bool,
}

pub(super) const BASELINES: [Baseline; 2] = [
    Baseline { planner: "tmstc-star", method: "TMSTC*", large_cells: true },
    Baseline { planner: "msa-mtsp", method: "TMC", large_cells: false },
];

/// One metre a second, nothing else takes time: the makespan is a length.
const MOTION: MotionModel = MotionModel {
    speed_m_per_s: 1.0,
    acceleration_m_per_s2: f64::INFINITY,
    angular_speed_rad_per_s: f64::INFINITY,
    angular_acceleration_rad_per_s2: f64::INFINITY,
    brakes: false,
};

/// One closed line per robot, and the CPU time it took.
pub(super) fn paths(
    instances: &Path,
    name: &str,
    baseline: Baseline,
) -> Result<(Vec<Vec<Point>>, f64), BenchmarkError> {
    let json = instances.join(format!("mcfs/{name}.json"));
    let file: File = read_json(&json)?;
    let (grid, ending) = if baseline.large_cells { (&file.stc_grid, "stc.map") } else { (&file.grid, "map") };
    let path = instances.join(format!("mcfs/{name}.{ending}"));
    let map = parse_movingai(&read(&path)?, 1.0).map_err(|error| content(&path, error.to_string()))?;
    let floor = floor(&map, grid, file.tool_width);
    let starts = file.alternative_starts.grid_baseline.iter().map(|&start| nearest(&floor, start.into()));
    let task = Task {
        name: name.to_owned(),
        starts: starts.collect(),
        floor,
        motion: MOTION,
        mode: Mode::CoverAndReturn,
        weights: None,
    };
    let (planned, cpu_s) = timed(|| task.plan(baseline.planner, 1));
    let planned = planned.map_err(|error| content(&path, error.to_string()))?;
    let routes = planned.plan.routes().iter();
    Ok((routes.map(|route| route.points.clone()).collect(), cpu_s))
}

/// Cells as wide as the tool, several in a square of the map.
fn floor(map: &GridMap, grid: &Grid, tool_width_m: f64) -> Floor {
    let cells = (grid.resolution / tool_width_m).round() as u32;
    let (columns, rows) = (cells * map.columns(), cells * map.rows());
    let lattice = Lattice { origin: Point::from(grid.origin), cell_m: tool_width_m, columns, rows };
    let square = |index: i32| i64::from(index) / i64::from(cells);
    let free: Vec<bool> = lattice.cells().map(|cell| map.is_free(square(cell.x), square(cell.y))).collect();
    Floor::from_cells(lattice, &free, tool_width_m * 0.45, tool_width_m)
}

fn nearest(floor: &Floor, place: Point) -> Start {
    let lattice = floor.lattice();
    let open = lattice.cells().filter(|&cell| floor.cell_is_drivable(cell));
    let distance = |cell| (lattice.center(cell) - place).norm();
    let cell = open.min_by(|&one, &other| distance(one).total_cmp(&distance(other)));
    Start::at(cell.expect("a map has free ground"))
}
