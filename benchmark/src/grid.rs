//! The grid instances of LS-MCPP, MIP-MCPP and the MFC paper's Fig. 6, each under its own cost.

use crate::{
    BenchmarkError, Options, Progress, Table, content, csv_rows, grid_instances, read,
    tables::{mean, ratio, tenths},
};
use planner::{PLANNERS, PlanError, Planner};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// In a quick run, only instances with at most so many cells.
const QUICK_CELLS: usize = 200;
/// Planners whose work grows faster than n log n are left out above so many cells.
const SLOW_CELLS: usize = 4_000;

#[derive(Debug, Clone, Deserialize)]
struct Reference {
    instance: String,
    lower_bound: Option<f64>,
    best_known: Option<f64>,
    #[serde(rename = "LS_makespan")]
    ls_makespan: Option<String>,
}

/// The core instances, one by one.
pub(crate) fn run(options: &Options, progress: Progress<'_>) -> Result<Vec<Table>, BenchmarkError> {
    let folder = options.instances.join("grid");
    let path = folder.join("reference.csv");
    let references: Vec<Reference> = csv_rows(&path, &read(&path)?)?;
    let (mut summary, table) = measure(options, &folder, &references, progress)?;
    summary.note.push_str(" Rows are in the table below.");
    Ok(vec![summary, table])
}

/// All others: too many for rows in a document.
pub(crate) fn run_extended(options: &Options, progress: Progress<'_>) -> Result<Vec<Table>, BenchmarkError> {
    let mut tables = Vec::new();
    for folder in ["extended", "fig6"] {
        let (mut summary, _) = measure(options, &options.instances.join("grid").join(folder), &[], progress)?;
        summary.name = format!("grid_{folder}_summary");
        summary.title = format!("Grid instances, `{folder}`, in short");
        tables.push(summary);
    }
    Ok(tables)
}

/// A summary, and a row for each instance and planner of a folder.
fn measure(
    options: &Options,
    folder: &Path,
    references: &[Reference],
    progress: Progress<'_>,
) -> Result<(Table, Table), BenchmarkError> {
    let mut table = Table::new(
        "grid",
        "Grid instances",
        "Cost of the costliest closed walk, in the unit of each instance. Bound: ours; the reference's where it is \
         larger. Best known: the smallest that is known from any program. LS: LS-MCPP as measured for the reference.",
        &["instance", "cells", "k", "planner", "makespan", "÷ bound", "÷ best known", "LS", "CPU s"],
    );
    let mut ratios: Vec<Ratios> = Vec::new();
    for file in json_files(folder)? {
        let task = grid_instances::load(&file)?;
        let cells = (0..task.floor.lattice().len()).filter(|&index| task.floor.is_drivable(index)).count();
        if options.quick && cells > QUICK_CELLS {
            continue;
        }
        progress(&format!("{} ({cells} cells, {} robots)", task.name, task.starts.len()));
        let reference = references.iter().find(|row| row.instance == task.name);
        let bound = reference.and_then(|row| row.lower_bound).unwrap_or(0.0).max(task.lower_bound_s());
        let best = reference.and_then(|row| row.best_known);
        let ls = reference.and_then(|row| row.ls_makespan.clone()).unwrap_or_default();
        let fits =
            |planner: &&Planner| !planner.leaves_lattice() && (cells <= SLOW_CELLS || !planner.is_slow);
        for planner in PLANNERS.iter().filter(fits) {
            let head = [
                task.name.clone(),
                cells.to_string(),
                task.starts.len().to_string(),
                planner.name.to_owned(),
            ];
            let tail = match task.plan(planner.name, options.effort) {
                Ok(made) => {
                    let makespan = made.makespan_s();
                    let to_best = best.map(|best| makespan / best);
                    ratios.push(Ratios {
                        planner: planner.name,
                        to_bound: makespan / bound,
                        to_best,
                        cpu_s: made.cpu_s,
                    });
                    let to_best = to_best.map(ratio).unwrap_or_default();
                    [tenths(makespan), ratio(makespan / bound), to_best, ls.clone(), ratio(made.cpu_s)]
                }
                Err(PlanError::Unsupported { reason, .. }) => {
                    [format!("refused: {reason}"), String::new(), String::new(), ls.clone(), String::new()]
                }
                Err(error) => return Err(content(&file, error.to_string())),
            };
            table.push([&head[..], &tail].concat());
        }
    }
    Ok((summary(&ratios), table))
}

/// One plan, compared.
struct Ratios {
    planner: &'static str,
    to_bound: f64,
    to_best: Option<f64>,
    cpu_s: f64,
}

fn summary(ratios: &[Ratios]) -> Table {
    let mut table = Table::new(
        "grid_summary",
        "Grid instances in short",
        "Means over the instances that a planner did not refuse; their CPU seconds together.",
        &["planner", "instances", "mean ÷ bound", "mean ÷ best known", "CPU s"],
    );
    for planner in PLANNERS {
        let own: Vec<&Ratios> = ratios.iter().filter(|row| row.planner == planner.name).collect();
        if own.is_empty() {
            continue;
        }
        let to_bound: Vec<f64> = own.iter().map(|row| row.to_bound).collect();
        let to_best: Vec<f64> = own.iter().filter_map(|row| row.to_best).collect();
        let cpu_s: f64 = own.iter().map(|row| row.cpu_s).sum();
        table.push(vec![
            planner.name.to_owned(),
            own.len().to_string(),
            ratio(mean(&to_bound)),
            if to_best.is_empty() { String::new() } else { ratio(mean(&to_best)) },
            tenths(cpu_s),
        ]);
    }
    table
}

/// The instances of a folder, in the order of their names.
fn json_files(folder: &Path) -> Result<Vec<PathBuf>, BenchmarkError> {
    let failed = |cause| BenchmarkError::Read { path: folder.to_owned(), cause };
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if path.extension().is_some_and(|ending| ending == "json") {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}
