//! Tables II and III of the TMSTC* paper: turns of the walk around one tree, and the time of teams.

use crate::{
    BenchmarkError, Options, Progress, Table, content, csv_rows, read,
    tables::{mean, ratio, tenths},
    tmstc_instances::{MAPS, PaperMap},
};
use planner::{Mode, PLANNERS, TREES, tree_turns};
use serde::Deserialize;
use std::path::Path;

/// The authors' public program on the same starts, timed with equation 8 (measured once; see the note of the table).
const AUTHORS_PROGRAM: &str = include_str!("../data/tmstc_authors_program.csv");
/// Trees that draw are grown with so many seeds.
const SEEDS: u64 = 5;

#[derive(Debug, Clone, Deserialize)]
struct Authors {
    map: String,
    robots: usize,
    cover_s: f64,
    cover_best_of_two_s: f64,
    return_s: f64,
    return_best_of_two_s: f64,
}

#[derive(Debug, Clone, Deserialize)]
struct Printed {
    table: String,
    map: String,
    robots: usize,
    algorithm: String,
    coverage_time_max_s: Option<f64>,
    turns: Option<u32>,
}

pub(crate) fn run(options: &Options, progress: Progress<'_>) -> Result<Vec<Table>, BenchmarkError> {
    let folder = &options.instances;
    let printed: Vec<Printed> = printed(&folder.join("tmstc/reference.csv"))?;
    let maps = MAPS.into_iter().map(|name| PaperMap::load(folder, name));
    let mut maps = maps.collect::<Result<Vec<_>, _>>()?;
    if options.quick {
        maps.truncate(1);
        maps[0].teams.truncate(2);
    }
    let turns = table_ii(&maps, &printed, progress);
    let [rows, summary] = table_iii(options, &maps, &printed, progress)?;
    Ok(vec![turns, rows, summary])
}

fn printed(path: &Path) -> Result<Vec<Printed>, BenchmarkError> {
    csv_rows(path, &read(path)?)
}

fn table_ii(maps: &[PaperMap], printed: &[Printed], progress: Progress<'_>) -> Table {
    let mut table = Table::new(
        "tmstc_table_ii",
        "Table II: turns of the closed walk around one tree",
        "Paper in brackets (DFS there is the horizontal one; for `indoor` it repeats the figure of `random`, and \
         `denver_2` and `newyork_0` count 8 and 4 turns in pieces that no robot reaches). Ant colonies: 5 seeds, \
         smallest to largest.",
        &["map", "tree", "turns", "paper"],
    );
    for map in maps {
        for tree in TREES {
            progress(&format!("Table II: {} {}", map.name, tree.name));
            let task = map.task(1, Mode::Cover);
            let seeds = if tree.draws { SEEDS } else { 1 };
            let turns: Vec<u32> = (0..seeds).map(|seed| tree_turns(&task.instance(), tree, seed)).collect();
            let (least, most) = (turns.iter().min(), turns.iter().max());
            let text = match (least, most) {
                (Some(least), Some(most)) if least != most => format!("{least}–{most}"),
                (least, _) => least.map(ToString::to_string).unwrap_or_default(),
            };
            let paper = printed.iter().find(|row| {
                row.table == "II"
                    && row.map == map.name
                    && Some(row.algorithm.as_str()) == paper_name(tree.name)
            });
            let paper = paper.and_then(|row| row.turns).map(|turns| format!("({turns})"));
            table.push(vec![map.name.to_owned(), tree.name.to_owned(), text, paper.unwrap_or_default()]);
        }
    }
    table
}

fn paper_name(tree: &str) -> Option<&'static str> {
    match tree {
        "dfs-horizontal" => Some("DFS"),
        "aco" => Some("ACO"),
        "kruskal" => Some("Kruskal"),
        "turn-minimising" => Some("TMSTC*"),
        _ => None,
    }
}

