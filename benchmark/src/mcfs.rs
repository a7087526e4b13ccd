//! Tables of the MCFS paper on its seven polygons: ours beside what its authors printed and stored.

mod authors;
mod drawing;
pub mod evaluator;
mod overlay_grid;
mod paper_pipeline;
pub mod polygon_instances;

use crate::cpu::timed;
use crate::plot::LinePlot;
use crate::tables::{ratio, tenths};
use crate::{BenchmarkError, Options, Picture, Progress, Table, content, csv_rows, read};
use evaluator::{PathFigures, evaluate};
use planner::mcfs::{McfsOptions, PolygonInstance, cover};
use polygon_instances::{NAMES, load, stored_paths};
use serde::Deserialize;
use std::path::Path;
use terrain::Point;

/// Shares of the ground asked for along the front.
const FRONT: [f64; 2] = [0.85, 0.95];
/// Teams of Fig. 7.
const TEAMS: std::ops::RangeInclusive<usize> = 2..=12;

/// A row as printed or measured by its authors' repository.
#[derive(Debug, Clone, Deserialize)]
struct Printed {
    table: String,
    instance: String,
    robots: usize,
    method: String,
    metric: String,
    value: f64,
}

/// An instance, and what its authors reached on it, measured by our evaluator.
struct Ground {
    name: &'static str,
    instance: PolygonInstance,
    authors: PathFigures,
}

impl Ground {
    fn ideal_m(&self) -> f64 {
        self.instance.area_m2() / (self.instance.starts.len() as f64 * self.instance.tool_width_m)
    }
}

/// Lines of ours, measured.
struct Made {
    paths: Vec<Vec<Point>>,
    figures: PathFigures,
    cpu_s: f64,
}

pub(crate) fn run(options: &Options, progress: Progress<'_>) -> Result<Vec<Table>, BenchmarkError> {
    let folder = &options.instances;
    let names = if options.quick { &NAMES[..1] } else { &NAMES[..] };
    let grounds = names.iter().map(|&name| ground(folder, name)).collect::<Result<Vec<_>, _>>()?;
    let path = folder.join("mcfs/reference.csv");
    let printed: Vec<Printed> = csv_rows(&path, &read(&path)?)?;
    let mut tables = vec![whole(&grounds, progress)?, equal_coverage(&grounds, &printed, progress)?];
    if !options.quick {
        tables.push(front(&grounds, progress)?);
        tables.push(teams(&grounds, &printed, progress)?);
    }
    tables.extend(paper_pipeline::tables(options, progress)?);
    Ok(tables)
}

fn ground(folder: &Path, name: &'static str) -> Result<Ground, BenchmarkError> {
    let instance = load(folder, name)?;
    let authors = evaluate(&instance.ground, instance.tool_width_m, &stored_paths(folder, name)?);
    Ok(Ground { name, instance, authors })
}

fn make(
    name: &str,
    instance: &PolygonInstance,
    coverage_target: Option<f64>,
) -> Result<Made, BenchmarkError> {
    let options = McfsOptions { coverage_target, ..McfsOptions::default() };
    let (plan, cpu_s) = timed(|| cover(instance, &options));
    let plan = plan.map_err(|error| content(Path::new(name), error.to_string()))?;
    let paths: Vec<Vec<Point>> = plan.routes.into_iter().map(|route| route.points).collect();
    let figures = evaluate(&instance.ground, instance.tool_width_m, &paths);
    Ok(Made { paths, figures, cpu_s })
}

fn whole(grounds: &[Ground], progress: Progress<'_>) -> Result<Table, BenchmarkError> {
    let mut table = Table::new(
        "mcfs_whole",
        "All ground",
        "All that the tool reaches is to be swept. Exact areas: A is the polygon's, l the tool's width, k the \
         robots, the makespan the longest closed line with the drive from the start and back, \
         η = coverage · A ÷ (k · l · makespan). In brackets the authors' stored MCFS+BOTH paths, measured in the same \
         way. Overlap: swept by two or more robots. Outside: swept outside the polygon. CPU: user seconds of planning.",
        &[
            "polygon",
            "k",
            "A/(k·l)",
            "makespan m",
            "coverage %",
            "η",
            "turning rad/m",
            "turns > 150°",
            "overlap %",
            "outside %",
            "CPU s",
        ],
    );
    for ground in grounds {
        progress(&format!("All ground: {}", ground.name));
        let made = make(ground.name, &ground.instance, None)?;
        let (ours, theirs) = (&made.figures, &ground.authors);
        let both = |ours: String, theirs: String| format!("{ours} ({theirs})");
        table.push(vec![
            ground.name.to_owned(),
            ground.instance.starts.len().to_string(),
            tenths(ground.ideal_m()),
            both(hundredths(ours.makespan_m), hundredths(theirs.makespan_m)),
            both(percent(ours.coverage), percent(theirs.coverage)),
            both(ratio(ours.efficiency), ratio(theirs.efficiency)),
            both(ratio(ours.turning_rad_per_m), ratio(theirs.turning_rad_per_m)),
            both(ours.reversals.to_string(), theirs.reversals.to_string()),
            both(percent(ours.overlap), percent(theirs.overlap)),
            both(percent(ours.swept_outside), percent(theirs.swept_outside)),
            hundredths(made.cpu_s),
        ]);
        table.pictures.push(drawing(ground, &made, "whole"));
    }
    Ok(table)
}

