//! What a battery and its chargers allow.

use terrain::{Cell, Point};

/// What a robot can do between two charges, in seconds of operation. All robots of an instance have the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Battery {
    /// Seconds of driving and turning that a full battery gives.
    pub capacity_s: f64,
    /// Seconds that must be left when a charger is reached.
    pub reserve_s: f64,
    /// Seconds at the charger until it is full. Turning at the charger counts as part of it.
    pub charge_s: f64,
    /// How the places are chosen at which work is broken off.
    pub break_off: BreakOff,
}

impl Battery {
    /// A battery without reserve that is charged in no time, as in the paper.
    pub const fn lasting_s(capacity_s: f64) -> Self {
        Self { capacity_s, reserve_s: 0.0, charge_s: 0.0, break_off: BreakOff::Optimal }
    }

    /// Seconds that may pass between two charges.
    pub fn budget_s(&self) -> f64 {
        self.capacity_s - self.reserve_s
    }
}

/// How the places are chosen at which a robot breaks off its work to charge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BreakOff {
    /// Where the whole route takes the least time.
    Optimal,
    /// As late as the way to the charger allows: the rule of the paper.
    Latest,
}

/// A charger. One robot charges at a time; others wait, in the order of their arrival.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// The drivable cell it is in.
    pub cell: Cell,
    /// Where in that cell a robot stands to charge, if not at the centre.
    pub point: Option<Point>,
    /// Seconds that a visit is expected to wait for robots that are not part of the instance.
    pub queue_s: f64,
}

impl Station {
    /// At the centre of a cell, for these robots alone.
    pub const fn at(cell: Cell) -> Self {
        Self { cell, point: None, queue_s: 0.0 }
    }
}
