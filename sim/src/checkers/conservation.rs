//! D4: every cell is in exactly one state; the counts add up, and so do the changes.

use super::{Checker, Seen, for_each_cell};
use crate::world::World;
use coordinator::Publication;
use protocol::v1::{CellStatus, CoverageProgress};

#[derive(Default)]
pub(super) struct Conservation {
    sequence: u64,
    cells: Vec<Option<CellStatus>>,
}

impl Checker for Conservation {
    fn look(&mut self, world: &mut World, seen: &Seen<'_>) -> Option<String> {
        match seen {
            Seen::Publication(Publication::Coverage(delta)) => {
                let lattice = world.scenario.floor.lattice();
                self.cells.resize(lattice.len(), None);
                for_each_cell(delta, lattice.columns, |index, status| self.cells[index] = Some(status));
                self.sequence += 1;
                let gap = delta.sequence != self.sequence;
                let unstated = self.cells.contains(&None);
                (gap || unstated).then(|| {
                    format!(
                        "delta {} comes where {} is due, or states not all cells",
                        delta.sequence, self.sequence
                    )
                })
            }
            Seen::Publication(Publication::Status(status)) => status.progress.as_ref().and_then(adds_up),
            Seen::Publication(Publication::Result(result)) => self.agrees(result.progress.as_ref()?),
            _ => None,
        }
    }
}

impl Conservation {
    /// What the last deltas left, against the counts of the result.
    fn agrees(&self, progress: &CoverageProgress) -> Option<String> {
        let counted = |status| self.cells.iter().filter(|&&cell| cell == Some(status)).count() as u32;
        let covered = counted(CellStatus::CellCovered);
        let differs = !self.cells.is_empty() && covered != progress.cells_covered;
        let text = || {
            format!("the deltas leave {covered} cells COVERED, the result says {}", progress.cells_covered)
        };
        adds_up(progress).or_else(|| differs.then(text))
    }
}

fn adds_up(progress: &CoverageProgress) -> Option<String> {
    let sum = progress.cells_unassigned
        + progress.cells_assigned
        + progress.cells_covered
        + progress.cells_unreachable
        + progress.cells_excluded
        + progress.cells_lost;
    (sum != progress.cells_total).then(|| format!("{sum} cells are in a state, of {}", progress.cells_total))
}
