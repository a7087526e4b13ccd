//! Repair: keep what the robots are driving, deal out what has no driver.
//!
//! A plan from scratch on a half-covered floor is poor: what is left of a walk around a tree is a strip, and the
//! way back along it covers nothing. The routes under way are better: each robot keeps its own, and only the
//! pieces that nobody drives (of a lost robot, behind a cleared blockage) are given away.
//!
//! 1. Each robot's sequence is what it still had to visit, in its order.
//! 2. Small pieces without a driver are put where they cost the least detour.
//! 3. Large ones are cut and appended: a bound on the time of the last robot is bisected; within a bound each robot,
//!    the one with the most time left first, takes as much as it can from the nearest end of a piece.
//!
//! This is our own, in the spirit of the greedy division of MSTC* (Tang, Sun, Zhang 2021), with pieces in place of
//! one loop. Cost O(k n) for the ways, O(k p log n) for each bound with p pieces.

use crate::{
    Instance, Plan, PlanError, Route,
    circumnavigation::loops,
    shortest_way::{WayFinder, moves_from},
    spanning_graph::SpanningGraph,
    spanning_trees::turn_minimising,
};
use std::collections::VecDeque;
use terrain::Cell;

/// Pieces of at most so many cells are inserted into routes rather than appended.
const SMALL: usize = 12;
const BISECTIONS: u32 = 20;
/// Ways around things are longer than on an empty lattice.
const DETOUR: f64 = 1.3;

/// Plans by keeping the incumbent routes; nothing when there are none.
///
/// # Errors
///
/// [`PlanError::Unreachable`] when a cell cannot be reached by any robot.
pub(crate) fn repair(instance: &Instance<'_>) -> Result<Option<Plan>, PlanError> {
    if instance.incumbent.len() != instance.starts.len() {
        return Ok(None);
    }
    let mut workshop = Workshop::new(instance);
    let mut pieces = workshop.sort_out()?;
    let (small, large): (Vec<_>, Vec<_>) = pieces.drain(..).partition(|piece| piece.len() <= SMALL);
    for piece in small {
        workshop.insert(&piece)?;
    }
    workshop.append(&large)?;
    workshop.routes().map(Some)
}

struct Workshop<'a> {
    instance: &'a Instance<'a>,
    component: Vec<u32>,
    /// What each robot visits, in order.
    sequences: Vec<Vec<Cell>>,
    finder: WayFinder,
    move_s: f64,
}

impl<'a> Workshop<'a> {
    fn new(instance: &'a Instance<'a>) -> Self {
        Self {
            component: instance.components(),
            sequences: vec![Vec::new(); instance.starts.len()],
            finder: WayFinder::new(instance),
            move_s: instance.floor.lattice().cell_m / instance.motion.speed_m_per_s,
            instance,
        }
    }

    fn component_of(&self, cell: Cell) -> u32 {
        self.instance.floor.lattice().index(cell).map_or(u32::MAX, |index| self.component[index])
    }

    /// Gives each robot what it already drives and can still reach; returns the pieces without a driver.
    fn sort_out(&mut self) -> Result<Vec<Vec<Cell>>, PlanError> {
        let lattice = *self.instance.floor.lattice();
        let mut open = self.instance.visit.clone();
        let mut pieces = Vec::new();
        for robot in 0..self.sequences.len() {
            let home = self.component_of(self.instance.starts[robot].cell);
            for &cell in &self.instance.incumbent[robot] {
                if let Some(index) = lattice.index(cell).filter(|&index| open[index])
                    && self.component[index] == home
                {
                    open[index] = false;
                    self.sequences[robot].push(cell);
                }
            }
        }
        for orphan in &self.instance.orphans {
            let mut piece: Vec<Cell> = Vec::new();
            for &cell in orphan {
                let Some(index) = lattice.index(cell).filter(|&index| open[index]) else { continue };
                let apart = piece.last().is_some_and(|&last| {
                    self.component_of(last) != self.component[index] || last.manhattan(cell) > 6
                });
                if apart {
                    pieces.push(std::mem::take(&mut piece));
                }
                open[index] = false;
                piece.push(cell);
            }
            if !piece.is_empty() {
                pieces.push(piece);
            }
        }
        pieces.extend(self.walks_over(open));
        let lost = pieces.iter().find(|piece| self.team_of(piece[0]).next().is_none());
        match lost {
            Some(piece) => Err(PlanError::Unreachable(piece[0])),
            None => Ok(pieces),
        }
    }

    /// Cells that belong to no route at all, as walks around trees of their own, cut where they jump.
    fn walks_over(&self, visit: Vec<bool>) -> Vec<Vec<Cell>> {
        if !visit.contains(&true) {
            return Vec::new();
        }
        let rest = Instance { visit, ..self.instance.clone() };
        let graph = SpanningGraph::new(&rest);
        let mut pieces = Vec::new();
        for cells in loops(&graph, &turn_minimising(&graph)) {
            let mut piece: Vec<Cell> = Vec::new();
            for cell in cells {
                let jumps = piece.last().is_some_and(|&last| {
                    last.manhattan(cell) > 3 || self.component_of(last) != self.component_of(cell)
                });
                if jumps {
                    pieces.push(std::mem::take(&mut piece));
                }
                piece.push(cell);
            }
            pieces.push(piece);
        }
        pieces
    }

