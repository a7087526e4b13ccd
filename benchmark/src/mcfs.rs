//! The polygon instances of the MCFS paper: loaded, planned, evaluated.

mod authors;
pub mod evaluator;
mod overlay_grid;
mod paper_pipeline;
pub mod polygon_instances;

use crate::{BenchmarkError, Options, Progress, Table};

pub(crate) fn run(options: &Options, progress: Progress<'_>) -> Result<Vec<Table>, BenchmarkError> {
    paper_pipeline::tables(options, progress)
}
