//! Instances of `instances/grid`: a map, starts, and a cost per move and turn.

use crate::{BenchmarkError, content, read, read_json, task::Task};
use planner::{EdgeWeights, Mode, Start};
use serde::Deserialize;
use std::{
    f64::consts::FRAC_PI_2,
    path::{Path, PathBuf},
};
use terrain::{Cell, Floor, GridMap, Lattice, MotionModel, Point, parse_movingai};

#[derive(Debug, Deserialize)]
struct File {
    name: String,
    map: PathBuf,
    robots: Vec<[u32; 2]>,
    cost: Cost,
    edge_weights: Option<Weights>,
}

#[derive(Debug, Deserialize)]
struct Cost {
    scale: f64,
    #[serde(rename = "move")]
    one_move: f64,
    turn90: u32,
    turn180: u32,
    closed: bool,
}

/// One line of numbers per row of the map, from the top.
#[derive(Debug, Deserialize)]
struct Weights {
    right: Vec<String>,
    down: Vec<String>,
}

/// The instance in a file. Costs are seconds here: a unit of cost is a second.
pub(crate) fn load(path: &Path) -> Result<Task, BenchmarkError> {
    let file: File = read_json(path)?;
    let map_path = path.with_file_name(&file.map);
    let map =
        parse_movingai(&read(&map_path)?, 1.0).map_err(|error| content(&map_path, error.to_string()))?;
    if file.cost.turn180 != 2 * file.cost.turn90 || !file.cost.closed {
        return Err(content(path, "only closed walks with turn180 = 2 × turn90 are taken"));
    }
    let page = Page { rows: map.rows(), columns: map.columns() };
    let starts = file.robots.iter().map(|&[x, y]| Start {
        // "+y": towards the lower edge of the map.
        heading_rad: Some(-FRAC_PI_2),
        ..Start::at(page.cell(x, y))
    });
    let weights = file.edge_weights.as_ref().map(|weights| page.weights(path, weights, file.cost.one_move));
    Ok(Task {
        name: file.name,
        starts: starts.collect(),
        floor: page.floor(&map),
        motion: motion(&file.cost),
        mode: Mode::CoverAndReturn,
        weights: weights.transpose()?,
    })
}

/// Moves and turns at a price, ramps for nothing.
fn motion(cost: &Cost) -> MotionModel {
    MotionModel {
        speed_m_per_s: cost.scale / cost.one_move,
        acceleration_m_per_s2: f64::INFINITY,
        angular_speed_rad_per_s: FRAC_PI_2 * cost.scale / f64::from(cost.turn90),
        angular_acceleration_rad_per_s2: f64::INFINITY,
        brakes: false,
    }
}

/// The map as printed: rows from the top. Blocks of 2 × 2 are counted from the top, too; a row of wall below keeps
/// them aligned to our lattice, whose rows count from the bottom.
#[derive(Debug, Clone, Copy)]
struct Page {
    rows: u32,
    columns: u32,
}

impl Page {
    fn lattice(self) -> Lattice {
        let rows = self.rows.next_multiple_of(2);
        Lattice { origin: Point::origin(), cell_m: 1.0, columns: self.columns, rows }
    }

    fn cell(self, x: u32, row: u32) -> Cell {
        Cell::new(x as i32, self.lattice().rows as i32 - 1 - row as i32)
    }

    fn floor(self, map: &GridMap) -> Floor {
        let lattice = self.lattice();
        let below = i64::from(lattice.rows - self.rows);
        let free: Vec<bool> =
            lattice.cells().map(|cell| map.is_free(i64::from(cell.x), i64::from(cell.y) - below)).collect();
        Floor::from_cells(lattice, &free, 0.35, 1.0)
    }

    fn weights(self, path: &Path, weights: &Weights, one_move: f64) -> Result<EdgeWeights, BenchmarkError> {
        let lattice = self.lattice();
        let mut right = vec![1.0; lattice.len()];
        let mut up = right.clone();
        for (lines, list, lower) in [(&weights.right, &mut right, 0), (&weights.down, &mut up, 1)] {
            for (row, line) in lines.iter().enumerate() {
                for (x, word) in line.split_whitespace().enumerate() {
                    let value: f64 = word
                        .parse()
                        .map_err(|_| content(path, format!("`{word}` in row {row} is no weight")))?;
                    // The edge down from a cell is the edge up from the one below it.
                    let cell = self.cell(x as u32, row as u32 + lower);
                    let index = lattice.index(cell).ok_or_else(|| content(path, "weights beyond the map"))?;
                    list[index] = if value > 0.0 { value / one_move } else { 1.0 };
                }
            }
        }
        Ok(EdgeWeights { right, up })
    }
}
