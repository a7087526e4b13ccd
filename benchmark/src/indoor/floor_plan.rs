//! A floor plan of the instances, its robot and its stations.

use super::evaluator::{Evaluator, Robot};
use crate::{
    BenchmarkError, content, read_json,
    task::{Outcome, Task},
};
use planner::{Instance, Mode, PlanError, PlanOptions, Start, plan};
use serde::Deserialize;
use std::path::Path;
use terrain::{Floor, GridMap, MapFile, MotionModel, Point};

/// One of `NAME.yaml`, `NAME.pgm` and `NAME.stations.json`.
pub(crate) struct FloorPlan {
    #[allow(dead_code, reason = "for tables of several robots")]
    pub(crate) name: String,
    pub(crate) map: GridMap,
    pub(crate) floor: Floor,
    pub(crate) robot: Robot,
    pub(crate) stations: Vec<Point>,
    /// Seconds of operation; `None` is without limit.
    #[allow(dead_code, reason = "for tables with batteries")]
    pub(crate) capacities_s: Vec<Option<f64>>,
    /// As the notes that come with the map say.
    #[cfg_attr(not(test), expect(dead_code, reason = "the evaluator is checked against it"))]
    pub(crate) coverable_area_m2: f64,
}

#[derive(Deserialize)]
struct StationsFile {
    robot: RobotFile,
    coverable_area_m2: f64,
    capacities_s: Vec<Option<f64>>,
    stations: Vec<Station>,
}

#[derive(Deserialize)]
struct RobotFile {
    radius_m: f64,
    tool_width_m: f64,
    speed_mps: f64,
    turn_rate_rad_s: f64,
}

#[derive(Deserialize)]
struct Station {
    x_m: f64,
    y_m: f64,
}

impl FloorPlan {
    pub(crate) fn load(folder: &Path, name: &str) -> Result<Self, BenchmarkError> {
        let path = folder.join(format!("{name}.stations.json"));
        let file: StationsFile = read_json(&path)?;
        let robot = Robot {
            radius_m: file.robot.radius_m,
            tool_width_m: file.robot.tool_width_m,
            speed_m_per_s: file.robot.speed_mps,
            turn_rate_rad_per_s: file.robot.turn_rate_rad_s,
        };
        let yaml = folder.join(format!("{name}.yaml"));
        let reader = MapFile { metres_per_character: 1.0, square_m: 0.05 };
        let map = reader.load(&yaml).map_err(|error| content(&yaml, error.to_string()))?;
        // Cells as small as pixels: every passage of the evaluator is one of the lattice.
        let radius_m = robot.radius_to_squares_m(map.resolution_m());
        let floor = Floor::new(&map, map.resolution_m(), radius_m, robot.tool_width_m)
            .map_err(|error| content(&path, error.to_string()))?;
        Ok(Self {
            name: name.to_owned(),
            map,
            floor,
            robot,
            stations: file.stations.iter().map(|station| Point::new(station.x_m, station.y_m)).collect(),
            capacities_s: file.capacities_s,
            coverable_area_m2: file.coverable_area_m2,
        })
    }

    pub(crate) fn evaluator(&self) -> Evaluator<'_> {
        Evaluator::new(&self.map, self.robot)
    }

    /// Turns and runs that start and stop at once, as the evaluator counts.
    pub(crate) fn motion(&self) -> MotionModel {
        MotionModel {
            speed_m_per_s: self.robot.speed_m_per_s,
            acceleration_m_per_s2: f64::INFINITY,
            angular_speed_rad_per_s: self.robot.turn_rate_rad_per_s,
            angular_acceleration_rad_per_s2: f64::INFINITY,
            brakes: true,
        }
    }

    /// A robot that stands on a station.
    pub(crate) fn start(&self, station: usize) -> Start {
        let point = self.stations[station];
        let cell = self.floor.lattice().cell_at(point).expect("stations lie on the map");
        Start { point: Some(point), ..Start::at(cell) }
    }

    /// The whole floor from these stations and back.
    #[allow(dead_code, reason = "for tables of several robots")]
    pub(crate) fn task(&self, stations: &[usize]) -> Task {
        Task {
            name: self.name.clone(),
            floor: self.floor.clone(),
            starts: stations.iter().map(|&station| self.start(station)).collect(),
            motion: self.motion(),
            mode: Mode::CoverAndReturn,
            weights: None,
        }
    }

    /// Plans for one robot; planning and verification are timed.
    pub(crate) fn plan(
        &self,
        planner: &str,
        station: usize,
        coverage_min: f64,
        effort: u32,
    ) -> Result<Outcome, PlanError> {
        let instance = self.instance(station, coverage_min);
        let options = PlanOptions { planner: planner.to_owned(), effort, ..PlanOptions::default() };
        let (planned, cpu_s) = crate::cpu::timed(|| plan(&instance, &options));
        Ok(Outcome { plan: planned?, cpu_s })
    }

    /// One robot from a station and back.
    pub(crate) fn instance(&self, station: usize, coverage_min: f64) -> Instance<'_> {
        let starts = vec![self.start(station)];
        let mut instance = Instance::whole_floor(&self.floor, starts, self.motion(), Mode::CoverAndReturn);
        instance.coverage_min = coverage_min;
        instance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_coverable_area_is_that_of_the_notes() {
        let folder = Path::new("../../shared/instances/indoor");
        if !folder.exists() {
            println!("skipped: {} is not there", folder.display());
            return;
        }
        for name in &super::super::MAPS[..5] {
            let floor_plan = FloorPlan::load(folder, name).unwrap();
            let (ours, notes) = (floor_plan.evaluator().coverable_m2(), floor_plan.coverable_area_m2);
            println!("{name}: {ours:.2} {notes:.2}");
            assert!((ours / notes - 1.0).abs() < 1e-3, "{name}: {ours} {notes}");
        }
    }
}
