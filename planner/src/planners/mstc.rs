//! MSTC: multi-robot spanning tree coverage, with backtracking.
//!
//! **Problem.** As `stc`, for several robots that start where they start.
//! **Idea.** One spanning tree, one closed walk around it, and the robots stand on it. Each goes along the walk towards the next robot;
//! but it may also first cover a stretch behind it and backtrack. Between two neighbouring robots the walk is divided
//! so that the slowest is as quick as can be: for a bound on the moves each robot covers behind it what the one before leaves,
//! and goes ahead as far as the bound allows; the bound is bisected.
//! **Guarantee.** With k ≥ 3 robots at most half the moves of one robot, with two at most two thirds (as the paper shows for a
//! division that is no better than this one).
//! **Complexity.** O(n) for the walk, O(k²) at most for each bound, O(k n) for ways to the walk.
//! **Paper.** N. Hazon, G. A. Kaminka: Redundancy, efficiency and robustness in multi-robot coverage. IEEE International Conference on
//! Robotics and Automation (ICRA), 2005; the baseline of the MFC paper, which also has `mstc-optimized`.
//! **Departures.** The division is the best one of its kind, where the paper treats the largest gap alone. Robots that stand beside
//! the walk (on covered ground, say) go to its nearest cell first. In `cover and return` robots backtrack along their own way,
//! as the MFC paper has it; `mstc-optimized` takes shortest ways instead, there and between its two stretches.

use super::stc;
use crate::{
    Instance, Mode, Plan, PlanError, PlanOptions, Route,
    circumnavigation::loops,
    division::{Team, teams},
    shortest_way::WayFinder,
    spanning_graph::SpanningGraph,
};
use terrain::Cell;

const BISECTIONS: u32 = 40;

/// Plans with backtracking along the walk.
pub(super) fn plan(instance: &Instance<'_>, _options: &PlanOptions) -> Result<Plan, PlanError> {
    cover(instance, Backtracking::AlongTheWalk)
}

/// Plans with backtracking by shortest ways.
pub(super) fn plan_optimized(instance: &Instance<'_>, _options: &PlanOptions) -> Result<Plan, PlanError> {
    cover(instance, Backtracking::ByShortestWays)
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Backtracking {
    AlongTheWalk,
    ByShortestWays,
}

fn cover(instance: &Instance<'_>, backtracking: Backtracking) -> Result<Plan, PlanError> {
    let graph = SpanningGraph::new(instance);
    let forest = stc::depth_first_forest(&graph);
    let mut finder = WayFinder::new(instance);
    let mut routes = vec![Route::default(); instance.starts.len()];
    for (team, cells) in teams(instance, loops(&graph, &forest), &vec![true; instance.starts.len()])? {
        let ring = Ring::new(instance, &team, &cells);
        for (place, (behind, ahead)) in ring.places.iter().zip(ring.divide()) {
            let mut driver = Driver { instance, cells: &cells, backtracking, finder: &mut finder };
            routes[place.robot] = driver.route(place, behind, ahead)?;
        }
    }
    Ok(Plan { routes })
}

/// A robot on the walk.
#[derive(Debug, Clone, Copy)]
struct Place {
    robot: usize,
    /// Number of its cell on the walk.
    at: usize,
    /// Moves that it lacks when the first robot could begin.
    late: f64,
}

/// The walk with the robots in the order in which they stand on it.
struct Ring {
    places: Vec<Place>,
    /// Cells from each robot, its own left out, up to the cell before the next one.
    gaps: Vec<usize>,
}

impl Ring {
    fn new(instance: &Instance<'_>, team: &Team<'_>, cells: &[Cell]) -> Self {
        let lattice = instance.floor.lattice();
        let move_s = lattice.cell_m / instance.motion.speed_m_per_s;
        let mut places: Vec<Place> = team
            .robots
            .iter()
            .zip(&team.legs)
            .map(|(&robot, legs)| {
                let leg =
                    |number: &usize| legs[lattice.index(cells[*number]).expect("walks stay on the lattice")];
                let at = (0..cells.len()).min_by_key(leg).expect("a walk has cells");
                let late = f64::from(leg(&at)) + instance.starts[robot].available_in_s / move_s;
                Place { robot, at, late }
            })
            .collect();
        places.sort_by_key(|place| (place.at, place.robot));
        let gap = |number: usize| {
            let (own, next) = (places[number].at, places[(number + 1) % places.len()].at);
            match (next + cells.len() - own) % cells.len() {
                // The last robot in a cell has the way to the next one, and round where it is alone.
                0 if number + 1 == places.len() => cells.len() - 1,
                way => way.saturating_sub(1),
            }
        };
        let gaps = (0..places.len()).map(gap).collect();
        Self { places, gaps }
    }

    /// Per robot: cells to cover behind it and ahead of it.
    fn divide(&self) -> Vec<(usize, usize)> {
        let latest = self.places.iter().map(|place| place.late).fold(0.0, f64::max);
        let all: usize = self.gaps.iter().sum();
        let (mut low, mut high) = (0.0, latest + 3.0 * all as f64 + 1.0);
        let mut best = self.within(high).expect("with three times all moves one robot does it");
        for _ in 0..BISECTIONS {
            let bound = f64::midpoint(low, high);
            match self.within(bound) {
                Some(found) => {
                    best = found;
                    high = bound;
                }
                None => low = bound,
            }
        }
        best
    }

    /// A division in which nobody needs more moves than `bound`.
    fn within(&self, bound: f64) -> Option<Vec<(usize, usize)>> {
        let count = self.places.len();
        let mut behind = vec![0_usize; count];
        // What a robot has behind it only grows from round to round; it has settled when a round changes nothing.
        for _ in 0..=count {
            let mut changed = false;
            for number in 0..count {
                let ahead = ahead(bound - self.places[number].late, behind[number])?.min(self.gaps[number]);
                let next = (number + 1) % count;
                let left = self.gaps[number] - ahead;
                changed |= behind[next] != left;
                behind[next] = left;
            }
            if !changed {
                let ahead = |number: usize| self.gaps[number] - behind[(number + 1) % count];
                return Some((0..count).map(|number| (behind[number], ahead(number))).collect());
            }
        }
        None
    }
}

/// How many cells a robot can cover ahead within a bound when it has `behind` to cover behind it, whichever it does first; `None`
/// when that alone is too much.
fn ahead(bound: f64, behind: usize) -> Option<usize> {
    let behind = behind as f64;
    if behind > bound {
        return if behind == 0.0 { Some(0) } else { None };
    }
    Some((bound - 2.0 * behind).max((bound - behind) / 2.0).max(0.0).floor() as usize)
}

/// Makes routes of stretches.
struct Driver<'a> {
    instance: &'a Instance<'a>,
    cells: &'a [Cell],
    backtracking: Backtracking,
    finder: &'a mut WayFinder,
}

