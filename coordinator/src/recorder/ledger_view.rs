//! The ledger as the deltas tell it, drawn: who covered what, and what is left.

use super::grid_picture::{GridFrame, coloured, occupancy, occupancy_schema};
use super::log_file::{LogFile, RecordError, TopicId};
use super::palette::{self, Rgba};
use foxglove::messages::Grid;
use protocol::{Timestamp, v1};
use std::collections::BTreeMap;
use std::io::Write;
use std::time::Duration;
use terrain::Point;

const GRID_INTERVAL: Duration = Duration::from_secs(1);
const OCCUPANCY_INTERVAL: Duration = Duration::from_secs(5);
/// Pictures of large floors are drawn less often, so that they take no more bytes a second than this many cells.
const CELLS_PER_SECOND: u64 = 100_000;
/// The most cells that are drawn at all.
const CELLS_MAX: u64 = 4 << 20;

/// The ledger, drawn.
pub(super) struct LedgerView {
    grid_topic: TopicId,
    occupancy_topic: TopicId,
    frame: Option<GridFrame>,
    cells: Vec<CellView>,
    numbers: BTreeMap<String, u16>,
    grid_changed: bool,
    occupancy_changed: bool,
    grid_due: Timestamp,
    occupancy_due: Timestamp,
}

#[derive(Clone, Copy, Default)]
struct CellView {
    status: v1::CellStatus,
    robot: u16,
}

impl LedgerView {
    pub(super) fn new<W: Write>(file: &mut LogFile<W>, robots: &[String]) -> Result<Self, RecordError> {
        Ok(Self {
            grid_topic: file.add_drawn_topic::<Grid>("/coverage/grid")?,
            occupancy_topic: file.add_topic("/coverage/occupancy", &occupancy_schema())?,
            frame: None,
            cells: Vec::new(),
            numbers: robots.iter().cloned().zip(0..).collect(),
            grid_changed: false,
            occupancy_changed: false,
            grid_due: Timestamp::ZERO,
            occupancy_due: Timestamp::ZERO,
        })
    }

    /// The number by which a robot gets its colour.
    pub(super) fn number_of(&mut self, robot: &str) -> u16 {
        if let Some(&number) = self.numbers.get(robot) {
            return number;
        }
        let number = self.numbers.len() as u16;
        self.numbers.insert(robot.to_owned(), number);
        number
    }

    /// Takes in what changed in the ledger.
    pub(super) fn take(&mut self, delta: &v1::CoverageDelta) {
        if let Some(lattice) = &delta.lattice {
            self.lay_out(lattice);
        }
        let Some(frame) = self.frame else { return };
        for run in &delta.runs {
            let robot = if run.serial_number.is_empty() { 0 } else { self.number_of(&run.serial_number) };
            let start = u64::from(run.row) * u64::from(frame.columns) + u64::from(run.column);
            let fits = u64::from(run.column) + u64::from(run.length) <= u64::from(frame.columns)
                && run.row < frame.rows;
            assert!(fits, "the coordinator told of cells outside its lattice: {run:?}");
            let cells = &mut self.cells[start as usize..][..run.length as usize];
            cells.fill(CellView { status: run.status(), robot });
        }
        self.grid_changed = true;
        self.occupancy_changed = true;
    }

    fn lay_out(&mut self, lattice: &v1::LatticeGeometry) {
        let cells = u64::from(lattice.columns) * u64::from(lattice.rows);
        self.frame = (cells <= CELLS_MAX).then_some(GridFrame {
            origin: Point::new(lattice.origin_x_m, lattice.origin_y_m),
            square_m: lattice.cell_m,
            columns: lattice.columns,
            rows: lattice.rows,
        });
        self.cells = vec![CellView::default(); if self.frame.is_some() { cells as usize } else { 0 }];
    }

    /// Draws what changed, if it is time.
    pub(super) fn draw_if_due<W: Write>(&mut self, file: &mut LogFile<W>) -> Result<(), RecordError> {
        let at_least = Duration::from_secs(self.cells.len() as u64 / CELLS_PER_SECOND);
        if self.grid_changed && file.now() >= self.grid_due {
            self.grid_due = file.now() + GRID_INTERVAL.max(at_least);
            self.draw_grid(file)?;
        }
        if self.occupancy_changed && file.now() >= self.occupancy_due {
            self.occupancy_due = file.now() + OCCUPANCY_INTERVAL.max(at_least);
            self.draw_occupancy(file)?;
        }
        Ok(())
    }

    /// Draws the end, unless it is drawn already.
    pub(super) fn draw_last<W: Write>(&mut self, file: &mut LogFile<W>) -> Result<(), RecordError> {
        self.grid_due = Timestamp::ZERO;
        self.occupancy_due = Timestamp::ZERO;
        self.draw_if_due(file)
    }

    fn draw_grid<W: Write>(&mut self, file: &mut LogFile<W>) -> Result<(), RecordError> {
        self.grid_changed = false;
        let Some(frame) = self.frame else { return Ok(()) };
        let colours: Vec<Rgba> = (0..self.numbers.len()).map(palette::robot).collect();
        let squares = self.cells.iter().map(|cell| colour_of(*cell, &colours));
        file.write(self.grid_topic, &coloured(file.stamp(), frame, squares))
    }

    fn draw_occupancy<W: Write>(&mut self, file: &mut LogFile<W>) -> Result<(), RecordError> {
        self.occupancy_changed = false;
        let Some(frame) = self.frame else { return Ok(()) };
        let squares = self.cells.iter().map(|cell| occupancy_of(cell.status));
        file.write_bytes(self.occupancy_topic, &occupancy(file.stamp(), frame, squares))
    }
}

fn colour_of(cell: CellView, colours: &[Rgba]) -> Rgba {
    use v1::CellStatus::{
        CellAssigned, CellCovered, CellExcluded, CellLost, CellUnassigned, CellUnreachable,
    };
    match cell.status {
        CellCovered => colours[usize::from(cell.robot)],
        CellAssigned => palette::pale(colours[usize::from(cell.robot)]),
        CellUnassigned => palette::NOT_YET,
        CellUnreachable => palette::UNREACHABLE,
        CellLost => palette::LOST,
        CellExcluded | v1::CellStatus::Unspecified => palette::NOTHING,
    }
}

fn occupancy_of(status: v1::CellStatus) -> i8 {
    match status {
        v1::CellStatus::CellCovered => 100,
        v1::CellStatus::CellUnassigned | v1::CellStatus::CellAssigned => 0,
        _ => -1,
    }
}
