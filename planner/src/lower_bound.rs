//! A time that no plan along the lattice can beat.
//!
//! Three things that every plan has to do, whatever the planner:
//!
//! - **Moves.** A closed walk enters and leaves each cell, so each cell to visit has two uses of edges. Half the
//!   cells are black, half white, as on a chessboard: the linear programme "each cell has at least two uses" is
//!   integral, and its value is twice a minimum edge cover. Without weights that is 2 (n − ν) moves with ν the size of
//!   a maximum matching; with weights a feasible solution of the dual programme bounds it from below. A walk that may
//!   end anywhere lacks one use at either end; and it enters each cell but its first.
//! - **Turns.** The straight pieces of all walks contain all cells; the least number of maximal runs that do is a
//!   minimum vertex cover of the graph of runs, by König's theorem a maximum matching. k walks of s pieces turn at
//!   least s − k times; each piece has its ramps.
//! - **Reach.** Somebody gets to the cell that is farthest from all starts (and back).
//!
//! Moves and turns are shared by the robots of a connected piece of ground, each from the time on when it is
//! available: the time at which they can have done it all together is the bound. The largest over all pieces counts.
//! O(E √V). The bound on turns holds for turns by at least a quarter; paths off the lattice may beat all of it.

use crate::{
    Instance, Mode,
    matching::{Bipartite, Matching},
};
use std::{
    cmp::Reverse,
    collections::{BTreeMap, BTreeSet, BinaryHeap},
    f64::consts::{FRAC_PI_2, PI},
};
use terrain::{Cell, Direction};

/// Rounds of raising the dual solution; each can only tighten the bound.
const DUAL_ROUNDS: usize = 8;

/// A time that no plan along the lattice can beat, seconds. 0 for what cannot be planned at all.
pub fn lower_bound_s(instance: &Instance<'_>) -> f64 {
    let instance = &instance.with_open_starts();
    let component = instance.components();
    let mut pieces: BTreeMap<u32, Piece> = BTreeMap::new();
    for (index, &number) in component.iter().enumerate() {
        if instance.visit[index] && number != u32::MAX {
            pieces.entry(number).or_default().cells.push(index);
        }
    }
    for (robot, start) in instance.starts.iter().enumerate() {
        let number = instance.floor.lattice().index(start.cell).map(|index| component[index]);
        if let Some(piece) = number.and_then(|number| pieces.get_mut(&number)) {
            piece.robots.push(robot);
        }
    }
    let served = pieces.values().filter(|piece| !piece.robots.is_empty());
    served.map(|piece| piece.bound_s(instance)).fold(0.0, f64::max)
}

/// A time that no plan can beat that sweeps its share ([`Instance::coverage_min`]) of an area, on the lattice or off it,
/// seconds: along a line of length L a disc of width w sweeps at most w·L + π·w²/4.
pub fn area_bound_s(instance: &Instance<'_>, area_m2: f64) -> f64 {
    let width_m = instance.floor.tool_width_m();
    let own_m2 = instance.coverage_min * area_m2 / instance.starts.len() as f64;
    let length_m = (own_m2 - PI * width_m * width_m / 4.0) / width_m;
    (length_m / instance.motion.speed_m_per_s).max(0.0)
}

/// A connected piece of open ground.
#[derive(Debug, Default)]
struct Piece {
    /// Cells to visit, by number.
    cells: Vec<usize>,
    robots: Vec<usize>,
}

impl Piece {
    fn bound_s(&self, instance: &Instance<'_>) -> f64 {
        self.shared_s(instance).max(self.reach_s(instance))
    }

    /// The time at which the robots together can have done all the work.
    ///
    /// A robot that never moves covers its start for nothing: it takes some work off, and itself. Where there is
    /// enough work for robots that begin at once, that makes the others later; else starts are left out.
    fn shared_s(&self, instance: &Instance<'_>) -> f64 {
        let starts: BTreeSet<usize> = self
            .robots
            .iter()
            .filter_map(|&robot| instance.floor.lattice().index(instance.starts[robot].cell))
            .collect();
        let others = self.cells.iter().copied().filter(|index| !starts.contains(index)).collect();
        let rest = Self { cells: others, robots: self.robots.clone() };
        if rest.cells.is_empty() {
            return 0.0;
        }
        let work_s = self.moves_s(instance) + self.turns_s(instance);
        let cheapest_s = starts.iter().map(|&index| cheapest_move_s(instance, index));
        let saved_s = 2.0 * cheapest_s.filter(|s| s.is_finite()).fold(0.0, f64::max) + ramps_s(instance);
        let at_once = self.robots.iter().all(|&robot| instance.starts[robot].available_in_s == 0.0);
        if at_once && work_s >= self.robots.len() as f64 * saved_s {
            return self.done_s(instance, work_s);
        }
        self.done_s(instance, rest.moves_s(instance) + rest.turns_s(instance))
    }

