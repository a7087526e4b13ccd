//! `oxplow rehearse`: the whole fleet in one thread on a virtual clock, many times faster than the machine's.

use crate::{coordinator::run_info, summary::Report};
use ::coordinator::recorder::{Record, Recorder};
use ::sim::{Options, Outcome, Rehearsal, Scenario, random_faults};
use anyhow::{Context, Result, anyhow, bail};
use clap::Args;
use protocol::Timestamp;
use serde::Serialize;
use std::{
    fs::File,
    io::{BufWriter, Write},
    ops::Range,
    path::{Path, PathBuf},
    process::ExitCode,
    sync::Arc,
    time::{Duration, Instant},
};

/// The log is flushed each 200 ms of virtual time, as in a real run.
const FLUSH_EVERY: Duration = Duration::from_millis(200);

/// Plays a scenario in one thread on a virtual clock, under checkers: same seed, same bytes
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  oxplow rehearse scenarios/demo.toml
  oxplow rehearse scenarios/denver_2.toml --seed 7 --out runs/denver
  oxplow rehearse scenarios/demo.toml --seeds 0..100 --random-faults

Exit codes: 0 completed, 3 gaps left, 1 failed or an invariant broken, 2 usage.")]
pub struct RehearseArgs {
    /// What is to be played
    #[arg(value_name = "SCENARIO.toml")]
    scenario: PathBuf,
    /// Seed of everything that is drawn; the scenario's when left out
    #[arg(long, value_name = "N", conflicts_with = "seeds")]
    seed: Option<u64>,
    /// Several seeds, one line each; the last one is not played
    #[arg(long, value_name = "A..B", value_parser = seeds)]
    seeds: Option<Range<u64>>,
    /// Two to six random faults, drawn from the seed, instead of the scenario's
    #[arg(long)]
    random_faults: bool,
    /// Folder for the log (run.mcap, or seed-N.mcap for several seeds)
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print one JSON object per seed, and no transcript
    #[arg(long)]
    json: bool,
}

fn seeds(text: &str) -> Result<Range<u64>, String> {
    let ends = text.split_once("..").and_then(|(from, to)| Some(from.parse().ok()?..to.parse().ok()?));
    ends.filter(|range| !range.is_empty())
        .ok_or_else(|| format!("`{text}` is no range: expected A..B, A below B"))
}

/// What came of one seed, for scripts. Nothing here depends on the machine.
#[derive(Debug, Serialize)]
struct Summary {
    seed: u64,
    virtual_s: f64,
    contacts: u32,
    faults: u32,
    violations: Vec<String>,
    #[serde(flatten)]
    report: Option<Report>,
}

/// Runs the command.
pub fn run(args: &RehearseArgs) -> Result<ExitCode> {
    let scenario = Scenario::load(&args.scenario)?;
    let Some(seeds) = args.seeds.clone() else {
        let seed = args.seed.unwrap_or(scenario.file.mission.seed);
        let outcome = play(args, &scenario, seed, "run.mcap")?;
        if !args.json {
            write_out(outcome.transcript.text())?;
        }
        let summary = Summary::new(&outcome);
        write_out(&if args.json { summary.to_json() } else { format!("\n{summary}\n") })?;
        return Ok(ExitCode::from(summary.exit_code()));
    };
    let mut worst = 0;
    for seed in seeds {
        let summary = Summary::new(&play(args, &scenario, seed, &format!("seed-{seed}.mcap"))?);
        write_out(&if args.json { summary.to_json() } else { summary.to_line() })?;
        worst = worse(worst, summary.exit_code());
    }
    Ok(ExitCode::from(worst))
}

/// A broken run is worse than one with gaps.
fn worse(a: u8, b: u8) -> u8 {
    if a == 1 || b == 1 { 1 } else { a.max(b) }
}

#[expect(clippy::disallowed_methods, reason = "tells how fast the rehearsal was")]
fn play(args: &RehearseArgs, scenario: &Scenario, seed: u64, log: &str) -> Result<Outcome> {
    let mut scenario = scenario.clone();
    if args.random_faults {
        scenario.file.faults = random_faults(seed, &scenario);
    }
    let scenario = Arc::new(scenario);
    let began = Instant::now();
    let outcome = match &args.out {
        Some(folder) => play_logged(&scenario, seed, folder, log)?,
        None => Rehearsal::run(&scenario, seed, Options::default(), None)?,
    };
    let wall_s = began.elapsed().as_secs_f64();
    let speed = outcome.virtual_s / wall_s;
    eprintln!("seed {seed}: {:.0} s rehearsed in {wall_s:.2} s, {speed:.0} × real time", outcome.virtual_s);
    Ok(outcome)
}

fn play_logged(scenario: &Arc<Scenario>, seed: u64, folder: &Path, log: &str) -> Result<Outcome> {
    let path = folder.join(log);
    if path.exists() {
        bail!("{} is there already: choose another --out", path.display());
    }
    std::fs::create_dir_all(folder).with_context(|| format!("{}: cannot be made", folder.display()))?;
    let file = File::create(&path).with_context(|| format!("{}: cannot be made", path.display()))?;
    let mut recorder = Recorder::new(BufWriter::new(file), &run_info(scenario, seed))?;
    let mut flushed = Timestamp::ZERO;
    let mut trouble = None;
    let mut sink = |now: Timestamp, record: &Record| {
        let mut written = recorder.record(now, record);
        if written.is_ok() && now.since(flushed) >= FLUSH_EVERY {
            flushed = now;
            written = recorder.flush();
        }
        trouble = trouble.take().or(written.err());
    };
    let outcome = Rehearsal::run(scenario, seed, Options::default(), Some(&mut sink))?;
    if let Some(error) = trouble {
        return Err(anyhow!(error).context(path.display().to_string()));
    }
    let mut file = recorder.finish().with_context(|| path.display().to_string())?;
    file.flush().with_context(|| path.display().to_string())?;
    Ok(outcome)
}

impl Summary {
    fn new(outcome: &Outcome) -> Self {
        Self {
            seed: outcome.seed,
            virtual_s: outcome.virtual_s,
            contacts: outcome.contacts,
            faults: outcome.faults,
            violations: outcome.violations.iter().map(ToString::to_string).collect(),
            report: outcome.result.as_ref().map(Report::new),
        }
    }

    fn result(&self) -> &str {
        self.report.as_ref().map_or("NO END", |report| report.result.as_str())
    }

    fn exit_code(&self) -> u8 {
        match self.result() {
            _ if !self.violations.is_empty() => 1,
            "COMPLETED" => 0,
            "COMPLETED_WITH_GAPS" => 3,
            _ => 1,
        }
    }

    fn to_json(&self) -> String {
        serde_json::to_string(self).expect("a summary is plain data") + "\n"
    }

    fn to_line(&self) -> String {
        let broken = self.violations.first().map_or_else(String::new, |first| format!("  broken: {first}"));
        let (seed, time) = (self.seed, self.virtual_s);
        format!("seed {seed}  {}  {time:.0} s  {} faults{broken}\n", self.result(), self.faults)
    }
}

impl std::fmt::Display for Summary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.report {
            Some(report) => write!(f, "{report}")?,
            None => write!(f, "result       none after {:.0} s", self.virtual_s)?,
        }
        write!(f, "\nfaults       {}, contacts {}", self.faults, self.contacts)?;
        for violation in &self.violations {
            write!(f, "\nbroken       {violation}")?;
        }
        Ok(())
    }
}

/// A reader that went away is no reason to fail loudly.
fn write_out(text: &str) -> Result<()> {
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        other => Ok(other?),
    }
}
