//! The ledger: what is known of every cell of the floor, and by whose evidence.
//!
//! A cell is COVERED only when every sample that can be swept there lies under the footprint of a tool, taken
//! from reported poses with the pose's error bound subtracted. Nothing is ever inferred from a plan. Each cell
//! is in exactly one state at any time.

use protocol::{
    Timestamp,
    v1::{self, CellStatus, UnreachableReason},
};
use std::sync::Arc;
use terrain::{CellClass, Floor, Point, Segment, SweptRaster};

/// Number of a robot in the fleet's roster.
pub(crate) type RobotIndex = usize;

/// What is known of one cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Status {
    /// To be covered, by nobody yet.
    Unassigned,
    /// On the route of a robot.
    Assigned(RobotIndex),
    /// Swept whole; the robot that completed it.
    Covered(RobotIndex),
    /// Cannot be swept, and why.
    Unreachable(UnreachableReason),
    /// No free ground, or out of any tool's reach.
    Excluded,
    /// Driven over while the robot did not know where it was: to be covered again.
    Lost,
}

/// The ledger of one mission. Everything is row-major by cell of the floor's lattice.
#[derive(Debug)]
pub(crate) struct Ledger {
    floor: Arc<Floor>,
    required: Vec<u64>,
    /// Samples that no robot gets to.
    out_of_reach: Vec<u64>,
    out_of_reach_samples: u64,
    raster: SweptRaster,
    status: Vec<Status>,
    counts: [u32; 6],
    covered_samples: u64,
    required_samples: u64,
    untouchable_m2: f64,
    swept_twice_m2: f64,
    swept_m2: f64,
    dirty: Vec<u32>,
    is_dirty: Vec<bool>,
    delta_sequence: u64,
}

impl Ledger {
    /// A ledger in which everything that can be covered is open. `required` are the samples of each cell that
    /// the fleet's tools can sweep.
    pub(crate) fn new(floor: Arc<Floor>, required: Vec<u64>) -> Self {
        let lattice = *floor.lattice();
        let status: Vec<Status> = (0..lattice.len())
            .map(|index| match (floor.class(index), required[index]) {
                (CellClass::Obstacle | CellClass::TooNarrow, _) => Status::Excluded,
                (CellClass::Coverable, 0) => Status::Unreachable(UnreachableReason::TooNarrow),
                (CellClass::Coverable, _) => Status::Unassigned,
            })
            .collect();
        let mut counts = [0; 6];
        for &entry in &status {
            counts[slot(entry)] += 1;
        }
        Self {
            raster: SweptRaster::new(lattice),
            required_samples: required.iter().map(|samples| u64::from(samples.count_ones())).sum(),
            untouchable_m2: floor.untouchable_m2(),
            covered_samples: 0,
            swept_twice_m2: 0.0,
            swept_m2: 0.0,
            dirty: (0..lattice.len() as u32).collect(),
            is_dirty: vec![true; lattice.len()],
            delta_sequence: 0,
            out_of_reach: vec![0; lattice.len()],
            out_of_reach_samples: 0,
            floor,
            required,
            status,
            counts,
        }
    }

    /// Says which samples of each cell no robot gets to. A cell of which nothing else is missing is UNREACHABLE from now on;
    /// one that was so until now, and is within reach, is open again.
    pub(crate) fn set_out_of_reach(&mut self, samples: Vec<u64>) {
        self.out_of_reach = samples;
        let beyond = (0..self.status.len()).map(|index| self.unswept(index) & self.out_of_reach[index]);
        self.out_of_reach_samples = beyond.map(|samples| u64::from(samples.count_ones())).sum();
        for index in 0..self.status.len() {
            match self.status[index] {
                Status::Unreachable(UnreachableReason::TooNarrow) if self.is_open(index) => {
                    self.set(index, Status::Unassigned);
                }
                _ => self.leave_out_of_reach(index),
            }
        }
    }

    /// An open cell of which only samples are missing that no robot gets to is UNREACHABLE.
    fn leave_out_of_reach(&mut self, index: usize) {
        let is_open = matches!(self.status[index], Status::Unassigned | Status::Assigned(_) | Status::Lost);
        if is_open && self.missing(index) == 0 && self.unswept(index) != 0 {
            self.set(index, Status::Unreachable(UnreachableReason::TooNarrow));
        }
    }

    /// Whether a cell is UNREACHABLE because no robot gets to what is missing of it.
    pub(crate) fn is_out_of_reach(&self, index: usize) -> bool {
        self.status[index] == Status::Unreachable(UnreachableReason::TooNarrow)
            && self.missing(index) == 0
            && self.unswept(index) != 0
    }

    /// What is known of the cell with this number.
    pub(crate) fn status(&self, index: usize) -> Status {
        self.status[index]
    }