    fn done_s(&self, instance: &Instance<'_>, work_s: f64) -> f64 {
        if work_s <= 0.0 {
            return 0.0;
        }
        let mut delays_s: Vec<f64> =
            self.robots.iter().map(|&robot| instance.starts[robot].available_in_s).collect();
        delays_s.sort_by(f64::total_cmp);
        // With the first m robots at work all are done at (work + delays) / m; more help while that is later.
        let mut sum_s = 0.0;
        let mut done_s = f64::INFINITY;
        for (number, delay_s) in delays_s.iter().enumerate() {
            if *delay_s >= done_s {
                break;
            }
            sum_s += delay_s;
            done_s = (work_s + sum_s) / (number + 1) as f64;
        }
        done_s
    }

    /// Time that moves alone take all robots together, at full speed.
    fn moves_s(&self, instance: &Instance<'_>) -> f64 {
        let cheapest_s: Vec<f64> = self
            .cells
            .iter()
            .map(|&index| cheapest_move_s(instance, index))
            .filter(|seconds| seconds.is_finite())
            .collect();
        let closed_s = match &instance.weights {
            None => 2.0 * (cheapest_s.len() - self.pairs(instance)) as f64 * plain_move_s(instance),
            Some(_) => 2.0 * self.dual_s(instance),
        };
        let largest_s = cheapest_s.iter().copied().fold(0.0, f64::max);
        let open_s = match instance.mode {
            Mode::CoverAndReturn => return closed_s,
            Mode::Cover => closed_s - 2.0 * self.robots.len() as f64 * largest_s,
        };
        let mut to_enter_s = cheapest_s;
        to_enter_s.sort_by(f64::total_cmp);
        to_enter_s.truncate(to_enter_s.len().saturating_sub(self.robots.len()));
        open_s.max(to_enter_s.iter().sum())
    }

    /// Pairs of neighbours that can be formed among the cells to visit.
    fn pairs(&self, instance: &Instance<'_>) -> usize {
        let lattice = instance.floor.lattice();
        let mut number_of = vec![u32::MAX; lattice.len()];
        let mut sides = [0_u32; 2];
        let black = |cell: Cell| usize::from((cell.x + cell.y) & 1 == 0);
        for &index in &self.cells {
            let side = &mut sides[black(lattice.cell(index))];
            number_of[index] = *side;
            *side += 1;
        }
        let mut edges = Vec::new();
        for &index in self.cells.iter().filter(|&&index| black(lattice.cell(index)) == 0) {
            for next in instance.neighbours(lattice.cell(index)) {
                let next = lattice.index(next).expect("a neighbour is on the lattice");
                if number_of[next] != u32::MAX {
                    edges.push((number_of[index], number_of[next]));
                }
            }
        }
        Matching::maximum(&Bipartite::new(sides[0] as usize, sides[1] as usize, &edges)).size
    }

    /// A feasible value of the dual of the minimum edge cover: prices of cells of which no two neighbours have more
    /// than the move between them.
    fn dual_s(&self, instance: &Instance<'_>) -> f64 {
        let lattice = instance.floor.lattice();
        let mut price_s = vec![0.0; lattice.len()];
        for &index in &self.cells {
            let cheapest_s = cheapest_move_s(instance, index);
            price_s[index] = if cheapest_s.is_finite() { cheapest_s / 2.0 } else { 0.0 };
        }
        for _ in 0..DUAL_ROUNDS {
            for &index in &self.cells {
                let cell = lattice.cell(index);
                let room_s = instance
                    .neighbours(cell)
                    .filter_map(|next| Some(instance.move_s(cell, next) - price_s[lattice.index(next)?]))
                    .fold(f64::INFINITY, f64::min);
                if room_s.is_finite() {
                    price_s[index] = f64::max(price_s[index], room_s);
                }
            }
        }
        price_s.iter().sum()
    }

    /// Time that turns and the ramps of straight pieces add, all robots together.
    fn turns_s(&self, instance: &Instance<'_>) -> f64 {
        let robots = self.robots.len() as f64;
        let pieces = self.straight_pieces(instance) as f64;
        pieces * ramps_s(instance) + (pieces - robots).max(0.0) * instance.motion.turn_s(FRAC_PI_2)
    }

    /// The fewest straight runs of open cells that contain all cells to visit which can be entered.
    fn straight_pieces(&self, instance: &Instance<'_>) -> usize {
        let (across, rows) = runs(instance, Direction::West);
        let (along, columns) = runs(instance, Direction::South);
        let lattice = instance.floor.lattice();
        let enterable = |index: &&usize| instance.neighbours(lattice.cell(**index)).next().is_some();
        let edges: Vec<(u32, u32)> =
            self.cells.iter().filter(enterable).map(|&index| (across[index], along[index])).collect();
        Matching::maximum(&Bipartite::new(rows, columns, &edges)).size
    }

    /// Time to the farthest cell to visit, driven straight.
    fn reach_s(&self, instance: &Instance<'_>) -> f64 {
        let seconds = self.seconds_from_starts(instance);
        let farthest_s = self.cells.iter().map(|&index| seconds[index]).fold(0.0, f64::max);
        let way_s = match instance.mode {
            Mode::Cover => farthest_s,
            Mode::CoverAndReturn => 2.0 * farthest_s,
        };
        let way_m = way_s * instance.motion.speed_m_per_s;
        if instance.weights.is_some() { way_s } else { instance.motion.run_s(way_m) }
    }

