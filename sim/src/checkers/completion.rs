//! L1: what healthy robots can reach at the end is covered. What "can reach" means is reckoned from the world
//! alone, over moves of the lattice and passages: walls, obstacles and queues that are still there, machines that stand
//! dead on the floor.

use super::{Checker, Seen, for_each_cell};
use crate::{people::PERSON_RADIUS_M, world::World};
use coordinator::Publication;
use protocol::v1::{CellStatus, MissionState};
use terrain::{Cell, Passages, Point};

/// Ground this near to something that should not be there is nobody's duty, cells: the fleet keeps away from it
/// by whole cells, and by what its scans have seen.
const AROUND_OBSTACLES_CELLS: f64 = 2.0;

#[derive(Default)]
pub(super) struct Completion {
    covered: Vec<bool>,
}

impl Checker for Completion {
    fn look(&mut self, world: &mut World, seen: &Seen<'_>) -> Option<String> {
        match seen {
            Seen::Publication(Publication::Coverage(delta)) => {
                let lattice = world.scenario.floor.lattice();
                self.covered.resize(lattice.len(), false);
                for_each_cell(delta, lattice.columns, |index, status| {
                    self.covered[index] = status == CellStatus::CellCovered;
                });
                None
            }
            Seen::End { result: Some(result), healthy } => self.judge(world, result.mission_state(), healthy),
            _ => None,
        }
    }
}

impl Completion {
    fn judge(&self, world: &World, state: MissionState, healthy: &[bool]) -> Option<String> {
        if state == MissionState::Cancelled {
            return None;
        }
        let floor = &world.scenario.floor;
        let lattice = floor.lattice();
        let reachable = reachable(world, healthy);
        let is_open = |cell: &&Cell| {
            let index = lattice.index(**cell).expect("on the lattice");
            floor.required(index) != 0 && !self.covered.get(index).copied().unwrap_or(false)
        };
        let open: Vec<&Cell> = reachable.iter().filter(is_open).collect();
        let first = open.first()?;
        Some(format!(
            "{} cells are open that a healthy robot can reach, the first is {first}; the mission ended {}",
            open.len(),
            state.as_str_name()
        ))
    }
}

fn reachable(world: &World, healthy: &[bool]) -> Vec<Cell> {
    let floor = &world.scenario.floor;
    let keep_away_m = world.body_radius_m() + AROUND_OBSTACLES_CELLS * floor.lattice().cell_m;
    let dead: Vec<Point> = world
        .bodies
        .iter()
        .zip(healthy)
        .filter(|(body, healthy)| body.on_floor && !**healthy)
        .map(|(body, _)| body.position())
        .collect();
    let queues: Vec<Point> =
        world.people.iter().filter(|person| person.stands()).map(|person| person.position).collect();
    let is_clear = |cell: Cell| {
        let at = floor.lattice().center(cell);
        world.obstacles.iter().all(|obstacle| obstacle.shape.distance_m(at) > keep_away_m)
            && queues.iter().all(|&person| (person - at).norm() > keep_away_m + PERSON_RADIUS_M)
            && dead.iter().all(|&body| (body - at).norm() > keep_away_m + world.body_radius_m())
    };
    let starts = world
        .bodies
        .iter()
        .zip(healthy)
        .filter(|(body, healthy)| body.on_floor && **healthy)
        .filter_map(|(body, _)| floor.nearest_drivable(&world.scenario.map, body.position()));
    let reached = Passages::new(floor).reached(floor, starts, is_clear);
    floor.lattice().cells().zip(reached).filter(|&(_, reached)| reached).map(|(cell, _)| cell).collect()
}
