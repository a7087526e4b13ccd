//! The four maps and the starts of the TMSTC* paper.

use crate::{BenchmarkError, content, read, read_json, task::Task};
use planner::{Mode, Start};
use serde::Deserialize;
use std::{collections::BTreeMap, path::Path};
use terrain::{Cell, Floor, Lattice, MotionModel, Point, parse_movingai};

/// Maps in the order of the tables.
pub(crate) const MAPS: [&str; 4] = ["indoor", "random", "denver_2", "newyork_0"];

/// Table I and equation 8: a run has one ramp, turns start and stop at once.
pub(crate) const MOTION: MotionModel = MotionModel {
    speed_m_per_s: 0.5,
    acceleration_m_per_s2: 0.6,
    angular_speed_rad_per_s: 0.8,
    angular_acceleration_rad_per_s2: f64::INFINITY,
    brakes: false,
};

#[derive(Debug, Deserialize)]
struct MapStarts {
    #[serde(default)]
    k: Vec<usize>,
    #[serde(default)]
    robots: Vec<Robot>,
}

#[derive(Debug, Deserialize)]
struct Robot {
    /// Row from the top, column, of cells of 0.5 m.
    fine: [u32; 2],
}

/// A map with the sizes of teams and the starts of the largest.
#[derive(Debug)]
pub(crate) struct PaperMap {
    pub(crate) name: &'static str,
    pub(crate) floor: Floor,
    /// Sizes of teams in Table III.
    pub(crate) teams: Vec<usize>,
    starts: Vec<Start>,
}

impl PaperMap {
    pub(crate) fn load(instances: &Path, name: &'static str) -> Result<Self, BenchmarkError> {
        let folder = instances.join("tmstc");
        let floor = floor(&folder.join(format!("{name}.map")))?;
        let path = folder.join("starts.json");
        let all: BTreeMap<String, MapStarts> = read_json(&path)?;
        let own = all.get(name).ok_or_else(|| content(&path, format!("there is no map `{name}`")))?;
        let rows = floor.lattice().rows;
        let starts = own.robots.iter().map(|robot| {
            let [row, column] = robot.fine;
            Start::at(Cell::new(column as i32, rows as i32 - 1 - row as i32))
        });
        let starts = starts.collect();
        Ok(Self { name, teams: own.k.clone(), starts, floor })
    }

    pub(crate) fn task(&self, robots: usize, mode: Mode) -> Task {
        Task {
            name: format!("{} k={robots}", self.name),
            floor: self.floor.clone(),
            starts: self.starts[..robots].to_vec(),
            motion: MOTION,
            mode,
            weights: None,
        }
    }
}

/// Each character is a mega cell of 2 × 2 cells.
fn floor(path: &Path) -> Result<Floor, BenchmarkError> {
    let map = parse_movingai(&read(path)?, 1.0).map_err(|error| content(path, error.to_string()))?;
    let (columns, rows) = (2 * map.columns(), 2 * map.rows());
    let lattice = Lattice { origin: Point::origin(), cell_m: 0.5, columns, rows };
    let free: Vec<bool> =
        lattice.cells().map(|cell| map.is_free(i64::from(cell.x / 2), i64::from(cell.y / 2))).collect();
    Ok(Floor::from_cells(lattice, &free, 0.177, 0.5))
}