fn table_iii(
    options: &Options,
    maps: &[PaperMap],
    printed: &[Printed],
    progress: Progress<'_>,
) -> Result<[Table; 2], BenchmarkError> {
    let path = Path::new("benchmark/data/tmstc_authors_program.csv");
    let authors: Vec<Authors> = csv_rows(path, AUTHORS_PROGRAM)?;
    let mut table = Table::new(
        "tmstc_table_iii",
        "Table III: time until the last robot is done",
        "Seconds by equation 8 on the robots of Table I. Authors: their public program on the same starts, timed in \
         the same way; of its two ways to price the drive to a piece the better one in each row. Paper: printed, \
         timed in Gazebo, cover and return, hence only beside `return`; for k = 4, 8, 12 from starts of its own. CPU: \
         user seconds of planning and verification.",
        &["map", "k", "mode", "planner", "s", "÷ bound", "÷ authors", "paper", "CPU s"],
    );
    let mut ratios: Vec<(String, &'static str, f64, f64)> = Vec::new();
    for map in maps {
        for &robots in &map.teams {
            for (mode, mode_name) in [(Mode::Cover, "cover"), (Mode::CoverAndReturn, "return")] {
                progress(&format!("Table III: {} k={robots} {mode_name}", map.name));
                let task = map.task(robots, mode);
                let bound_s = task.lower_bound_s();
                let row = authors.iter().find(|row| row.map == map.name && row.robots == robots);
                let row = row.ok_or_else(|| content(path, format!("no row for {}", task.name)))?;
                let authors_s = match mode {
                    Mode::Cover => row.cover_s.min(row.cover_best_of_two_s),
                    Mode::CoverAndReturn => row.return_s.min(row.return_best_of_two_s),
                };
                for planner in PLANNERS.iter().filter(|planner| !planner.leaves_lattice()) {
                    let head = [map.name.to_owned(), robots.to_string(), mode_name.to_owned()];
                    let tail = match task.plan(planner.name, options.effort) {
                        Ok(made) => {
                            let (to_bound, to_authors) =
                                (made.makespan_s() / bound_s, made.makespan_s() / authors_s);
                            ratios.push((planner.name.to_owned(), mode_name, to_bound, to_authors));
                            let paper = paper_s(printed, map.name, robots, planner.name, mode);
                            [
                                tenths(made.makespan_s()),
                                ratio(to_bound),
                                ratio(to_authors),
                                paper.map(tenths).unwrap_or_default(),
                                ratio(made.cpu_s),
                            ]
                        }
                        Err(error) => [
                            format!("refused: {error}"),
                            String::new(),
                            String::new(),
                            String::new(),
                            String::new(),
                        ],
                    };
                    let name = [planner.name.to_owned()];
                    table.push([&head[..], &name, &tail].concat());
                }
            }
        }
    }
    Ok([table, summary(&ratios)])
}

fn paper_s(printed: &[Printed], map: &str, robots: usize, planner: &str, mode: Mode) -> Option<f64> {
    let algorithm = match planner {
        "tmstc-star" => "TMSTC*",
        "mstc-star" if map != "denver_2" => "MSTC*",
        "darp" => "DARP",
        _ => return None,
    };
    let same = |row: &&Printed| {
        row.table == "III" && row.map == map && row.robots == robots && row.algorithm == algorithm
    };
    let row = printed.iter().find(same).filter(|_| mode == Mode::CoverAndReturn)?;
    row.coverage_time_max_s
}

fn summary(ratios: &[(String, &'static str, f64, f64)]) -> Table {
    let mut table = Table::new(
        "tmstc_table_iii_summary",
        "Table III in short",
        "Means over the rows above that a planner did not refuse.",
        &["planner", "mode", "rows", "mean ÷ bound", "mean ÷ authors", "worst ÷ authors"],
    );
    for planner in PLANNERS.iter().filter(|planner| !planner.leaves_lattice()) {
        for mode in ["cover", "return"] {
            let own: Vec<_> =
                ratios.iter().filter(|(name, of, ..)| name == planner.name && *of == mode).collect();
            if own.is_empty() {
                continue;
            }
            let to_bound: Vec<f64> = own.iter().map(|row| row.2).collect();
            let to_authors: Vec<f64> = own.iter().map(|row| row.3).collect();
            table.push(vec![
                planner.name.to_owned(),
                mode.to_owned(),
                own.len().to_string(),
                ratio(mean(&to_bound)),
                ratio(mean(&to_authors)),
                ratio(to_authors.iter().copied().fold(0.0, f64::max)),
            ]);
        }
    }
    table
}