    /// Row-major: seconds at full speed from the nearest start.
    fn seconds_from_starts(&self, instance: &Instance<'_>) -> Vec<f64> {
        let lattice = instance.floor.lattice();
        let mut seconds = vec![f64::INFINITY; lattice.len()];
        let mut heap = BinaryHeap::new();
        for &robot in &self.robots {
            let index = lattice.index(instance.starts[robot].cell).expect("a start is on the lattice");
            seconds[index] = 0.0;
            heap.push(Reverse((0_u64, index)));
        }
        // Positive floats compare as their bits do.
        while let Some(Reverse((bits, index))) = heap.pop() {
            let so_far_s = f64::from_bits(bits);
            if so_far_s > seconds[index] {
                continue;
            }
            let cell = lattice.cell(index);
            for next in instance.neighbours(cell) {
                let next_s = so_far_s + instance.move_s(cell, next);
                let next = lattice.index(next).expect("a neighbour is on the lattice");
                if next_s < seconds[next] {
                    seconds[next] = next_s;
                    heap.push(Reverse((next_s.to_bits(), next)));
                }
            }
        }
        seconds
    }
}

fn plain_move_s(instance: &Instance<'_>) -> f64 {
    instance.floor.lattice().cell_m / instance.motion.speed_m_per_s
}

/// What the shortest straight piece takes longer than at full speed; longer pieces lose no less.
fn ramps_s(instance: &Instance<'_>) -> f64 {
    let cell_m = instance.floor.lattice().cell_m;
    instance.motion.run_s(cell_m) - cell_m / instance.motion.speed_m_per_s
}

/// Seconds of the cheapest move to a cell; infinite where there is none.
fn cheapest_move_s(instance: &Instance<'_>, index: usize) -> f64 {
    let cell = instance.floor.lattice().cell(index);
    instance.neighbours(cell).map(|next| instance.move_s(cell, next)).fold(f64::INFINITY, f64::min)
}

/// Row-major: the number of the maximal straight run that an open cell belongs to, where runs go on from the
/// neighbour in direction `before`; and how many runs there are.
fn runs(instance: &Instance<'_>, before: Direction) -> (Vec<u32>, usize) {
    let lattice = instance.floor.lattice();
    let mut run = vec![u32::MAX; lattice.len()];
    let mut count = 0;
    for cell in lattice.cells().filter(|&cell| instance.is_open(cell)) {
        let previous = cell.step(before);
        let goes_on = instance.floor.can_move(cell, before) && instance.is_open(previous);
        let own = lattice.index(cell).expect("cells() gives cells of the lattice");
        run[own] = if let Some(index) = lattice.index(previous).filter(|_| goes_on) {
            run[index]
        } else {
            count += 1;
            count as u32 - 1
        };
    }
    (run, count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_motion::MOTION;
    use crate::{PLANNERS, PlanOptions, Start, plan};
    use terrain::{Cell, Floor, GridMap};

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
    fn no_planner_beats_the_bound_of_the_area_and_lanes_come_near_it() {
        let row = ".".repeat(60) + "\n";
        let map = GridMap::from_drawing(row.repeat(40).trim_end(), 0.25).unwrap();
        let floor = Floor::new(&map, 0.25, 0.2, 0.5).unwrap();
        let starts = vec![Start::at(Cell::new(1, 1)), Start::at(Cell::new(50, 30))];
        let instance = Instance::whole_floor(&floor, starts, MOTION, Mode::Cover);
        let bound_s = area_bound_s(&instance, floor.coverable_m2());
        let mut ratios = Vec::new();
        for planner in ["boustrophedon-lanes", "mcfs", "tmstc-star"] {
            let options = PlanOptions { planner: planner.to_owned(), ..PlanOptions::default() };
            ratios.push(plan(&instance, &options).unwrap().figures().makespan_s / bound_s);
        }
        assert!(ratios.iter().all(|ratio| *ratio >= 1.0) && ratios[0] < 1.6, "{ratios:?}");
    }

    #[test]
    fn no_planner_beats_the_bound() {
        let map = GridMap::from_drawing("........\n..##....\n..##..#.\n........", 0.5).unwrap();
        let floor = Floor::new(&map, 0.5, 0.2, 0.75).unwrap();
        let along_lattice = PLANNERS.iter().filter(|planner| planner.name != "boustrophedon-lanes");
        for (planner, mode) in along_lattice.flat_map(|p| [(p, Mode::Cover), (p, Mode::CoverAndReturn)]) {
            let starts = vec![Start::at(Cell::new(0, 0)), Start::at(Cell::new(7, 3))];
            let instance = Instance::whole_floor(&floor, starts, MOTION, mode);
            let options = PlanOptions { planner: planner.name.to_owned(), ..PlanOptions::default() };
            let made = plan(&instance, &options).unwrap();
            assert!(made.figures().makespan_s >= lower_bound_s(&instance), "{}", planner.name);
        }
    }
}