    /// Whether a cell still has samples to be swept (whether or not anybody can get there).
    pub(crate) fn is_open(&self, index: usize) -> bool {
        self.missing(index) != 0
    }

    /// The samples of a cell that a robot gets to, and that are not swept.
    pub(crate) fn missing(&self, index: usize) -> u64 {
        self.unswept(index) & !self.out_of_reach[index]
    }

    /// The samples of a cell that a tool in the right place would sweep, and that are not swept.
    pub(crate) fn unswept(&self, index: usize) -> u64 {
        self.required[index] & !self.raster.samples(index)
    }

    /// Row-major: the samples of each cell that are swept.
    pub(crate) fn swept(&self) -> Vec<u64> {
        (0..self.status.len()).map(|index| self.raster.samples(index)).collect()
    }

    /// Takes in one reported segment: sweeps a disc of `radius_m` for `robot`, and returns the number of cells
    /// that became COVERED by it.
    pub(crate) fn sweep(&mut self, robot: RobotIndex, segment: Segment, radius_m: f64) -> u32 {
        let mut touched: Vec<usize> = Vec::new();
        let before = self.covered_samples;
        self.raster.sweep(segment, radius_m, |index| touched.push(index));
        let mut completed = 0;
        for index in touched {
            let whole = self.unswept(index) == 0 && self.required[index] != 0;
            if !whole {
                self.leave_out_of_reach(index);
            } else if !matches!(self.status[index], Status::Covered(_)) {
                self.covered_samples += u64::from(self.required[index].count_ones());
                self.set(index, Status::Covered(robot));
                completed += 1;
            }
        }
        let area_m2 = segment.length() * 2.0 * radius_m;
        self.swept_m2 += area_m2;
        let gained_m2 = SweptRaster::area_m2(self.floor.lattice(), self.covered_samples - before);
        self.swept_twice_m2 += (area_m2 - gained_m2).max(0.0);
        completed
    }

    /// A segment was driven with the tool on by a robot that did not know where it was: what is not yet covered
    /// near it is LOST.
    pub(crate) fn lose(&mut self, segment: Segment, radius_m: f64) {
        let low = Point::from(segment.from.coords.inf(&segment.to.coords).add_scalar(-radius_m));
        let high = Point::from(segment.from.coords.sup(&segment.to.coords).add_scalar(radius_m));
        let lattice = *self.floor.lattice();
        for cell in lattice.cells_in_box(low, high) {
            let Some(index) = lattice.index(cell) else { continue };
            let near = segment.distance_to_point(lattice.center(cell)) <= radius_m;
            if near && matches!(self.status[index], Status::Unassigned | Status::Assigned(_)) {
                self.set(index, Status::Lost);
            }
        }
    }

    /// Whether an open cell is nobody's to cover.
    pub(crate) fn is_unclaimed(&self, index: usize) -> bool {
        matches!(self.status[index], Status::Unassigned | Status::Lost)
    }

    /// Gives an open cell to a robot.
    pub(crate) fn assign(&mut self, index: usize, robot: RobotIndex) {
        if self.is_open(index) {
            self.set(index, Status::Assigned(robot));
        }
    }

    /// Takes all cells from a robot that it has not covered; returns how many.
    pub(crate) fn unassign(&mut self, robot: RobotIndex) -> u32 {
        let mine: Vec<usize> =
            (0..self.status.len()).filter(|&index| self.status[index] == Status::Assigned(robot)).collect();
        for &index in &mine {
            self.set(index, Status::Unassigned);
        }
        mine.len() as u32
    }

    /// Says that an open cell cannot be reached, and why.
    pub(crate) fn give_up(&mut self, index: usize, reason: UnreachableReason) {
        if self.is_open(index) {
            self.set(index, Status::Unreachable(reason));
        }
    }