    /// The robots that can get to a cell.
    fn team_of(&self, cell: Cell) -> impl Iterator<Item = usize> + '_ {
        let component = self.component_of(cell);
        (0..self.sequences.len())
            .filter(move |&robot| self.component_of(self.instance.starts[robot].cell) == component)
    }

    /// Puts a small piece where it costs the least, a late end counting, too.
    fn insert(&mut self, piece: &[Cell]) -> Result<(), PlanError> {
        let (first, last) = (piece[0], piece[piece.len() - 1]);
        let mut best: Option<(f64, usize, usize)> = None;
        for robot in self.team_of(first).collect::<Vec<_>>() {
            let busy = 0.1 * self.sequences[robot].len() as f64;
            let mut before = self.instance.starts[robot].cell;
            for at in 0..=self.sequences[robot].len() {
                let after = self.sequences[robot].get(at).copied();
                let detour = after.map_or_else(
                    || f64::from(before.manhattan(first)),
                    |after| {
                        f64::from(before.manhattan(first) + last.manhattan(after))
                            - f64::from(before.manhattan(after))
                    },
                );
                if best.is_none_or(|(least, _, _)| detour + busy < least) {
                    best = Some((detour + busy, robot, at));
                }
                before = after.unwrap_or(before);
            }
        }
        let (_, robot, at) = best.ok_or(PlanError::Unreachable(first))?;
        self.sequences[robot].splice(at..at, piece.iter().copied());
        Ok(())
    }

    /// Cuts large pieces and appends the parts to routes.
    fn append(&mut self, pieces: &[Vec<Cell>]) -> Result<(), PlanError> {
        if pieces.is_empty() {
            return Ok(());
        }
        let finish_s: Vec<f64> = self.finish_times()?;
        let ends: Vec<Cell> = (0..self.sequences.len()).map(|robot| self.end_of(robot)).collect();
        let legs: Vec<Vec<u32>> = ends.iter().map(|&end| moves_from(self.instance, end)).collect();
        let dealer = Dealer { workshop: self, pieces, finish_s: &finish_s, ends: &ends, legs: &legs };
        let mut high_s = dealer.enough_s();
        let mut low_s = finish_s.iter().copied().fold(f64::INFINITY, f64::min);
        let mut best = dealer.deal(high_s).ok_or(PlanError::Unreachable(pieces[0][0]))?;
        for _ in 0..BISECTIONS {
            let middle_s = f64::midpoint(low_s, high_s);
            match dealer.deal(middle_s) {
                Some(parts) => {
                    best = parts;
                    high_s = middle_s;
                }
                None => low_s = middle_s,
            }
        }
        for (robot, parts) in best.into_iter().enumerate() {
            self.sequences[robot].extend(parts);
        }
        Ok(())
    }

    fn end_of(&self, robot: usize) -> Cell {
        self.sequences[robot].last().copied().unwrap_or(self.instance.starts[robot].cell)
    }

    fn finish_times(&mut self) -> Result<Vec<f64>, PlanError> {
        (0..self.sequences.len())
            .map(|robot| {
                let route = self.route(robot)?;
                let start = &self.instance.starts[robot];
                Ok(start.available_in_s + self.instance.path_s(&route.points, start.heading_rad))
            })
            .collect()
    }

    fn routes(mut self) -> Result<Plan, PlanError> {
        let routes = (0..self.sequences.len()).map(|robot| self.route(robot)).collect::<Result<_, _>>()?;
        Ok(Plan { routes })
    }

    /// A robot's sequence with the ways between its cells filled in.
    fn route(&mut self, robot: usize) -> Result<Route, PlanError> {
        let start = self.instance.starts[robot].cell;
        if self.sequences[robot].is_empty() {
            return Ok(Route::default());
        }
        let mut way = vec![start];
        for at in 0..self.sequences[robot].len() {
            let (from, cell) = (*way.last().expect("it begins with the start"), self.sequences[robot][at]);
            self.finder.go(self.instance, from, cell, &mut way)?;
        }
        if self.instance.mode == crate::Mode::CoverAndReturn {
            let from = *way.last().expect("it begins with the start");
            self.finder.go(self.instance, from, start, &mut way)?;
        }
        Ok(Route::new(way.into_iter().map(|cell| self.instance.center(cell)).collect()))
    }
}

/// Deals pieces out within a bound.
struct Dealer<'a> {
    workshop: &'a Workshop<'a>,
    pieces: &'a [Vec<Cell>],
    finish_s: &'a [f64],
    ends: &'a [Cell],
    legs: &'a [Vec<u32>],
}