fn equal_coverage(
    grounds: &[Ground],
    printed: &[Printed],
    progress: Progress<'_>,
) -> Result<Table, BenchmarkError> {
    let mut table = Table::new(
        "mcfs_equal_coverage",
        "Table 2: as much ground as the authors",
        "The share of the ground that the authors' stored paths sweep is asked for. Printed: makespan in the paper's \
         Table 2, of open lines. In brackets the authors' stored paths, closed and measured in the same way.",
        &[
            "polygon",
            "k",
            "makespan m",
            "printed",
            "÷ authors",
            "coverage %",
            "turning rad/m",
            "turns > 150°",
            "overlap %",
            "CPU s",
        ],
    );
    for ground in grounds {
        progress(&format!("Equal coverage: {}", ground.name));
        let made = make(ground.name, &ground.instance, Some(ground.authors.coverage))?;
        let (ours, theirs) = (&made.figures, &ground.authors);
        let both = |ours: String, theirs: String| format!("{ours} ({theirs})");
        table.push(vec![
            ground.name.to_owned(),
            ground.instance.starts.len().to_string(),
            both(hundredths(ours.makespan_m), hundredths(theirs.makespan_m)),
            printed_makespan(printed, "Table 2", ground.name, ground.instance.starts.len()),
            ratio(ours.makespan_m / theirs.makespan_m),
            both(percent(ours.coverage), percent(theirs.coverage)),
            both(ratio(ours.turning_rad_per_m), ratio(theirs.turning_rad_per_m)),
            both(ours.reversals.to_string(), theirs.reversals.to_string()),
            both(percent(ours.overlap), percent(theirs.overlap)),
            hundredths(made.cpu_s),
        ]);
        table.pictures.push(drawing(ground, &made, "equal"));
    }
    Ok(table)
}

/// Makespan against coverage, the authors' point beside it.
fn front(grounds: &[Ground], progress: Progress<'_>) -> Result<Table, BenchmarkError> {
    let shares = FRONT.map(|share| format!("{:.0} %", 100.0 * share));
    let shares = shares.iter().map(String::as_str);
    let columns: Vec<&str> = ["polygon"].into_iter().chain(shares).chain(["all", "authors"]).collect();
    let mut table = Table::new(
        "mcfs_front",
        "Makespan for a share of the ground",
        "Makespan in metres (exact coverage in %) when a share of the ground is asked for; the authors' one point last.",
        &columns,
    );
    for ground in grounds {
        let mut row = vec![ground.name.to_owned()];
        let mut line = Vec::new();
        for target in FRONT.into_iter().map(Some).chain([None]) {
            progress(&format!("Front: {} {target:?}", ground.name));
            let figures = make(ground.name, &ground.instance, target)?.figures;
            row.push(format!("{} ({})", hundredths(figures.makespan_m), tenths(100.0 * figures.coverage)));
            line.push((100.0 * figures.coverage, figures.makespan_m));
        }
        let theirs = (100.0 * ground.authors.coverage, ground.authors.makespan_m);
        row.push(format!("{} ({})", hundredths(theirs.1), tenths(theirs.0)));
        table.push(row);
        line.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mark = vec![(theirs.0 - 0.4, theirs.1), (theirs.0 + 0.4, theirs.1)];
        let plot = LinePlot {
            title: format!("{}: makespan and coverage", ground.name),
            across: "coverage, %".to_owned(),
            up: "makespan, m".to_owned(),
            series: vec![("mcfs".to_owned(), line), ("authors".to_owned(), mark)],
        };
        let name = format!("mcfs_front_{}", ground.name);
        table.pictures.push(Picture::new(&name, &format!("Front of {}", ground.name), plot.svg()));
    }
    Ok(table)
}

/// Fig. 7: teams of 2 to 12 on the two largest polygons.
fn teams(grounds: &[Ground], printed: &[Printed], progress: Progress<'_>) -> Result<Table, BenchmarkError> {
    let mut table = Table::new(
        "mcfs_teams",
        "Fig. 7: teams of 2 to 12 robots",
        "All ground, starts of the instance in turn (more robots than starts share them). Authors: MCFS+BOTH in their \
         repository, at 7 to 11 % less coverage.",
        &["polygon", "k", "makespan m", "coverage %", "η", "authors", "CPU s"],
    );
    for ground in grounds.iter().filter(|ground| ["double_torus", "office"].contains(&ground.name)) {
        for robots in TEAMS {
            progress(&format!("Fig. 7: {} k={robots}", ground.name));
            let mut instance = ground.instance.clone();
            instance.starts = ground.instance.starts.iter().copied().cycle().take(robots).collect();
            let made = make(ground.name, &instance, None)?;
            let file =
                if ground.name == "office" { "office_num_robots.csv" } else { "two_torus_num_robots.csv" };
            table.push(vec![
                ground.name.to_owned(),
                robots.to_string(),
                hundredths(made.figures.makespan_m),
                percent(made.figures.coverage),
                ratio(made.figures.efficiency),
                printed_makespan(printed, file, ground.name, robots),
                hundredths(made.cpu_s),
            ]);
        }
    }
    Ok(table)
}

fn printed_makespan(printed: &[Printed], table: &str, instance: &str, robots: usize) -> String {
    let row = printed.iter().find(|row| {
        row.table == table
            && row.instance == instance
            && row.robots == robots
            && row.method == "MCFS-BOTH"
            && row.metric == "makespan"
    });
    row.map(|row| hundredths(row.value)).unwrap_or_default()
}

fn drawing(ground: &Ground, made: &Made, kind: &str) -> Picture {
    let caption = format!("{}, {} robots", ground.name, made.paths.len());
    Picture::new(
        &format!("mcfs_{kind}_{}", ground.name),
        &caption,
        drawing::svg(&ground.instance.ground, &made.paths, ground.instance.tool_width_m),
    )
}

fn hundredths(value: f64) -> String {
    format!("{value:.2}")
}

fn percent(share: f64) -> String {
    format!("{:.2}", 100.0 * share)
}
