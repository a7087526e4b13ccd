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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;
    use protocol::v1::{CellRun, CellStatus, CoverageDelta, CoverageProgress, MissionResult, MissionState};

    const HALL: &str = "....\n....\n....";
    /// 8 × 6 cells.
    const CELLS: u32 = 48;

    fn world() -> World {
        testing::world(HALL, &[(0.75, 0.75), (2.75, 0.75)])
    }

    /// Row 1 is covered in these columns, the rest is open.
    fn delta(sequence: u64, covered: std::ops::Range<u32>) -> Publication {
        let run = |column: u32, row: u32, length: u32, status: CellStatus| CellRun {
            row,
            column,
            length,
            status: status.into(),
            ..CellRun::default()
        };
        let mut runs: Vec<CellRun> = (0..6).map(|row| run(0, row, 8, CellStatus::CellUnassigned)).collect();
        runs.push(run(covered.start, 1, covered.len() as u32, CellStatus::CellCovered));
        Publication::Coverage(CoverageDelta { sequence, runs, ..CoverageDelta::default() })
    }

    fn result(state: MissionState, covered: u32) -> MissionResult {
        let progress = CoverageProgress {
            cells_covered: covered,
            cells_unassigned: CELLS - covered,
            cells_total: CELLS,
            ..CoverageProgress::default()
        };
        MissionResult { mission_state: state.into(), progress: Some(progress), ..MissionResult::default() }
    }

    fn broken(world: &mut World, seen: &[Seen<'_>]) -> Vec<&'static str> {
        let mut checkers = Checkers::new();
        for seen in seen {
            checkers.look(world, seen);
        }
        checkers.into_violations().into_iter().map(|violation| violation.id).collect()
    }

    fn contact(other: &str, person_walked_into: bool) -> v1::Contact {
        let (serial_number, other) = ("r1".to_owned(), other.to_owned());
        v1::Contact { serial_number, other, person_walked_into, ..v1::Contact::default() }
    }

    #[test]
    fn contacts_are_told_apart() {
        let cases = [
            ("r2", false, "S1"),
            ("wall", false, "S2"),
            ("blockage-1", false, "S2"),
            ("person-1", false, "S2"),
        ];
        for (other, walked, id) in cases {
            assert_eq!(broken(&mut world(), &[Seen::Contact(&contact(other, walked))]), [id]);
        }
        assert!(broken(&mut world(), &[Seen::Contact(&contact("person-1", true))]).is_empty());
    }

    #[test]
    fn a_cell_claimed_without_a_sweep_is_found_and_a_swept_one_is_not() {
        let claim = delta(1, 0..3);
        assert_eq!(broken(&mut world(), &[Seen::Publication(&claim)]), ["S5"]);
        let mut swept = world();
        testing::drive(&mut swept, 0, 1.0, 0.0, 1.2);
        let (driven, beyond) = (delta(1, 1..3), delta(1, 1..6));
        assert!(broken(&mut swept, &[Seen::Publication(&driven)]).is_empty());
        assert_eq!(broken(&mut swept, &[Seen::Publication(&beyond)]), ["S5"]);
    }

    #[test]
    fn a_lost_delta_and_counts_that_do_not_add_up_are_found() {
        let (first, third) = (delta(1, 0..0), delta(3, 0..0));
        assert_eq!(broken(&mut world(), &[Seen::Publication(&first), Seen::Publication(&third)]), ["D4"]);
        let end = Publication::Result(result(MissionState::Completed, 5));
        assert_eq!(broken(&mut world(), &[Seen::Publication(&first), Seen::Publication(&end)]), ["D4"]);
    }

    #[test]
    fn open_cells_that_a_healthy_robot_can_reach_are_found() {
        let first = delta(1, 0..0);
        let gaps = result(MissionState::CompletedWithGaps, 0);
        let end = |healthy| Seen::End { result: Some(&gaps), healthy };
        let seen = |healthy| broken(&mut world(), &[Seen::Publication(&first), end(healthy)]);
        assert_eq!(seen(&[true, true]), ["L1"]);
        assert!(seen(&[false, false]).is_empty(), "nobody is left to reach anything");
    }

    #[test]
    fn a_mission_without_an_end_is_found() {
        assert_eq!(broken(&mut world(), &[Seen::End { result: None, healthy: &[true, true] }]), ["L8"]);
    }
}
