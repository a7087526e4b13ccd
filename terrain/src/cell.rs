//! A square of the coverage lattice, and the four ways out of it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A square of the lattice: `x` columns to the right, `y` rows up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
pub struct Cell {
    /// Column, from the left.
    pub x: i32,
    /// Row, from the bottom.
    pub y: i32,
}

impl Cell {
    /// The cell in column `x` and row `y`.
    pub const fn new(x: i32, y: i32) -> Self {
        Self { x, y }
    }

    /// The cell next door.
    pub const fn step(self, direction: Direction) -> Self {
        let (dx, dy) = direction.offset();
        Self { x: self.x + dx, y: self.y + dy }
    }

    /// Number of moves between two cells on an empty lattice.
    pub const fn manhattan(self, other: Self) -> u32 {
        self.x.abs_diff(other.x) + self.y.abs_diff(other.y)
    }
}

impl std::fmt::Display for Cell {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "({}, {})", self.x, self.y)
    }
}

/// One of the four ways out of a cell, anticlockwise from x.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Direction {
    /// Along +x.
    East = 0,
    /// Along +y.
    North = 1,
    /// Along -x.
    West = 2,
    /// Along -y.
    South = 3,
}

impl Direction {
    /// All four, anticlockwise.
    pub const ALL: [Self; 4] = [Self::East, Self::North, Self::West, Self::South];

    /// Column and row difference of one step.
    pub const fn offset(self) -> (i32, i32) {
        match self {
            Self::East => (1, 0),
            Self::North => (0, 1),
            Self::West => (-1, 0),
            Self::South => (0, -1),
        }
    }

    /// The way back.
    pub const fn opposite(self) -> Self {
        match self {
            Self::East => Self::West,
            Self::North => Self::South,
            Self::West => Self::East,
            Self::South => Self::North,
        }
    }

    /// The direction from `from` to a cell next door, if it is one.
    pub fn between(from: Cell, to: Cell) -> Option<Self> {
        Self::ALL.into_iter().find(|&direction| from.step(direction) == to)
    }
}
