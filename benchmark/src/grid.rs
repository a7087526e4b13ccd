//! The grid instances of LS-MCPP, MIP-MCPP and the MFC paper's Fig. 6, each under its own cost.

use crate::{
    BenchmarkError, Options, Progress, Table, content, csv_rows, grid_instances, read,
    tables::{mean, ratio, tenths},
};
use planner::{PLANNERS, PlanError};
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

pub(crate) fn run(options: &Options, progress: Progress<'_>) -> Result<Vec<Table>, BenchmarkError> {
    let folder = options.instances.join("grid");
    let path = folder.join("reference.csv");
    let references: Vec<Reference> = csv_rows(&path, &read(&path)?)?;
    let mut table = Table::new(
        "grid",
        "Grid instances",
        "Cost of the costliest closed walk, in the unit of each instance. Bound: ours; the reference's where it is \
         larger. Best known: the smallest that is known from any program. LS: LS-MCPP as measured for the reference.",
        &["instance", "cells", "k", "planner", "makespan", "÷ bound", "÷ best known", "LS", "CPU s"],
    );
    let mut ratios: Vec<(&'static str, f64, Option<f64>)> = Vec::new();
    for file in json_files(&folder)? {
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
        for planner in PLANNERS.iter().filter(|planner| cells <= SLOW_CELLS || !planner.is_slow) {
            let head = [
                task.name.clone(),
                cells.to_string(),
                task.starts.len().to_string(),
                planner.name.to_owned(),
            ];
            let tail = match task.plan(planner.name, options.effort) {
                Ok(made) => {
                    let makespan = made.makespan_s();
                    ratios.push((planner.name, makespan / bound, best.map(|best| makespan / best)));
                    let to_best = best.map(|best| ratio(makespan / best)).unwrap_or_default();
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
    Ok(vec![summary(&ratios), table])
}

fn summary(ratios: &[(&'static str, f64, Option<f64>)]) -> Table {
    let mut table = Table::new(
        "grid_summary",
        "Grid instances in short",
        "Means over the rows below that a planner did not refuse.",
        &["planner", "instances", "mean ÷ bound", "mean ÷ best known"],
    );
    for planner in PLANNERS {
        let own: Vec<_> = ratios.iter().filter(|row| row.0 == planner.name).collect();
        let to_bound: Vec<f64> = own.iter().map(|row| row.1).collect();
        let to_best: Vec<f64> = own.iter().filter_map(|row| row.2).collect();
        let means = [ratio(mean(&to_bound)), ratio(mean(&to_best))];
        table.push([&[planner.name.to_owned(), own.len().to_string()][..], &means].concat());
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
