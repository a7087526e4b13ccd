//! Shortest drivable ways between cells, in moves; straight on where there is a choice.

use crate::{Instance, PlanError};
use std::collections::VecDeque;
use terrain::{Cell, Direction};

const UNSEEN: u32 = u32::MAX;

/// Finds ways one after another without clearing its tables in between.
#[derive(Debug)]
pub(crate) struct WayFinder {
    /// Round in which a cell was seen, and the direction it was entered by.
    seen: Vec<(u32, u8)>,
    round: u32,
    queue: VecDeque<Cell>,
}

impl WayFinder {
    pub(crate) fn new(instance: &Instance<'_>) -> Self {
        Self { seen: vec![(0, 0); instance.floor.lattice().len()], round: 0, queue: VecDeque::new() }
    }

    /// The cells of a shortest way, both ends included; `None` when there is none.
    pub(crate) fn way(&mut self, instance: &Instance<'_>, from: Cell, to: Cell) -> Option<Vec<Cell>> {
        if from == to {
            return Some(vec![from]);
        }
        let lattice = *instance.floor.lattice();
        self.round += 1;
        self.queue.clear();
        self.queue.push_back(to);
        self.seen[lattice.index(to)?] = (self.round, 4);
        while let Some(cell) = self.queue.pop_front() {
            for direction in Direction::ALL {
                let next = cell.step(direction);
                if !instance.floor.can_move(cell, direction) {
                    continue;
                }
                let index = lattice.index(next)?;
                if self.seen[index].0 == self.round || instance.blocked[index] {
                    continue;
                }
                self.seen[index] = (self.round, direction.opposite() as u8);
                if next == from {
                    return Some(self.trace(instance, from, to));
                }
                self.queue.push_back(next);
            }
        }
        None
    }

    /// Goes on from the last cell of `way` to another one: one move where they touch, else a shortest way.
    pub(crate) fn go(
        &mut self,
        instance: &Instance<'_>,
        from: Cell,
        to: Cell,
        way: &mut Vec<Cell>,
    ) -> Result<(), PlanError> {
        let touching = Direction::between(from, to).is_some_and(|side| instance.floor.can_move(from, side));
        if touching {
            way.push(to);
        } else if from != to {
            let between = self.way(instance, from, to).ok_or(PlanError::Unreachable(to))?;
            way.extend(between.into_iter().skip(1));
        }
        Ok(())
    }

    fn trace(&self, instance: &Instance<'_>, from: Cell, to: Cell) -> Vec<Cell> {
        let lattice = instance.floor.lattice();
        let mut way = vec![from];
        let mut at = from;
        while at != to {
            let (_, towards) = self.seen[lattice.index(at).expect("the way stays on the lattice")];
            at = at.step(Direction::ALL[towards as usize]);
            way.push(at);
        }
        way
    }
}

/// Moves from a start to each cell; `u32::MAX` where there is no way.
pub(crate) fn moves_from(instance: &Instance<'_>, start: Cell) -> Vec<u32> {
    let lattice = instance.floor.lattice();
    let mut moves = vec![UNSEEN; lattice.len()];
    let Some(first) = lattice.index(start) else { return moves };
    moves[first] = 0;
    let mut queue = VecDeque::from([start]);
    while let Some(cell) = queue.pop_front() {
        let so_far = moves[lattice.index(cell).expect("queued cells are on the lattice")];
        for next in instance.floor.neighbours(cell) {
            let index = lattice.index(next).expect("a neighbour is on the lattice");
            if moves[index] == UNSEEN && !instance.blocked[index] {
                moves[index] = so_far + 1;
                queue.push_back(next);
            }
        }
    }
    moves
}
