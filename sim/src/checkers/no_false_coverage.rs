//! S5: of every cell that is claimed COVERED, at least 99 % of what can be swept was truly under a tool before.

use super::{Checker, Seen, for_each_cell};
use crate::world::World;
use coordinator::Publication;
use protocol::v1::CellStatus;
use terrain::SweptRaster;

/// Share of a cell that may be missing, for rounding.
const MISSING_MAX: f64 = 0.01;

#[derive(Default)]
pub(super) struct NoFalseCoverage {
    checked: Vec<bool>,
}

impl Checker for NoFalseCoverage {
    fn look(&mut self, world: &mut World, seen: &Seen<'_>) -> Option<String> {
        let Seen::Publication(Publication::Coverage(delta)) = seen else { return None };
        let floor = world.scenario.floor.clone();
        let lattice = *floor.lattice();
        self.checked.resize(lattice.len(), false);
        let mut false_samples = 0;
        let mut first = None;
        let swept = world.swept();
        for_each_cell(delta, lattice.columns, |index, status| {
            let news = status == CellStatus::CellCovered && !self.checked[index];
            self.checked[index] = status == CellStatus::CellCovered;
            let missing = (floor.required(index) & !swept.samples(index)).count_ones();
            if news && f64::from(missing) > MISSING_MAX * f64::from(floor.required(index).count_ones()) {
                false_samples += u64::from(missing);
                first.get_or_insert(lattice.cell(index));
            }
        });
        let area_m2 = SweptRaster::area_m2(&lattice, false_samples);
        first.map(|cell| {
            format!("{area_m2:.4} m² are claimed COVERED and were not swept, the first in cell {cell}")
        })
    }
}