    /// Numbers of all cells with samples still to be swept that were not given up.
    pub(crate) fn open_cells(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.status.len()).filter(|&index| {
            !matches!(self.status[index], Status::Unreachable(_) | Status::Covered(_)) && self.is_open(index)
        })
    }

    fn set(&mut self, index: usize, status: Status) {
        let old = self.status[index];
        if old == status {
            return;
        }
        assert!(!matches!(old, Status::Excluded), "an excluded cell never changes");
        self.counts[slot(old)] -= 1;
        self.counts[slot(status)] += 1;
        self.status[index] = status;
        if !self.is_dirty[index] {
            self.is_dirty[index] = true;
            self.dirty.push(index as u32);
        }
    }

    /// What changed since the last call, as runs of cells; `None` when nothing did. The first call states all.
    pub(crate) fn take_delta(&mut self, now: Timestamp, names: &[&str]) -> Option<v1::CoverageDelta> {
        if self.dirty.is_empty() {
            return None;
        }
        let mut dirty = std::mem::take(&mut self.dirty);
        dirty.sort_unstable();
        let lattice = *self.floor.lattice();
        let mut runs: Vec<v1::CellRun> = Vec::new();
        let mut last: Option<(u32, Status)> = None;
        for index in dirty {
            self.is_dirty[index as usize] = false;
            let status = self.status[index as usize];
            let continues =
                last == index.checked_sub(1).map(|before| (before, status)) && index % lattice.columns != 0;
            last = Some((index, status));
            match runs.last_mut() {
                Some(run) if continues => run.length += 1,
                _ => runs.push(cell_run(index / lattice.columns, index % lattice.columns, status, names)),
            }
        }
        self.delta_sequence += 1;
        Some(v1::CoverageDelta {
            sequence: self.delta_sequence,
            timestamp_ns: now.as_nanos(),
            runs,
            lattice: (self.delta_sequence == 1).then_some(v1::LatticeGeometry {
                origin_x_m: lattice.origin.x,
                origin_y_m: lattice.origin.y,
                cell_m: lattice.cell_m,
                columns: lattice.columns,
                rows: lattice.rows,
            }),
        })
    }

    /// How far it has come.
    pub(crate) fn progress(&self) -> v1::CoverageProgress {
        let area = |samples| SweptRaster::area_m2(self.floor.lattice(), samples);
        let share = if self.required_samples == 0 {
            1.0
        } else {
            self.covered_samples as f64 / self.required_samples as f64
        };
        v1::CoverageProgress {
            covered_percent: 100.0 * share,
            covered_m2: area(self.covered_samples),
            coverable_m2: area(self.required_samples),
            overlap_ratio: if self.swept_m2 > 0.0 { self.swept_twice_m2 / self.swept_m2 } else { 0.0 },
            remaining_s: 0.0,
            cells_unassigned: self.counts[0],
            cells_assigned: self.counts[1],
            cells_covered: self.counts[2],
            cells_unreachable: self.counts[3],
            cells_excluded: self.counts[4],
            cells_lost: self.counts[5],
            cells_total: self.status.len() as u32,
            untouchable_m2: self.untouchable_m2,
            out_of_reach_m2: area(self.out_of_reach_samples),
        }
    }

    /// Cells that were given up, by reason.
    pub(crate) fn given_up(&self) -> Vec<(usize, UnreachableReason)> {
        (0..self.status.len())
            .filter_map(|index| match self.status[index] {
                Status::Unreachable(reason) => Some((index, reason)),
                _ => None,
            })
            .collect()
    }
}

const fn slot(status: Status) -> usize {
    match status {
        Status::Unassigned => 0,
        Status::Assigned(_) => 1,
        Status::Covered(_) => 2,
        Status::Unreachable(_) => 3,
        Status::Excluded => 4,
        Status::Lost => 5,
    }
}