impl Driver<'_> {
    fn route(&mut self, place: &Place, behind: usize, ahead: usize) -> Result<Route, PlanError> {
        let count = self.cells.len();
        let cell = |number: usize| self.cells[number % count];
        let forwards: Vec<Cell> = (1..=ahead).map(|step| cell(place.at + step)).collect();
        let backwards: Vec<Cell> = (1..=behind).map(|step| cell(place.at + count - step)).collect();
        let (first, second) = if behind < ahead { (backwards, forwards) } else { (forwards, backwards) };
        let start = self.instance.starts[place.robot].cell;
        let mut way = vec![start];
        self.go(&mut way, cell(place.at))?;
        self.stretch(&mut way, &first)?;
        if !first.is_empty() && !second.is_empty() {
            self.back(&mut way, &first, cell(place.at))?;
        }
        self.stretch(&mut way, &second)?;
        if self.instance.mode == Mode::CoverAndReturn {
            self.back(&mut way, if second.is_empty() { &first } else { &second }, cell(place.at))?;
            self.go(&mut way, start)?;
        }
        Ok(Route::new(way.into_iter().map(|cell| self.instance.center(cell)).collect()))
    }

    fn stretch(&mut self, way: &mut Vec<Cell>, cells: &[Cell]) -> Result<(), PlanError> {
        cells.iter().try_for_each(|&cell| self.go(way, cell))
    }

    /// Back to where a stretch began.
    fn back(&mut self, way: &mut Vec<Cell>, stretch: &[Cell], home: Cell) -> Result<(), PlanError> {
        if self.backtracking == Backtracking::AlongTheWalk {
            let reversed: Vec<Cell> = stretch.iter().rev().skip(1).copied().collect();
            self.stretch(way, &reversed)?;
        }
        self.go(way, home)
    }

    fn go(&mut self, way: &mut Vec<Cell>, to: Cell) -> Result<(), PlanError> {
        let from = *way.last().expect("a way begins somewhere");
        self.finder.go(self.instance, from, to, way)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(gaps: &[usize]) -> Ring {
        let places = (0..gaps.len()).map(|robot| Place { robot, at: 0, late: 0.0 }).collect();
        Ring { places, gaps: gaps.to_vec() }
    }

    fn slowest(ring: &Ring) -> usize {
        let moves = |&(behind, ahead): &(usize, usize)| (2 * behind + ahead).min(behind + 2 * ahead);
        ring.divide().iter().map(moves).max().unwrap()
    }

    #[test]
    fn the_largest_gap_is_covered_from_both_ends() {
        assert_eq!(slowest(&ring(&[90, 0, 0])), 45);
        assert_eq!(slowest(&ring(&[30, 30, 30])), 30);
        assert_eq!(slowest(&ring(&[60, 30])), 50, "the second first covers ten behind it");
        assert_eq!(slowest(&ring(&[80, 10])), 50);
    }
}
