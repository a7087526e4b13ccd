//! Fig. 6 of the MFC paper: the time of the slowest robot over the ideal one, 100 random terrains a row.

use crate::{
    BenchmarkError, Options, Progress, Table, content, csv_rows, read,
    tables::{mean, ratio},
    task::Task,
    terrains::{Terrain, generator, robots},
};
use planner::Mode;
use serde::Deserialize;
use terrain::MotionModel;

const SEEDS: u64 = 100;
const QUICK_SEEDS: u64 = 2;
/// Planners shown, in this order, and the seeds that each gets: ours is here for comparison alone.
const PLANNERS: [(&str, u64); 4] =
    [("mfc", SEEDS), ("mstc", SEEDS), ("mstc-optimized", SEEDS), ("forest-search", SEEDS / 20)];

/// One second a move, nothing else takes time.
const MOTION: MotionModel = MotionModel {
    speed_m_per_s: 1.0,
    acceleration_m_per_s2: f64::INFINITY,
    angular_speed_rad_per_s: f64::INFINITY,
    angular_acceleration_rad_per_s2: f64::INFINITY,
    brakes: false,
};

/// A row as printed.
#[derive(Debug, Clone, Deserialize)]
struct Printed {
    terrain: String,
    robots: usize,
    clustering_percent: String,
    mfc_return_ratio: f64,
    mfc_cover_ratio: f64,
    mstc_return_ratio: f64,
    mstc_cover_ratio: f64,
    opt_mstc_return_ratio: f64,
    opt_mstc_cover_ratio: f64,
}

impl Printed {
    fn ratio(&self, planner: &str, mode: Mode) -> Option<f64> {
        match (planner, mode) {
            ("mfc", Mode::CoverAndReturn) => Some(self.mfc_return_ratio),
            ("mfc", Mode::Cover) => Some(self.mfc_cover_ratio),
            ("mstc", Mode::CoverAndReturn) => Some(self.mstc_return_ratio),
            ("mstc", Mode::Cover) => Some(self.mstc_cover_ratio),
            ("mstc-optimized", Mode::CoverAndReturn) => Some(self.opt_mstc_return_ratio),
            ("mstc-optimized", Mode::Cover) => Some(self.opt_mstc_cover_ratio),
            _ => None,
        }
    }
}

pub(crate) fn run(options: &Options, progress: Progress<'_>) -> Result<Vec<Table>, BenchmarkError> {
    let path = options.instances.join("grid/fig6/paper_fig6.csv");
    let mut printed: Vec<Printed> = csv_rows(&path, &read(&path)?)?;
    if options.quick {
        printed.retain(|row| row.terrain == "empty" && row.clustering_percent == "none");
    }
    let mut table = Table::new(
        "mfc_fig_6",
        "Fig. 6: time of the slowest robot ÷ ideal time",
        &format!(
            "One per move, no turns. Ideal: cells ÷ robots − 1. Means over {SEEDS} random terrains and starts a row ({} for `forest-search`, {QUICK_SEEDS} in a quick run); the \
             paper's ratio in brackets. The layout of the indoor terrain is a guess; `mstc` divides the \
             gaps between robots better than the paper's baseline, so it is no reproduction of it. CPU: mean user seconds of one plan.",
            SEEDS / 20
        ),
        &[
            "terrain",
            "robots",
            "clustering %",
            "mode",
            "planner",
            "max",
            "min",
            "ratio",
            "paper",
            "difference",
            "CPU s",
        ],
    );
    for row in &printed {
        let terrain = Terrain::named(&row.terrain);
        let terrain = terrain.ok_or_else(|| content(&path, format!("unknown terrain `{}`", row.terrain)))?;
        for (mode, mode_name) in [(Mode::CoverAndReturn, "return"), (Mode::Cover, "cover")] {
            progress(&format!("{} k={} {} {mode_name}", row.terrain, row.robots, row.clustering_percent));
            for (planner, seeds) in PLANNERS {
                let seeds = if options.quick { QUICK_SEEDS } else { seeds };
                let runs = Runs::measure(row, terrain, mode, planner, seeds, options)
                    .map_err(|what| content(&path, what))?;
                table.push(runs.row(row, mode, mode_name, planner));
            }
        }
    }
    Ok(vec![summary(&table), table])
}

/// What one planner made of one row.
#[derive(Default)]
struct Runs {
    max: Vec<f64>,
    min: Vec<f64>,
    ideal: Vec<f64>,
    cpu_s: Vec<f64>,
}

impl Runs {
    fn measure(
        row: &Printed,
        terrain: Terrain,
        mode: Mode,
        planner: &str,
        seeds: u64,
        options: &Options,
    ) -> Result<Self, String> {
        let clustering = row.clustering_percent.parse().ok();
        let mut runs = Self::default();
        for seed in 0..seeds {
            let mut rng = generator(seed);
            let floor = terrain.floor(&mut rng);
            let starts = robots(&floor, row.robots, clustering, &mut rng);
            let name = format!("{} {seed}", row.terrain);
            let task = Task { name, floor, starts, motion: MOTION, mode, weights: None };
            let cells = task.instance().visit.iter().filter(|&&visit| visit).count();
            let made = task.plan(planner, options.effort).map_err(|error| error.to_string())?;
            let costs = &made.plan.figures().cost_s;
            runs.max.push(made.makespan_s());
            runs.min.push(costs.iter().copied().fold(f64::INFINITY, f64::min));
            runs.ideal.push(cells as f64 / row.robots as f64 - 1.0);
            runs.cpu_s.push(made.cpu_s);
        }
        Ok(runs)
    }

    fn row(&self, row: &Printed, mode: Mode, mode_name: &str, planner: &str) -> Vec<String> {
        let own = mean(&self.max) / mean(&self.ideal);
        let paper = row.ratio(planner, mode);
        vec![
            row.terrain.clone(),
            row.robots.to_string(),
            row.clustering_percent.clone(),
            mode_name.to_owned(),
            planner.to_owned(),
            format!("{:.0}", mean(&self.max)),
            format!("{:.0}", mean(&self.min)),
            ratio(own),
            paper.map(|paper| format!("({paper:.2})")).unwrap_or_default(),
            paper.map(|paper| format!("{:+.3}", own - paper)).unwrap_or_default(),
            ratio(mean(&self.cpu_s)),
        ]
    }
}

/// Means over rows, and the largest difference from the paper by terrain.
fn summary(table: &Table) -> Table {
    let mut summary = Table::new(
        "mfc_fig_6_summary",
        "Fig. 6 in short",
        "Over the rows below.",
        &["planner", "terrain", "mode", "mean ratio", "largest difference from the paper"],
    );
    for (planner, _) in PLANNERS {
        for terrain in ["empty", "outdoor", "indoor"] {
            for mode in ["return", "cover"] {
                let own = || {
                    table.rows.iter().filter(|row| row[4] == planner && row[0] == terrain && row[3] == mode)
                };
                let ratios: Vec<f64> = own().filter_map(|row| row[7].parse().ok()).collect();
                let differences = own().filter_map(|row| row[9].parse().ok());
                let largest = differences.max_by(|a: &f64, b: &f64| a.abs().total_cmp(&b.abs()));
                if !ratios.is_empty() {
                    let largest = largest.map(|largest| format!("{largest:+.3}")).unwrap_or_default();
                    let head = [planner, terrain, mode].map(str::to_owned);
                    summary.push([&head[..], &[ratio(mean(&ratios)), largest]].concat());
                }
            }
        }
    }
    summary
}
