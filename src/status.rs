//! `oxplow status`: how a running fleet stands.

use crate::say::say;
use clap::Args;
use protocol::v1;
use std::io::IsTerminal;
use std::process::ExitCode;

/// Shows how a running fleet stands.
#[derive(Debug, Args)]
pub struct StatusArgs {
    /// Print the status as JSON.
    #[arg(long)]
    json: bool,
}

/// Runs the command; `ask` fetches the status from the coordinator.
///
/// # Errors
///
/// What `ask` says.
pub fn run(
    args: &StatusArgs,
    ask: impl FnOnce() -> anyhow::Result<v1::FleetStatus>,
) -> anyhow::Result<ExitCode> {
    let status = ask()?;
    if args.json {
        say!("{}", console::StatusReport::new(&status).to_json());
    } else {
        say!("{}", console::status_text(&status, wants_colour()));
    }
    Ok(ExitCode::SUCCESS)
}

/// Colour is for terminals, and for those who did not set `NO_COLOR`.
fn wants_colour() -> bool {
    std::io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}
