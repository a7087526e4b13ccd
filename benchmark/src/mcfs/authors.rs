//! What the authors of MCFS print, and what was measured on their program.

use crate::{BenchmarkError, csv_rows, read};
use serde::Deserialize;
use std::path::Path;

#[derive(Debug, Deserialize)]
struct Printed {
    table: String,
    instance: String,
    method: String,
    metric: String,
    value: f64,
}

/// A run of their program, by exact definitions.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Measured {
    instance: String,
    method: String,
    solver: String,
    pub(super) makespan_closed: f64,
    pub(super) coverage_exact: f64,
    pub(super) overlap_two_robots_exact: f64,
    pub(super) turning_per_length: f64,
    pub(super) efficiency: f64,
}

/// All figures of theirs.
#[derive(Debug)]
pub(super) struct Authors {
    printed: Vec<Printed>,
    measured: Vec<Measured>,
}

impl Authors {
    pub(super) fn load(instances: &Path) -> Result<Self, BenchmarkError> {
        let path = instances.join("mcfs/reference.csv");
        let printed = csv_rows(&path, &read(&path)?)?;
        let path = instances.join("mcfs/measured.csv");
        let text = read(&path)?;
        let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
        Ok(Self { printed, measured: csv_rows(&path, &lines.join("\n"))? })
    }

    /// A figure of one of the paper's tables.
    pub(super) fn printed(&self, table: &str, instance: &str, method: &str, metric: &str) -> Option<f64> {
        let found = self.printed.iter().find(|row| {
            row.table == table && row.instance == instance && row.method == method && row.metric == metric
        });
        found.map(|row| row.value)
    }

    /// Exact figures of a variant: of the stored paths, or else of a run of the program.
    pub(super) fn measured(&self, instance: &str, method: &str) -> Option<&Measured> {
        let of = |name: &str| {
            let mut rows = self.measured.iter().filter(move |row| row.instance == instance);
            let name = name.to_owned();
            rows.find(|row| row.method == name && !row.solver.contains("not optimal"))
        };
        of(&format!("{method} (stored)"))
            .or_else(|| of(method))
            .or_else(|| of(&format!("{method} (peer's re-implementation)")))
    }
}
