//! Checkers: what must never happen, and what must happen in the end. They read the world's truth and what the
//! coordinator says in public, never what it believes.
//!
//! | Id | Holds when |
//! |---|---|
//! | S1 | no robot ever touches another |
//! | S2 | no robot ever touches a wall or an obstacle, nor drives into a person |
//! | S5 | what is claimed COVERED was truly swept |
//! | D4 | every cell is in exactly one state at any time |
//! | L1 | what healthy robots can reach at the end is covered |
//! | L8 | the mission ends, and says how |

mod completion;
mod conservation;
mod explicit_end;
mod no_contact;
mod no_false_coverage;
mod no_obstacle_entered;

use crate::world::World;
use coordinator::Publication;
use protocol::{Timestamp, v1};

/// Something that must not be.
#[derive(Debug, Clone, PartialEq)]
pub struct Violation {
    /// The invariant.
    pub id: &'static str,
    /// When.
    pub at: Timestamp,
    /// What.
    pub text: String,
}

impl std::fmt::Display for Violation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}  {}  {}", self.at, self.id, self.text)
    }
}

/// What a checker may look at.
#[derive(Debug)]
pub(crate) enum Seen<'a> {
    /// The world saw a contact.
    Contact(&'a v1::Contact),
    /// The coordinator said something.
    Publication(&'a Publication),
    /// The run is over, with or without a result.
    End { result: Option<&'a v1::MissionResult>, healthy: &'a [bool] },
}

/// One invariant.
pub(crate) trait Checker {
    /// Looks at one thing; `Some` is what is wrong.
    fn look(&mut self, world: &mut World, seen: &Seen<'_>) -> Option<String>;
}

/// All invariants, with what was found.
pub(crate) struct Checkers {
    checkers: Vec<(&'static str, Box<dyn Checker>)>,
    violations: Vec<Violation>,
}

impl Checkers {
    pub(crate) fn new() -> Self {
        Self {
            checkers: vec![
                ("S1", Box::new(no_contact::NoContact)),
                ("S2", Box::new(no_obstacle_entered::NoObstacleEntered)),
                ("S5", Box::<no_false_coverage::NoFalseCoverage>::default()),
                ("D4", Box::<conservation::Conservation>::default()),
                ("L1", Box::<completion::Completion>::default()),
                ("L8", Box::new(explicit_end::ExplicitEnd)),
            ],
            violations: Vec::new(),
        }
    }

    pub(crate) fn look(&mut self, world: &mut World, seen: &Seen<'_>) {
        for (id, checker) in &mut self.checkers {
            if let Some(text) = checker.look(world, seen) {
                self.violations.push(Violation { id, at: world.now(), text });
            }
        }
    }

    pub(crate) fn into_violations(self) -> Vec<Violation> {
        self.violations
    }
}

/// Calls `each(index, status)` for every cell that a delta is about.
fn for_each_cell(delta: &v1::CoverageDelta, columns: u32, mut each: impl FnMut(usize, v1::CellStatus)) {
    for run in &delta.runs {
        for column in run.column..run.column + run.length {
            each((run.row * columns + column) as usize, run.status());
        }
    }
}