impl Dealer<'_> {
    /// A bound with which any one robot could take all the pieces it can get to.
    fn enough_s(&self) -> f64 {
        let latest_s = self.finish_s.iter().copied().fold(0.0, f64::max);
        let steps = self.pieces.iter().flat_map(|piece| piece.windows(2));
        let inside_s: f64 = steps.map(|pair| self.step_s(pair[0], pair[1])).sum();
        let lattice = self.workshop.instance.floor.lattice();
        let straight = DETOUR * f64::from(lattice.columns + lattice.rows);
        let reached = self.legs.iter().flatten().filter(|&&moves| moves != u32::MAX);
        let longest = reached.fold(straight, |longest, &moves| longest.max(f64::from(moves)));
        latest_s + inside_s + (self.pieces.len() + 1) as f64 * longest * self.workshop.move_s
    }

    /// What each robot drives in addition; `None` when the bound is too small.
    fn deal(&self, bound_s: f64) -> Option<Vec<Vec<Cell>>> {
        let mut left: Vec<VecDeque<Cell>> =
            self.pieces.iter().map(|piece| piece.iter().copied().collect()).collect();
        let mut dealt = vec![Vec::new(); self.ends.len()];
        let mut order: Vec<usize> = (0..self.ends.len()).collect();
        order.sort_by(|&a, &b| self.finish_s[a].total_cmp(&self.finish_s[b]).then(a.cmp(&b)));
        for robot in order {
            self.fill(robot, bound_s, &mut left, &mut dealt[robot]);
        }
        left.iter().all(VecDeque::is_empty).then_some(dealt)
    }

    fn fill(&self, robot: usize, bound_s: f64, left: &mut [VecDeque<Cell>], part: &mut Vec<Cell>) {
        let mut slack_s = bound_s - self.finish_s[robot];
        while slack_s > 0.0 {
            let Some((leg_s, piece, from_back)) = self.nearest(robot, part.last().copied(), left) else {
                return;
            };
            if leg_s >= slack_s {
                return;
            }
            slack_s -= leg_s;
            let mut before: Option<Cell> = None;
            while let Some(&cell) = if from_back { left[piece].back() } else { left[piece].front() } {
                let step_s = before.map_or(0.0, |last| self.step_s(last, cell));
                if step_s > slack_s {
                    return;
                }
                slack_s -= step_s;
                part.push(cell);
                before = Some(cell);
                if from_back {
                    left[piece].pop_back();
                } else {
                    left[piece].pop_front();
                }
            }
        }
    }

    /// The nearest end of a piece that is left: seconds to it, its number, and whether it is the back.
    fn nearest(&self, robot: usize, at: Option<Cell>, left: &[VecDeque<Cell>]) -> Option<(f64, usize, bool)> {
        let home = self.workshop.component_of(self.ends[robot]);
        left.iter()
            .enumerate()
            .filter(|(_, piece)| piece.front().is_some_and(|&cell| self.workshop.component_of(cell) == home))
            .flat_map(|(number, piece)| [(number, false, piece.front()), (number, true, piece.back())])
            .filter_map(|(number, from_back, cell)| Some((self.leg_s(robot, at, *cell?), number, from_back)))
            .min_by(|a, b| a.0.total_cmp(&b.0))
    }

    fn leg_s(&self, robot: usize, at: Option<Cell>, to: Cell) -> f64 {
        let moves = if let Some(from) = at {
            DETOUR * f64::from(from.manhattan(to))
        } else {
            let lattice = self.workshop.instance.floor.lattice();
            f64::from(self.legs[robot][lattice.index(to).expect("pieces are on the lattice")])
        };
        moves * self.workshop.move_s
    }

    /// From one cell of a piece to the next: turns are reckoned as a share of the moves.
    fn step_s(&self, from: Cell, to: Cell) -> f64 {
        1.5 * f64::from(from.manhattan(to)) * self.workshop.move_s
    }
}

#[cfg(test)]
mod tests {
    use super::repair;
    use crate::{Instance, Mode, Start, test_motion::MOTION};
    use terrain::{Cell, Floor, Lattice, Point};

    /// A piece that goes to and fro between two columns: long for its cells, and for how far they are.
    #[test]
    fn one_robot_takes_a_piece_that_jumps_at_each_step() {
        let lattice = Lattice { origin: Point::origin(), cell_m: 0.5, columns: 6, rows: 8 };
        let floor = Floor::from_cells(lattice, &[true; 48], 0.177, 0.75);
        let mut instance =
            Instance::whole_floor(&floor, vec![Start::at(Cell::new(0, 0))], MOTION, Mode::Cover);
        let piece: Vec<Cell> = (0..16).map(|number| Cell::new(number % 2 * 5, number / 2)).collect();
        instance.visit = lattice.cells().map(|cell| piece.contains(&cell)).collect();
        instance.incumbent = vec![Vec::new()];
        instance.orphans = vec![piece];
        let repaired = repair(&instance);
        assert!(matches!(repaired, Ok(Some(_))), "{repaired:?}");
    }
}
