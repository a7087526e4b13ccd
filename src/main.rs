//! The `oxplow` command: thin; parses, calls a crate, prints.
#![expect(clippy::print_stderr, reason = "a command line prints")]

mod agent;
mod bench;
mod coordinator;
mod demo;
mod fault;
mod fleet;
mod operator;
mod plan;
mod rehearse;
mod say;
mod sim;
mod status;
mod stop;
mod summary;
mod up;
mod verify;

use clap::{Parser, Subcommand};
use std::process::ExitCode;
use tracing_subscriber::EnvFilter;

/// Exit code when the coordinator (or the sim) is not reached.
const NOT_REACHED: u8 = 5;

/// A coverage fleet coordinator: covers a floor with many robots, replans when robots fail, and proves what was
/// covered.
#[derive(Debug, Parser)]
#[command(
    version,
    propagate_version = true,
    after_help = "Examples:
  oxplow demo                              a fleet covers a floor, loses a robot, finishes
  oxplow up scenarios/office.toml          sim, coordinator and agents on this machine
  oxplow rehearse scenarios/demo.toml      the same in one thread, a thousand times faster
  oxplow verify runs/…/run.mcap            recount what was covered from the log alone

Exit codes: 0 completed, 1 error, 2 usage, 3 gaps left, 5 coordinator not reached."
)]
struct Cli {
    /// More of the log: -v decisions, -vv every message. `RUST_LOG` wins.
    #[arg(short, long, action = clap::ArgAction::Count, global = true)]
    verbose: u8,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Demo(demo::DemoArgs),
    Up(up::UpArgs),
    Rehearse(rehearse::RehearseArgs),
    Sim(sim::SimArgs),
    Coordinator(coordinator::CoordinatorArgs),
    Agent(agent::AgentArgs),
    Fault(fault::FaultArgs),
    Status(operator::StatusCommand),
    /// Stops all robots where they are; `resume` goes on
    Pause(fleet::FleetArgs),
    /// Goes on after a pause
    Resume(fleet::FleetArgs),
    /// Ends the mission
    Cancel(fleet::FleetArgs),
    Plan(plan::PlanArgs),
    Bench(bench::BenchArgs),
    Verify(verify::VerifyArgs),
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    start_logging(cli.verbose);
    let outcome = match &cli.command {
        Command::Demo(args) => demo::run(args),
        Command::Up(args) => up::run(args),
        Command::Rehearse(args) => rehearse::run(args),
        Command::Sim(args) => sim::run(args),
        Command::Coordinator(args) => coordinator::run(args),
        Command::Agent(args) => agent::run(args),
        Command::Fault(args) => fault::run(args),
        Command::Status(args) => operator::status(args),
        Command::Pause(args) => operator::command(args, protocol::v1::Verb::Pause),
        Command::Resume(args) => operator::command(args, protocol::v1::Verb::Resume),
        Command::Cancel(args) => operator::command(args, protocol::v1::Verb::Cancel),
        Command::Plan(args) => plan::run(args),
        Command::Bench(args) => bench::run(args),
        Command::Verify(args) => verify::run(args),
    };
    outcome.unwrap_or_else(|error| {
        eprintln!("error: {error:#}");
        if error.is::<fleet::NotReached>() { ExitCode::from(NOT_REACHED) } else { ExitCode::FAILURE }
    })
}

fn start_logging(verbose: u8) {
    let level = match verbose {
        0 => "warn,oxplow=info",
        1 => "info,zenoh=warn,zenoh_transport=warn,oxplow=debug,coordinator=debug,agent=debug,sim=debug",
        _ => "debug,oxplow=trace,coordinator=trace,agent=trace,sim=trace",
    };
    let quiet = "zenoh=off,zenoh_transport=off,zenoh_link_tcp=off,zenoh_config=off";
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| {
        EnvFilter::new(if verbose == 0 { format!("{level},{quiet}") } else { level.to_owned() })
    });
    let _ = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_ansi(fleet::wants_colour(&std::io::stderr()))
        .without_time()
        .with_target(false)
        .try_init();
}