fn cell_run(row: u32, column: u32, status: Status, names: &[&str]) -> v1::CellRun {
    let name = |robot: RobotIndex| names.get(robot).map_or_else(String::new, |&name| name.to_owned());
    let (wire, reason, serial_number) = match status {
        Status::Unassigned => (CellStatus::CellUnassigned, UnreachableReason::Unspecified, String::new()),
        Status::Assigned(robot) => (CellStatus::CellAssigned, UnreachableReason::Unspecified, name(robot)),
        Status::Covered(robot) => (CellStatus::CellCovered, UnreachableReason::Unspecified, name(robot)),
        Status::Unreachable(reason) => (CellStatus::CellUnreachable, reason, String::new()),
        Status::Excluded => (CellStatus::CellExcluded, UnreachableReason::Unspecified, String::new()),
        Status::Lost => (CellStatus::CellLost, UnreachableReason::Unspecified, String::new()),
    };
    v1::CellRun { row, column, length: 1, status: wire.into(), reason: reason.into(), serial_number }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrain::{Cell, GridMap};

    fn ledger() -> Ledger {
        let map = GridMap::from_drawing(
            "
            .....
            ..#..
            .....",
            0.5,
        )
        .unwrap();
        let floor = Arc::new(Floor::new(&map, 0.5, 0.177, 0.71).unwrap());
        let required = (0..15).map(|index| floor.required(index)).collect();
        Ledger::new(floor, required)
    }

    fn at(x: f64, y: f64) -> Point {
        Point::new(x, y)
    }

    fn all(progress: &v1::CoverageProgress) -> u32 {
        progress.cells_unassigned
            + progress.cells_assigned
            + progress.cells_covered
            + progress.cells_unreachable
            + progress.cells_excluded
            + progress.cells_lost
    }

    #[test]
    fn a_cell_is_covered_when_all_of_it_is_swept_and_not_before() {
        let mut ledger = ledger();
        assert_eq!(ledger.sweep(0, Segment::new(at(0.0, 0.25), at(0.10, 0.25)), 0.355), 0);
        assert_eq!(ledger.status(0), Status::Unassigned);
        assert_eq!(ledger.sweep(0, Segment::new(at(0.10, 0.25), at(0.27, 0.25)), 0.355), 1);
        assert_eq!(ledger.status(0), Status::Covered(0));
    }

    #[test]
    fn every_cell_is_in_exactly_one_state() {
        let mut ledger = ledger();
        for index in 0..10 {
            ledger.assign(index, index % 2);
        }
        ledger.sweep(1, Segment::new(at(0.25, 0.25), at(2.25, 0.25)), 0.355);
        ledger.lose(Segment::new(at(0.25, 0.75), at(0.75, 0.75)), 0.355);
        ledger.give_up(13, UnreachableReason::Obstacle);
        let progress = ledger.progress();
        assert_eq!(all(&progress), progress.cells_total);
        assert_eq!(progress.cells_covered, 5);
        assert_eq!(progress.cells_excluded, 1);
        assert_eq!(progress.cells_unreachable, 1);
        assert!(progress.cells_lost >= 2);
    }

    #[test]
    fn what_was_covered_stays_covered() {
        let mut ledger = ledger();
        ledger.sweep(1, Segment::new(at(0.25, 0.25), at(2.25, 0.25)), 0.355);
        ledger.assign(0, 0);
        ledger.give_up(1, UnreachableReason::Obstacle);
        ledger.lose(Segment::new(at(0.25, 0.25), at(2.25, 0.25)), 0.1);
        assert!((0..5).all(|index| ledger.status(index) == Status::Covered(1)));
    }

    #[test]
    fn the_first_delta_states_all_cells_and_the_next_only_changes() {
        let mut ledger = ledger();
        let first = ledger.take_delta(Timestamp::ZERO, &["r1", "r2"]).unwrap();
        assert_eq!(first.runs.iter().map(|run| run.length).sum::<u32>(), 15);
        assert!(first.lattice.is_some());
        assert_eq!(ledger.take_delta(Timestamp::ZERO, &["r1", "r2"]), None);
        ledger.assign(3, 1);
        ledger.assign(4, 1);
        let next = ledger.take_delta(Timestamp::ZERO, &["r1", "r2"]).unwrap();
        assert_eq!(next.sequence, 2);
        assert_eq!(next.runs.len(), 1);
        assert_eq!((next.runs[0].column, next.runs[0].length), (3, 2));
        assert_eq!(next.runs[0].serial_number, "r2");
    }

    #[test]
    fn what_nobody_gets_to_is_left_out_and_comes_back() {
        let mut ledger = ledger();
        let mut beyond = vec![0; 15];
        (beyond[10], beyond[11]) = (u64::MAX, 0xff << 56);
        let missing = ledger.missing(11);
        ledger.set_out_of_reach(beyond);
        assert!(ledger.is_out_of_reach(10) && !ledger.open_cells().any(|open| open == 10));
        assert!(ledger.status(11) == Status::Unassigned && ledger.missing(11) == missing & !(0xff << 56));
        let area_m2 = ledger.progress().out_of_reach_m2;
        assert!((area_m2 - 72.0 / 64.0 * 0.25).abs() < 1e-9, "{area_m2}");
        ledger.set_out_of_reach(vec![0; 15]);
        assert!((ledger.status(10), ledger.missing(11)) == (Status::Unassigned, missing));
        assert_eq!(all(&ledger.progress()), 15);
    }

    #[test]
    fn a_cell_swept_as_far_as_anybody_gets_is_not_covered_but_done() {
        let mut ledger = ledger();
        let mut beyond = vec![0; 15];
        beyond[0] = 0xff << 56;
        ledger.set_out_of_reach(beyond);
        // A tool that is moved by a little less than its rim.
        ledger.sweep(0, Segment::new(at(0.0, 0.18), at(0.5, 0.18)), 0.28);
        assert_eq!(ledger.unswept(0) & !(0xff << 56), 0);
        assert!(ledger.is_out_of_reach(0), "{:?}", ledger.status(0));
        ledger.sweep(0, Segment::new(at(0.0, 0.25), at(0.5, 0.25)), 0.355);
        assert_eq!(ledger.status(0), Status::Covered(0));
    }

    #[test]
    fn a_cell_driven_over_without_a_pose_is_lost_and_open() {
        let mut ledger = ledger();
        let cell = ledger.floor.lattice().index(Cell::new(1, 0)).unwrap();
        ledger.assign(cell, 0);
        ledger.lose(Segment::new(at(0.75, 0.25), at(0.8, 0.25)), 0.3);
        assert_eq!(ledger.status(cell), Status::Lost);
        assert!(ledger.open_cells().any(|open| open == cell));
    }
}
