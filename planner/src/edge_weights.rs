//! Ground that takes longer: factors on the time of moves.

use crate::InstanceError;
use terrain::{Cell, Direction, Floor, Lattice};

/// Factors on the time of a move between neighbouring cells, the same in both directions. Row-major by cell; entries
/// of moves that nobody can make are not looked at.
#[derive(Debug, Clone, PartialEq)]
pub struct EdgeWeights {
    /// Per cell: factor on the move to its east neighbour and back.
    pub right: Vec<f64>,
    /// Per cell: factor on the move to its north neighbour and back.
    pub up: Vec<f64>,
}

impl EdgeWeights {
    /// Factor on a move; 1 for what is no move of the lattice.
    pub fn factor(&self, lattice: &Lattice, from: Cell, to: Cell) -> f64 {
        let of = |list: &[f64], cell: Cell| lattice.index(cell).map_or(1.0, |index| list[index]);
        match Direction::between(from, to) {
            Some(Direction::East) => of(&self.right, from),
            Some(Direction::West) => of(&self.right, to),
            Some(Direction::North) => of(&self.up, from),
            Some(Direction::South) => of(&self.up, to),
            None => 1.0,
        }
    }

    /// Refuses lists of the wrong length and factors on possible moves that are no positive numbers.
    pub(crate) fn check(&self, floor: &Floor) -> Result<(), InstanceError> {
        let expected = floor.lattice().len();
        for (list, found) in [("weights.right", self.right.len()), ("weights.up", self.up.len())] {
            if found != expected {
                return Err(InstanceError::WrongLength { list, found, expected });
            }
        }
        for cell in floor.lattice().cells() {
            for next in floor.neighbours(cell) {
                let value = self.factor(floor.lattice(), cell, next);
                if !(value.is_finite() && value > 0.0) {
                    return Err(InstanceError::Weight { from: cell, to: next, value });
                }
            }
        }
        Ok(())
    }
}
