//! `oxplow coordinator`: the process that decides.

use crate::{fleet, stop, summary::Report};
use ::coordinator::{
    Publication,
    driver::{Options, run as coordinate},
    recorder::{MapFile, RunInfo},
};
use ::sim::Scenario;
use anyhow::{Context, Result};
use clap::Args;
use link::Endpoint;
use protocol::{Timestamp, v1::MissionState};
use std::{
    collections::BTreeMap,
    io::Write,
    path::{Path, PathBuf},
    process::ExitCode,
};

/// Runs the coordinator of one mission
#[derive(Debug, Args)]
#[command(after_help = "Example: oxplow coordinator scenarios/office.toml --out runs/today")]
pub struct CoordinatorArgs {
    /// What is to be done
    #[arg(value_name = "SCENARIO.toml")]
    scenario: PathBuf,
    /// Where to listen; port 0 takes a free one
    #[arg(long, value_name = "LOCATOR", default_value = fleet::DEFAULT_LOCATOR)]
    listen: String,
    /// Name of the fleet
    #[arg(long, value_name = "NAME", default_value = fleet::DEFAULT_FLEET, value_parser = fleet::fleet_name)]
    fleet: String,
    /// A zenoh configuration file with further settings (TLS, access control, …)
    #[arg(long, value_name = "FILE.json5")]
    zenoh_config: Option<PathBuf>,
    /// How many times faster than the clock the mission runs: the sim's
    #[arg(long, value_name = "K", default_value_t = 1.0, value_parser = crate::sim::speed)]
    speed: f64,
    /// Folder for the log (run.mcap)
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print progress and result as JSON lines
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &CoordinatorArgs) -> Result<ExitCode> {
    let scenario = Scenario::load(&args.scenario)?;
    let log = args.out.as_deref().map(|folder| log_in(folder, &scenario)).transpose()?;
    let options = Options {
        config: scenario.coordinator_config(1),
        fleet: args.fleet.clone(),
        listen: Endpoint {
            locator: args.listen.clone(),
            config_file: args.zenoh_config.clone(),
            namespace: None,
        },
        speed: args.speed,
        log,
    };
    let json = args.json;
    let colour = fleet::wants_colour(&std::io::stderr());
    let ready = |port: u16| {
        if json {
            print_line(&format!("{{\"listening\":\"tcp/127.0.0.1:{port}\"}}"));
        } else {
            eprintln!("listening on port {port}");
        }
    };
    let state = coordinate(options, &stop::flag()?, ready, |publication| show(publication, json, colour))?;
    Ok(exit_code(state))
}

fn show(publication: &Publication, json: bool, colour: bool) {
    match publication {
        Publication::Event(event) => {
            let at = Timestamp::from_nanos(event.timestamp_ns);
            let line = console::event_line(at, &event.serial_number, &event.event, &event.text, colour);
            let _ = writeln!(std::io::stderr(), "{line}");
        }
        Publication::Status(status) if json => {
            print_line(&console::StatusReport::new(status).to_json().replace('\n', " "));
        }
        Publication::Result(result) => {
            let report = Report::new(result);
            print_line(&if json { report.to_json() } else { report.to_string() });
        }
        _ => {}
    }
}

/// A reader that went away is no reason to end.
fn print_line(line: &str) {
    let _ = writeln!(std::io::stdout(), "{line}");
    let _ = std::io::stdout().flush();
}

/// The log of a run in a folder, which is made.
fn log_in(folder: &Path, scenario: &Scenario) -> Result<(PathBuf, RunInfo)> {
    std::fs::create_dir_all(folder).with_context(|| format!("{}: cannot be made", folder.display()))?;
    Ok((folder.join("run.mcap"), run_info(scenario, scenario.file.mission.seed)))
}

/// What stands at the head of a log.
pub fn run_info(scenario: &Scenario, seed: u64) -> RunInfo {
    let map_file = std::fs::read(&scenario.map_path).ok().map(|bytes| MapFile {
        name: scenario
            .map_path
            .file_name()
            .map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
        bytes,
    });
    RunInfo {
        mission: scenario.coordinator_config(1).mission,
        scenario_toml: scenario.text.clone(),
        map_file,
        seed,
        notes: BTreeMap::new(),
    }
}

/// What the end of a mission means to a script.
pub fn exit_code(state: MissionState) -> ExitCode {
    match state {
        MissionState::Completed => ExitCode::SUCCESS,
        MissionState::CompletedWithGaps => ExitCode::from(3),
        _ => ExitCode::FAILURE,
    }
}
