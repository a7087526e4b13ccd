//! Instances of `instances/grid`: a map, starts, and a cost per move and turn.

use crate::{BenchmarkError, content, read, read_json, task::Task};
use planner::{EdgeWeights, Mode, Start};
use serde::Deserialize;
use std::{
    f64::consts::FRAC_PI_2,
    path::{Path, PathBuf},
};
use terrain::{Cell, Direction, Floor, GridMap, Lattice, MotionModel, Point, parse_movingai};

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
    let mut floor = page.floor(&map);
    let weights =
        file.edge_weights.as_ref().map(|weights| page.weights(path, weights, file.cost.one_move, &mut floor));
    Ok(Task {
        name: file.name,
        starts: starts.collect(),
        motion: motion(&file.cost),
        mode: Mode::CoverAndReturn,
        weights: weights.transpose()?,
        floor,
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

    /// Factors on moves; a weight of 0 says that there is no move.
    fn weights(
        self,
        path: &Path,
        weights: &Weights,
        one_move: f64,
        floor: &mut Floor,
    ) -> Result<EdgeWeights, BenchmarkError> {
        let lattice = self.lattice();
        let mut right = vec![1.0; lattice.len()];
        let mut up = right.clone();
        let lists =
            [(&weights.right, &mut right, 0, Direction::East), (&weights.down, &mut up, 1, Direction::North)];
        for (lines, list, lower, way) in lists {
            for (row, line) in lines.iter().enumerate() {
                for (x, word) in line.split_whitespace().enumerate() {
                    let value: f64 = word
                        .parse()
                        .map_err(|_| content(path, format!("`{word}` in row {row} is no weight")))?;
                    // The edge down from a cell is the edge up from the one below it.
                    let cell = self.cell(x as u32, row as u32 + lower);
                    let index = lattice.index(cell).ok_or_else(|| content(path, "weights beyond the map"))?;
                    if value > 0.0 {
                        list[index] = value / one_move;
                    } else {
                        floor.close_move(cell, way);
                    }
                }
            }
        }
        Ok(EdgeWeights { right, up })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planner::{Plan, Route, verify};

    #[derive(Deserialize)]
    struct Vector {
        instance: String,
        scale: f64,
        walks: Vec<Vec<[u32; 2]>>,
        move_cost: Vec<f64>,
        turn_cost: Vec<f64>,
    }

    /// Walks with their exact cost, made and measured by programs that are not ours.
    #[test]
    fn walks_of_others_cost_what_they_say() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/instances/grid");
        let Ok(entries) = std::fs::read_dir(folder.join("vectors")) else {
            println!("skipped: {} is not there", folder.display());
            return;
        };
        let mut count = 0;
        for entry in entries {
            let vector: Vector = read_json(&entry.unwrap().path()).unwrap();
            let task = load(&folder.join(format!("{}.json", vector.instance))).unwrap();
            let instance = task.instance();
            let page = Page { rows: task.floor.lattice().rows, columns: task.floor.lattice().columns };
            let route = |walk: &Vec<[u32; 2]>| {
                Route::new(walk.iter().map(|&[x, y]| instance.center(page.cell(x, y))).collect())
            };
            let plan = Plan { routes: vector.walks.iter().map(route).collect() };
            let figures = verify(&instance, &plan).unwrap();
            for (robot, cost_s) in figures.cost_s.iter().enumerate() {
                let expected = (vector.move_cost[robot] + vector.turn_cost[robot]) / vector.scale;
                assert!(
                    (cost_s - expected).abs() < 1e-6,
                    "{} {robot}: {cost_s}, {expected}",
                    vector.instance
                );
                count += 1;
            }
        }
        assert!(count > 30, "{count} walks");
    }
}
