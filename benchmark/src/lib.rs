//! The planners on the instances of the papers, side by side with the printed figures.
//!
//! ```text
//!   instances (../shared/instances) ──▶ Task ──▶ planner::plan ──▶ Table ──▶ CSV, Markdown, SVG
//!                                                lower bound, user CPU
//! ```
//!
//! One file per benchmark. Each makes [`Table`]s; `oxplow bench` prints and writes them. Times are user CPU seconds of
//! this process, never wall time: planners are single-threaded.

pub mod cpu;
mod grid;
mod grid_instances;
mod growth;
mod indoor;
pub mod mcfs;
mod mfc;
mod pictures;
pub mod plot;
mod tables;
mod task;
mod terrains;
mod tmstc;
mod tmstc_instances;

pub use pictures::Picture;
pub use tables::Table;

use std::path::{Path, PathBuf};
use thiserror::Error;

/// What to run.
#[derive(Debug, Clone)]
pub struct Options {
    /// Folder of the instances: `tmstc/`, `grid/`, … lie in it.
    pub instances: PathBuf,
    /// A few small instances only: does it work at all?
    pub quick: bool,
    /// Effort of planners that improve their answer (see [`planner::PlanOptions::effort`]).
    pub effort: u32,
}

/// Called with one line for each thing that is about to be done.
pub type Progress<'a> = &'a mut dyn FnMut(&str);

/// One row of the table of benchmarks.
#[derive(Debug, Clone, Copy)]
pub struct Benchmark {
    /// Name on the command line.
    pub name: &'static str,
    /// What it reproduces.
    pub about: &'static str,
    /// Runs it.
    pub run: fn(&Options, Progress<'_>) -> Result<Vec<Table>, BenchmarkError>,
}

/// Every benchmark.
pub const BENCHMARKS: &[Benchmark] = &[
    Benchmark { name: "tmstc", about: "Tables II and III of Lu and others 2023 (TMSTC*)", run: tmstc::run },
    Benchmark {
        name: "grid-extended",
        about: "258 more of these, and those of Fig. 6, in short",
        run: grid::run_extended,
    },
    Benchmark { name: "mfc", about: "Fig. 6 of Zheng and others 2005 (MFC)", run: mfc::run },
    Benchmark { name: "mcfs", about: "Tables and Fig. 7 of Tang and Ma 2024 (MCFS)", run: mcfs::run },
    Benchmark { name: "growth", about: "planning time by size of the floor", run: growth::run },
    Benchmark {
        name: "grid",
        about: "the grid instances of LS-MCPP and MIP-MCPP under their costs",
        run: grid::run,
    },
    Benchmark {
        name: "charging",
        about: "batteries, chargers and four robots on floor plans",
        run: indoor::charging::run,
    },
    Benchmark {
        name: "indoor",
        about: "floor plans as in Fig. 5 of the boustrophedon paper, and B1 of the notes",
        run: indoor::run,
    },
];

/// Why a benchmark cannot be run.
#[derive(Debug, Error)]
pub enum BenchmarkError {
    /// A file cannot be read.
    #[error("{path}: {cause}; give the folder of the instances with --instances")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why not.
        cause: std::io::Error,
    },
    /// A file says something else than expected.
    #[error("{path}: {what}")]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
}

fn read(path: &Path) -> Result<String, BenchmarkError> {
    std::fs::read_to_string(path).map_err(|cause| BenchmarkError::Read { path: path.to_owned(), cause })
}

fn content(path: &Path, what: impl Into<String>) -> BenchmarkError {
    BenchmarkError::Content { path: path.to_owned(), what: what.into() }
}

fn read_json<T: serde::de::DeserializeOwned>(path: &Path) -> Result<T, BenchmarkError> {
    serde_json::from_str(&read(path)?).map_err(|error| content(path, error.to_string()))
}

/// The rows of a CSV text with a head line.
fn csv_rows<T: serde::de::DeserializeOwned>(path: &Path, text: &str) -> Result<Vec<T>, BenchmarkError> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    reader.deserialize().collect::<Result<_, _>>().map_err(|error| content(path, error.to_string()))
}
