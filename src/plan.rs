//! `oxplow plan`: a plan for a scenario or a map, and its figures; nothing drives.

mod mcfs;
mod picture;
mod report;
mod task;

use crate::say::say;
use anyhow::{Context, Result, bail};
use clap::Args;
use planner::{PlanOptions, VerifiedPlan};
use report::PlanReport;
use std::{
    path::PathBuf,
    process::ExitCode,
    sync::{Arc, mpsc},
    thread,
    time::{Duration, Instant},
};
use task::{Place, Task};

/// Plans the coverage of a scenario's floor, or of a map, and prints the plan's figures
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  oxplow plan scenarios/demo.toml --svg plan.svg
  oxplow plan --map maps/office.map --metres-per-char 0.5 --tool-width-m 0.75 --cell-m 0.5 \\
      --start 1.25,10.25 --start 38.25,10.25 --json

The JSON is described in docs/plan-format.md. Exit codes: 0 planned, 1 error, 2 usage.")]
pub struct PlanArgs {
    /// The scenario whose floor and robots are planned for
    #[arg(value_name = "SCENARIO.toml", required_unless_present = "map", conflicts_with = "map")]
    scenario: Option<PathBuf>,
    #[command(flatten)]
    on_map: MapArgs,
    /// Name of the planner; tmstc-star, or the scenario's, when left out
    #[arg(long, value_name = "NAME")]
    planner: Option<String>,
    /// Robots return to their starts
    #[arg(long = "return")]
    comes_back: bool,
    /// Give up when there is no plan after this time
    #[arg(long, value_name = "S", value_parser = positive)]
    time_limit_s: Option<f64>,
    /// Improvement steps of planners that go on improving: twice as much takes twice as long
    #[arg(long, value_name = "N", default_value_t = 1)]
    effort: u32,
    /// Seed of planners that draw
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    mcfs: mcfs::McfsArgs,
    /// Print the plan as JSON
    #[arg(long)]
    json: bool,
    /// Draw floor and routes into this file
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,
}

/// A floor and robots without a scenario file.
#[derive(Debug, Args)]
pub struct MapArgs {
    /// MovingAI .map, ROS .yaml with its image, GeoJSON or JSON polygons
    #[arg(long, value_name = "FILE", requires_all = ["tool_width_m", "start"])]
    map: Option<PathBuf>,
    /// Diameter of the tool's disc, metres
    #[arg(long, value_name = "D", requires = "map", value_parser = positive)]
    tool_width_m: Option<f64>,
    /// Side of a cell, metres; the largest that the tool covers from its centre, when left out
    #[arg(long, value_name = "C", requires = "map", value_parser = positive)]
    cell_m: Option<f64>,
    /// Where a robot starts: metres, and radians anticlockwise from x; once per robot
    #[arg(long, value_name = "X,Y[,THETA]", requires = "map", allow_hyphen_values = true)]
    start: Vec<Place>,
    /// Metres per character of a .map file
    #[arg(long, value_name = "M", default_value_t = 1.0, value_parser = positive)]
    metres_per_char: f64,
    /// Radius of the body, metres; 0.35 cells when left out
    #[arg(long, value_name = "R", requires = "map", value_parser = positive)]
    body_radius_m: Option<f64>,
    /// Top speed, m/s
    #[arg(long, value_name = "V", default_value_t = 0.5, value_parser = positive)]
    speed_m_per_s: f64,
    /// Acceleration and braking, m/s²
    #[arg(long, value_name = "A", default_value_t = 0.6, value_parser = positive)]
    acceleration_m_per_s2: f64,
    /// Turning speed in place, rad/s
    #[arg(long, value_name = "W", default_value_t = 0.8, value_parser = positive)]
    turn_rad_per_s: f64,
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("expected a finite number above 0".to_owned()),
    }
}

/// Runs the command.
///
/// # Errors
///
/// When map or scenario cannot be read, a start is not on free ground, there is no plan, or the picture cannot be
/// written.
pub fn run(args: &PlanArgs) -> Result<ExitCode> {
    let mut task = match &args.scenario {
        Some(path) => Task::of_scenario(path)?,
        None => Task::on_map(&args.on_map)?,
    };
    if args.comes_back {
        task.mode = planner::Mode::CoverAndReturn;
    }
    if let Some(name) = &args.planner {
        name.clone_into(&mut task.planner);
    }
    let task = Arc::new(task);
    let (plan, planning_s) = plan_within(&task, args)?;
    let report = PlanReport::new(&task, &plan, planning_s);
    if let Some(path) = &args.svg {
        let drawn = picture::draw(&task, &report);
        std::fs::write(path, drawn).with_context(|| format!("{}: cannot be written", path.display()))?;
    }
    if args.json {
        say!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        say!("{report}");
    }
    Ok(ExitCode::SUCCESS)
}

/// Plans in a thread of its own: planners know no clock, so the limit ends the process, not the planner.
fn plan_within(task: &Arc<Task>, args: &PlanArgs) -> Result<(VerifiedPlan, f64)> {
    let options = PlanOptions {
        planner: task.planner.clone(),
        effort: args.effort,
        seed: args.seed,
        warm: false,
        mcfs: args.mcfs.options(&task.planner)?,
    };
    let (sender, receiver) = mpsc::channel();
    let begun = now();
    let shared = Arc::clone(task);
    thread::spawn(move || drop(sender.send(planner::plan(&shared.instance(), &options))));
    let answer = match args.time_limit_s.and_then(|limit| Duration::try_from_secs_f64(limit).ok()) {
        Some(limit) => receiver.recv_timeout(limit),
        None => receiver.recv().map_err(|_| mpsc::RecvTimeoutError::Disconnected),
    };
    let planning_s = begun.elapsed().as_secs_f64();
    match answer {
        Ok(plan) => Ok((plan.map_err(|error| task.explain(error))?, planning_s)),
        Err(mpsc::RecvTimeoutError::Timeout) => bail!(
            "`{}` has no plan after {planning_s:.1} s: raise --time-limit-s, or choose larger cells",
            task.planner
        ),
        Err(mpsc::RecvTimeoutError::Disconnected) => bail!("the planner stopped without an answer: our bug"),
    }
}

#[expect(clippy::disallowed_methods, reason = "a command may tell how long it took")]
fn now() -> Instant {
    Instant::now()
}
