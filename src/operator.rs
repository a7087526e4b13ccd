//! `oxplow status`, `pause`, `resume`, `cancel`: a person and a running fleet.

use crate::say::say;
use crate::{fleet::FleetArgs, status};
use anyhow::{Result, bail};
use clap::Args;
use protocol::{decode, encode, keys, v1};
use std::process::ExitCode;

/// Shows how a running fleet stands
#[derive(Debug, Args)]
#[command(after_help = "Example: oxplow status --json")]
pub struct StatusCommand {
    #[command(flatten)]
    fleet: FleetArgs,
    #[command(flatten)]
    status: status::StatusArgs,
}

/// Runs `oxplow status`.
pub fn status(args: &StatusCommand) -> Result<ExitCode> {
    status::run(&args.status, || {
        let bytes = args.fleet.ask(&keys::query(&args.fleet.fleet, "status"), Vec::new(), "coordinator")?;
        Ok(decode(&bytes)?)
    })
}

/// Asks the coordinator to pause, resume or cancel.
pub fn command(args: &FleetArgs, verb: v1::Verb) -> Result<ExitCode> {
    let command = v1::OperatorCommand {
        command_id: u64::from(std::process::id()) << 16 | 1,
        verb: verb.into(),
        serial_number: String::new(),
        who: std::env::var("USER").unwrap_or_else(|_| "operator".to_owned()),
    };
    let bytes = args.ask(&keys::operator(&args.fleet), encode(&command), "coordinator")?;
    let reply: v1::OperatorReply = decode(&bytes)?;
    if !reply.accepted {
        bail!("refused: {}", reply.reason);
    }
    say!("{}", reply.reason);
    Ok(ExitCode::SUCCESS)
}
