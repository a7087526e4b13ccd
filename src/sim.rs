//! `oxplow sim`: the world's process.

use crate::{fleet::FleetArgs, stop};
use ::sim::{Scenario, driver};
use anyhow::Result;
use clap::Args;
use std::{path::PathBuf, process::ExitCode, sync::Arc};

/// Runs the simulated world
#[derive(Debug, Args)]
#[command(after_help = "Example: oxplow sim scenarios/office.toml --speed 5")]
pub struct SimArgs {
    /// What is to be simulated
    #[arg(value_name = "SCENARIO.toml")]
    scenario: PathBuf,
    #[command(flatten)]
    fleet: FleetArgs,
    /// How many times faster than the clock the world runs
    #[arg(long, value_name = "K", default_value_t = 1.0, value_parser = speed)]
    speed: f64,
    /// Seed of all noise; the scenario's when left out
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Prefix of the buses to the robots' bases (iceoryx2); the fleet's name when left out
    #[arg(long, value_name = "PREFIX")]
    base_prefix: Option<String>,
}

/// A speed makes sense between a tenth and a hundred.
pub fn speed(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(speed) if (0.1..=100.0).contains(&speed) => Ok(speed),
        _ => Err("a number from 0.1 to 100".to_owned()),
    }
}

/// Runs the command.
pub fn run(args: &SimArgs) -> Result<ExitCode> {
    let scenario = Arc::new(Scenario::load(&args.scenario)?);
    let options = driver::Options {
        seed: args.seed.unwrap_or(scenario.file.mission.seed),
        scenario,
        fleet: args.fleet.fleet.clone(),
        connect: args.fleet.endpoint(),
        base_prefix: args.base_prefix.clone().unwrap_or_else(|| args.fleet.fleet.clone()),
        speed: args.speed,
    };
    driver::run(&options, &stop::flag()?)?;
    Ok(ExitCode::SUCCESS)
}
