//! `oxplow agent`: one robot's process.

use crate::{fleet::FleetArgs, stop};
use ::agent::driver::{Options, run as drive};
use anyhow::Result;
use clap::Args;
use std::{process::ExitCode, time::Duration};

/// Runs one robot's agent
#[derive(Debug, Args)]
#[command(after_help = "Example: oxplow agent --id r1 --connect tcp/127.0.0.1:7447")]
pub struct AgentArgs {
    /// The robot, as the scenario calls it
    #[arg(long, value_parser = crate::fleet::fleet_name)]
    id: String,
    #[command(flatten)]
    fleet: FleetArgs,
    /// Prefix of the bus to the robot's base (iceoryx2); the fleet's name when left out
    #[arg(long, value_name = "PREFIX")]
    base_prefix: Option<String>,
    /// How long to try to reach the coordinator, seconds
    #[arg(long, value_name = "S", default_value_t = 30.0)]
    patience_s: f64,
}

/// Runs the command.
pub fn run(args: &AgentArgs) -> Result<ExitCode> {
    let options = Options {
        id: args.id.clone(),
        fleet: args.fleet.fleet.clone(),
        connect: args.fleet.endpoint(),
        base_prefix: args.base_prefix.clone().unwrap_or_else(|| args.fleet.fleet.clone()),
        patience: Duration::try_from_secs_f64(args.patience_s)?,
    };
    drive(&options, &stop::flag()?)?;
    Ok(ExitCode::SUCCESS)
}
