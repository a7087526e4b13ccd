//! `oxplow fault KIND …`: something goes wrong in a running simulation.

use crate::fleet::FleetArgs;
use crate::say::say;
use ::sim::Fault;
use anyhow::{Result, bail};
use clap::Args;
use protocol::{decode, encode, keys, v1};
use std::process::ExitCode;

/// Injects a fault into a running simulation
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  oxplow fault kill r2
  oxplow fault hang r3 for_s=5
  oxplow fault block x_m=4.0 y_m=2.5 radius_m=0.4 for_s=60
  oxplow fault battery_drop r1 to_percent=15

Kinds and their parameters: docs/scenario.md")]
pub struct FaultArgs {
    /// What goes wrong
    #[arg(value_parser = clap::builder::PossibleValuesParser::new(Fault::KINDS))]
    kind: String,
    /// The robot it befalls, and parameters as KEY=VALUE
    #[arg(value_name = "ROBOT | KEY=VALUE")]
    parameters: Vec<String>,
    #[command(flatten)]
    fleet: FleetArgs,
}

/// Runs the command.
pub fn run(args: &FaultArgs) -> Result<ExitCode> {
    let toml = table(&args.kind, &args.parameters);
    let command = v1::FaultCommand { command_id: u64::from(std::process::id()), toml };
    let bytes = args.fleet.ask(&keys::sim(&args.fleet.fleet, "fault"), encode(&command), "sim")?;
    let reply: v1::FaultReply = decode(&bytes)?;
    if !reply.accepted {
        bail!("refused: {}", reply.reason);
    }
    say!("{} will happen now", args.kind);
    Ok(ExitCode::SUCCESS)
}

/// The fault as the TOML of one `[[fault]]` table.
fn table(kind: &str, parameters: &[String]) -> String {
    let mut lines = vec![format!("kind = {}", quoted(kind))];
    for parameter in parameters {
        match parameter.split_once('=') {
            None => lines.push(format!("robot = {}", quoted(parameter))),
            Some((key, value)) => lines.push(format!("{} = {}", key.trim(), value_of(value.trim()))),
        }
    }
    lines.join("\n")
}

fn value_of(text: &str) -> String {
    let bare = text.parse::<f64>().is_ok() || matches!(text, "true" | "false");
    if bare { text.to_owned() } else { quoted(text) }
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_become_a_table() {
        let parameters = ["r3".to_owned(), "for_s=5".to_owned(), "station=s1".to_owned()];
        assert_eq!(
            table("hang", &parameters),
            "kind = \"hang\"\nrobot = \"r3\"\nfor_s = 5\nstation = \"s1\""
        );
    }
}
