//! The coordinator's ledger, as its deltas tell it.

use crate::LogError;
use protocol::v1;
use terrain::{Cell, Lattice, Point};

/// The most cells a ledger may have.
const CELLS_MAX: u64 = 16 << 20;

/// What the coordinator claims of one cell.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Claim {
    /// Its state.
    pub status: v1::CellStatus,
    /// Why it cannot be covered, if so.
    pub reason: v1::UnreachableReason,
    /// Number of the robot that covered it or is to cover it: an index into [`Ledger::robots`].
    pub robot: Option<u16>,
}

/// What the coordinator claims of every cell.
#[derive(Debug, Clone, Default)]
pub struct Ledger {
    lattice: Option<Lattice>,
    claims: Vec<Claim>,
    robots: Vec<String>,
    sequence: u64,
    missing: u64,
}

impl Ledger {
    /// Takes in one delta.
    ///
    /// # Errors
    ///
    /// [`LogError::Damaged`] when it speaks of cells that do not exist.
    pub fn take(&mut self, delta: &v1::CoverageDelta) -> Result<(), LogError> {
        self.missing += delta.sequence.saturating_sub(self.sequence + 1);
        self.sequence = self.sequence.max(delta.sequence);
        if let Some(geometry) = &delta.lattice {
            self.lay_out(geometry)?;
        }
        delta.runs.iter().try_for_each(|run| self.take_run(run))
    }

    fn lay_out(&mut self, geometry: &v1::LatticeGeometry) -> Result<(), LogError> {
        let cells = u64::from(geometry.columns) * u64::from(geometry.rows);
        let finite = geometry.origin_x_m.is_finite() && geometry.origin_y_m.is_finite();
        if cells > CELLS_MAX || !finite || !geometry.cell_m.is_finite() || geometry.cell_m <= 0.0 {
            return Err(LogError::Damaged(format!("impossible lattice {geometry:?}")));
        }
        self.lattice = Some(Lattice {
            origin: Point::new(geometry.origin_x_m, geometry.origin_y_m),
            cell_m: geometry.cell_m,
            columns: geometry.columns,
            rows: geometry.rows,
        });
        self.claims = vec![Claim::default(); cells as usize];
        Ok(())
    }

    fn take_run(&mut self, run: &v1::CellRun) -> Result<(), LogError> {
        let outside = || LogError::Damaged(format!("a delta names cells outside its lattice: {run:?}"));
        let lattice = self.lattice.ok_or_else(outside)?;
        let end = run.column.checked_add(run.length).filter(|&end| end <= lattice.columns);
        if end.is_none() || run.row >= lattice.rows {
            return Err(outside());
        }
        let robot = (!run.serial_number.is_empty()).then(|| self.number_of(&run.serial_number));
        let start = run.row as usize * lattice.columns as usize + run.column as usize;
        self.claims[start..start + run.length as usize].fill(Claim {
            status: run.status(),
            reason: run.reason(),
            robot,
        });
        Ok(())
    }

    /// The number of a robot; a new one for a robot not met before.
    pub fn number_of(&mut self, robot: &str) -> u16 {
        let known = self.robots.iter().position(|known| known == robot);
        let number = known.unwrap_or_else(|| {
            self.robots.push(robot.to_owned());
            self.robots.len() - 1
        });
        number as u16
    }

    /// The lattice, once the first delta has told it.
    pub fn lattice(&self) -> Option<&Lattice> {
        self.lattice.as_ref()
    }

    /// The claims, by cell, row by row from the bottom.
    pub fn claims(&self) -> &[Claim] {
        &self.claims
    }

    /// The robots that were named, by number.
    pub fn robots(&self) -> &[String] {
        &self.robots
    }

    /// How many deltas are missing from the record.
    pub fn missing_deltas(&self) -> u64 {
        self.missing
    }

    /// How many cells are in a state.
    pub fn count(&self, status: v1::CellStatus) -> usize {
        self.claims.iter().filter(|claim| claim.status == status).count()
    }

    /// The cells with their claims.
    pub fn cells(&self) -> impl Iterator<Item = (Cell, Claim)> + '_ {
        self.lattice.iter().flat_map(Lattice::cells).zip(self.claims.iter().copied())
    }
}
