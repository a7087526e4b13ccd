//! Ground that no battery reaches: found before the start and named, not found out by robots that go there in vain.
//!
//! A cell is out of range when for no robot a charge of `sufficient_charging_level` lasts from the nearest station to
//! the cell and back, by the shortest way on a floor without zones, with the reserve to spare.

use crate::{Coordinator, energy::Energy, ledger::RobotIndex, way};
use protocol::{
    Timestamp,
    v1::{EventLevel, UnreachableReason},
};
use terrain::SweptRaster;

impl Coordinator {
    /// Gives up what is out of range, and says so.
    pub(crate) fn name_what_is_out_of_range(&mut self, now: Timestamp) {
        let robots: Vec<RobotIndex> =
            (0..self.robots.len()).filter(|&robot| self.robots[robot].energy.is_some()).collect();
        let stations = self.station_cells();
        if robots.is_empty() || stations.is_empty() {
            return;
        }
        let moves = way::moves_to(self.roads_as_if_open(), &stations, |_| true);
        self.out_of_range = (0..moves.len())
            .map(|index| {
                let known = self.floor.is_drivable(index) && moves[index] != u32::MAX;
                known && robots.iter().all(|&robot| !self.gets_there_and_back(robot, &moves, index))
            })
            .collect();
        self.give_up_out_of_range(now);
    }

    fn gets_there_and_back(&self, index: RobotIndex, moves: &[u32], cell: usize) -> bool {
        let robot = &self.robots[index];
        let levels = robot.factsheet.as_ref().and_then(|sheet| sheet.battery_charging);
        let (Some(energy), Some(levels)) = (robot.energy, levels) else { return true };
        let lasts = levels.sufficient_charging_level - self.config.timing.reserve_percent;
        let cell_m = self.floor.lattice().cell_m;
        let way_m = (f64::from(moves[cell]) + 1.0) * cell_m;
        2.0 * energy.at_most_percent(way_m, cell_m) <= lasts
            || 2.0 * self.one_way_percent(&energy, moves, cell) <= lasts
    }

    fn one_way_percent(&self, energy: &Energy, moves: &[u32], cell: usize) -> f64 {
        let lattice = self.floor.lattice();
        let way = way::down(self.roads_as_if_open(), moves, lattice.cell(cell)).unwrap_or_default();
        energy.along_percent(&self.points_along(&way), None, false)
    }

    fn give_up_out_of_range(&mut self, now: Timestamp) {
        let cells: Vec<usize> = (0..self.out_of_range.len())
            .filter(|&index| self.out_of_range[index] && self.ledger.is_open(index))
            .collect();
        let Some(&first) = cells.first() else { return };
        let lattice = *self.floor.lattice();
        let samples: u64 = cells.iter().map(|&cell| u64::from(self.ledger.missing(cell).count_ones())).sum();
        let (at, area_m2) = (lattice.center(lattice.cell(first)), SweptRaster::area_m2(&lattice, samples));
        for &cell in &cells {
            self.ledger.give_up(cell, UnreachableReason::OutOfRange);
        }
        let text = format!(
            "{} cells ({area_m2:.1} m²), the first at ({:.1}, {:.1}) m: no charge lasts there and back; put a station \
             nearer, or take larger batteries",
            cells.len(),
            at.x,
            at.y
        );
        self.announcer.event(now, EventLevel::EventWarning, "", "OUT OF RANGE", &text);
    }

    /// Whether a robot may be sent to this cell as far as batteries are concerned.
    pub(crate) fn is_in_range(&self, index: usize) -> bool {
        !self.out_of_range.get(index).copied().unwrap_or(false)
    }
}
