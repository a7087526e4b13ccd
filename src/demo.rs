//! `oxplow demo`: the front door. A fleet covers a real floor, loses a robot, finds a way blocked, and finishes.

use crate::say::say;
use crate::up::{self, UpArgs};
use anyhow::{Context, Result};
use clap::Args;
use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

const SCENARIO: &str = include_str!("../scenarios/demo.toml");
const MAP: &str = include_str!("../maps/demo.map");

/// Shows what it does: covers a floor, kills a robot, blocks a way, replans, proves the result
#[derive(Debug, Args)]
#[command(after_help = "Example: oxplow demo --robots 4 --speed 8")]
pub struct DemoArgs {
    /// How many robots
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u8).range(2..=12))]
    robots: u8,
    /// How many times faster than the clock the world runs
    #[arg(long, value_name = "K", default_value_t = 8.0, value_parser = crate::sim::speed)]
    speed: f64,
    /// Seed of all noise
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Folder for scenario, log and picture; must not hold a run yet
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &DemoArgs) -> Result<ExitCode> {
    let out = args.out.clone().unwrap_or_else(default_out);
    let scenario = lay_out(&out, args.robots)?;
    let up = UpArgs {
        scenario,
        speed: args.speed,
        out: Some(out.clone()),
        listen: "tcp/127.0.0.1:0".to_owned(),
        fleet: "demo".to_owned(),
        seed: Some(args.seed),
        json: false,
    };
    let report = up::run_fleet(&up, &out)?;
    up::print_report(&report, false, &out);
    let log = out.join("run.mcap");
    let verdict = console::verify_log(&log).with_context(|| log.display().to_string())?;
    say!("\nRecounted from the log alone (oxplow verify {}):\n{verdict}", log.display());
    let agrees = verdict.exit_code() == 0;
    Ok(if agrees { up::exit_code(&report) } else { ExitCode::from(verdict.exit_code()) })
}

/// Writes scenario and map into the folder of the run.
fn lay_out(out: &Path, robots: u8) -> Result<PathBuf> {
    std::fs::create_dir_all(out).with_context(|| format!("{}: cannot be made", out.display()))?;
    let text =
        SCENARIO.replace("../maps/demo.map", "demo.map").replace("count = 4", &format!("count = {robots}"));
    let path = out.join("scenario.toml");
    std::fs::write(&path, text).with_context(|| path.display().to_string())?;
    std::fs::write(out.join("demo.map"), MAP)?;
    Ok(path)
}

#[expect(clippy::disallowed_methods, reason = "a folder's name may tell when it was made")]
fn default_out() -> PathBuf {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
    PathBuf::from("runs").join(format!("demo-{}", since.as_secs()))
}
