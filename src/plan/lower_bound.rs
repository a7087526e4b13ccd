//! A time that no plan can beat.
//!
//! n cells are to be passed, and s of them are starts: n − s are left to enter, so one of k robots enters at least
//! ⌈(n − s) / k⌉. And some robot gets to the cell farthest from all starts, and back if it has to return. The larger
//! way, driven straight from standstill without a turn, takes no longer than the makespan of any plan.

use planner::{Instance, Mode};
use std::collections::VecDeque;

/// A time that no plan for this instance can beat, seconds.
pub fn lower_bound_s(instance: &Instance<'_>) -> f64 {
    let robots = instance.starts.len();
    if robots == 0 {
        return 0.0;
    }
    let distance = moves_from_starts(instance);
    let wanted = (0..distance.len()).filter(|&index| instance.visit[index]);
    let to_enter = wanted.clone().filter(|&index| distance[index] != Some(0)).count();
    let farthest = wanted.filter_map(|index| distance[index]).max().unwrap_or(0);
    let there_and_back = match instance.mode {
        Mode::Cover => farthest,
        Mode::CoverAndReturn => 2 * farthest,
    };
    let moves = to_enter.div_ceil(robots).max(there_and_back as usize);
    instance.motion.run_s(moves as f64 * instance.floor.lattice().cell_m)
}

/// Row-major: moves from the nearest start; `None` where no robot gets.
fn moves_from_starts(instance: &Instance<'_>) -> Vec<Option<u32>> {
    let lattice = instance.floor.lattice();
    let mut distance = vec![None; lattice.len()];
    let mut queue = VecDeque::new();
    for start in &instance.starts {
        if let Some(index) = lattice.index(start.cell).filter(|&index| distance[index].is_none()) {
            distance[index] = Some(0);
            queue.push_back(index);
        }
    }
    while let Some(index) = queue.pop_front() {
        let next_distance = distance[index].map(|moves: u32| moves + 1);
        for next in instance.neighbours(lattice.cell(index)) {
            let next = lattice.index(next).expect("a neighbour is on the lattice");
            if distance[next].is_none() {
                distance[next] = next_distance;
                queue.push_back(next);
            }
        }
    }
    distance
}

#[cfg(test)]
mod tests {
    use super::*;
    use planner::{PLANNERS, PlanOptions, Start, plan};
    use terrain::{Cell, Floor, GridMap, MotionModel};

    const MOTION: MotionModel = MotionModel {
        speed_m_per_s: 0.5,
        acceleration_m_per_s2: 0.6,
        angular_speed_rad_per_s: 0.8,
        angular_acceleration_rad_per_s2: f64::INFINITY,
        brakes: true,
    };

    #[test]
    fn a_corridor_driven_from_its_end_takes_just_the_bound() {
        let map = GridMap::from_drawing("..........", 0.5).unwrap();
        let floor = Floor::new(&map, 0.5, 0.2, 0.75).unwrap();
        let starts = vec![Start::at(Cell::new(0, 0))];
        let instance = Instance::whole_floor(&floor, starts, MOTION, Mode::Cover);
        assert!((lower_bound_s(&instance) - MOTION.run_s(4.5)).abs() < 1e-9);
        let made = plan(&instance, &PlanOptions::default()).unwrap();
        assert!((made.figures().makespan_s - lower_bound_s(&instance)).abs() < 1e-9);
    }

    #[test]
    fn no_planner_beats_the_bound() {
        let map = GridMap::from_drawing("........\n..##....\n..##..#.\n........", 0.5).unwrap();
        let floor = Floor::new(&map, 0.5, 0.2, 0.75).unwrap();
        for (planner, mode) in PLANNERS.iter().flat_map(|p| [(p, Mode::Cover), (p, Mode::CoverAndReturn)]) {
            let starts = vec![Start::at(Cell::new(0, 0)), Start::at(Cell::new(7, 3))];
            let instance = Instance::whole_floor(&floor, starts, MOTION, mode);
            let options = PlanOptions { planner: planner.name.to_owned(), ..PlanOptions::default() };
            let made = plan(&instance, &options).unwrap();
            assert!(made.figures().makespan_s >= lower_bound_s(&instance), "{}", planner.name);
        }
    }
}
