//! `oxplow verify RUN.mcap`: what truly happened, against what was claimed.

use crate::say::say;
use anyhow::Context;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

/// Recomputes coverage, contacts, obstacle entries and battery of a run from its log alone, and compares them with
/// what the coordinator claimed. Exit code 0: it agrees; 3: it agrees and ground is left open; 1: it does not.
#[derive(Debug, Args)]
pub struct VerifyArgs {
    /// The log of a run.
    #[arg(value_name = "RUN.mcap")]
    log: PathBuf,
    /// Print the verdict as JSON.
    #[arg(long)]
    json: bool,
    /// Draw the floor at the end of the run into this file.
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
///
/// When the log cannot be read, or the picture not be written.
pub fn run(args: &VerifyArgs) -> anyhow::Result<ExitCode> {
    let verdict = console::verify_log(&args.log).with_context(|| args.log.display().to_string())?;
    if let Some(path) = &args.svg {
        let svg = console::picture_from_log(&args.log).with_context(|| args.log.display().to_string())?;
        std::fs::write(path, svg).with_context(|| format!("{}: cannot be written", path.display()))?;
    }
    if args.json {
        say!("{}", verdict.to_json());
    } else {
        say!("{verdict}");
    }
    Ok(ExitCode::from(verdict.exit_code()))
}
