//! `oxplow up`: sim, coordinator and agents as child processes of this one.

use crate::say::say;
use crate::{fleet, stop, summary::Report};
use ::sim::Scenario;
use anyhow::{Context, Result, bail};
use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use nix::{
    sys::signal::{Signal, kill},
    unistd::Pid,
};
use serde::Deserialize;
use std::{
    io::IsTerminal,
    path::{Path, PathBuf},
    process::{ExitCode, Stdio},
    time::{Duration, Instant},
};
use tokio::{
    io::{AsyncBufReadExt, AsyncRead, BufReader},
    process::{Child, Command},
    sync::mpsc,
    task::JoinHandle,
};

/// Children that were asked to end are ended after this.
const GRACE: Duration = Duration::from_secs(2);

/// Runs a scenario: sim, coordinator and agents as processes on this machine
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  oxplow up scenarios/office.toml
  oxplow up scenarios/warehouse.toml --speed 5 --out runs/warehouse

Exit codes: 0 completed, 3 gaps left, 1 error. While it runs: oxplow status, fault, pause, resume, cancel.")]
pub struct UpArgs {
    /// What is to be done, and by whom
    #[arg(value_name = "SCENARIO.toml")]
    pub scenario: PathBuf,
    /// How many times faster than the clock the world runs
    #[arg(long, value_name = "K", default_value_t = 1.0, value_parser = crate::sim::speed)]
    pub speed: f64,
    /// Folder for the log and the picture; must not hold a run yet
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Where the coordinator listens; port 0 takes a free one
    #[arg(long, value_name = "LOCATOR", default_value = "tcp/127.0.0.1:0")]
    pub listen: String,
    /// Name of the fleet
    #[arg(long, value_name = "NAME", default_value = fleet::DEFAULT_FLEET, value_parser = fleet::fleet_name)]
    pub fleet: String,
    /// Seed of all noise; the scenario's when left out
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
pub fn run(args: &UpArgs) -> Result<ExitCode> {
    let out = args.out.clone().unwrap_or_else(|| default_out(&args.scenario));
    let report = run_fleet(args, &out)?;
    print_report(&report, args.json, &out);
    Ok(exit_code(&report))
}

/// What the end of a run means to a script.
pub fn exit_code(report: &Report) -> ExitCode {
    match report.result.as_str() {
        "COMPLETED" => ExitCode::SUCCESS,
        "COMPLETED_WITH_GAPS" => ExitCode::from(3),
        _ => ExitCode::FAILURE,
    }
}

/// Prints the end of a run, and where its files are.
pub fn print_report(report: &Report, json: bool, out: &Path) {
    if json {
        say!("{}", report.to_json());
        return;
    }
    say!("\n{report}");
    say!("log          {}", out.join("run.mcap").display());
    say!("picture      {}", out.join("coverage.svg").display());
}

/// Where a run goes when nothing is said: a folder of its own for each.
#[expect(clippy::disallowed_methods, reason = "a folder's name may tell when it was made")]
fn default_out(scenario: &Path) -> PathBuf {
    let name = scenario.file_stem().map_or_else(|| "run".into(), |stem| stem.to_string_lossy().into_owned());
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
    PathBuf::from("runs").join(format!("{name}-{}", since.as_secs()))
}

/// Runs a whole fleet to the end of its mission; the log and the picture are in `out` then.
pub fn run_fleet(args: &UpArgs, out: &Path) -> Result<Report> {
    let scenario = Scenario::load(&args.scenario)?;
    if out.join("run.mcap").exists() {
        bail!("{} holds a run already: choose another --out", out.display());
    }
    std::fs::create_dir_all(out).with_context(|| format!("{}: cannot be made", out.display()))?;
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_all().build()?;
    let report = runtime.block_on(supervise(args, &scenario, out))?;
    let log = out.join("run.mcap");
    let svg = console::picture_from_log(&log).with_context(|| log.display().to_string())?;
    std::fs::write(out.join("coverage.svg"), svg)?;
    Ok(report)
}

/// A line on the coordinator's standard output.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Line {
    Listening { listening: String },
    End(Report),
    Status { progress: Progress },
}

#[derive(Debug, Deserialize)]
struct Progress {
    covered_percent: f64,
    remaining_s: f64,
}

/// What the supervisor is told.
enum News {
    Line(String),
    Log(String),
    Ended { name: String, status: String, ok: bool },
}

/// A fleet of child processes. Each is reaped by a task of its own as soon as it ends.
struct Children {
    news: mpsc::Sender<News>,
    pids: Vec<(String, i32)>,
    reapers: Vec<JoinHandle<()>>,
}

async fn supervise(args: &UpArgs, scenario: &Scenario, out: &Path) -> Result<Report> {
    let (news, mut inbox) = mpsc::channel(1024);
    let mut children = Children { news, pids: Vec::new(), reapers: Vec::new() };
    let outcome = tokio::select! {
        outcome = watch(args, scenario, out, &mut children, &mut inbox) => outcome,
        () = stop::asked() => Err(anyhow::anyhow!("interrupted; the log up to here is in {}", out.display())),
    };
    children.end_all().await;
    link::remove_left_behind(&base_prefix(&args.fleet));
    outcome
}

/// The buses of a run have a prefix of their own, so that runs on one machine do not meet.
fn base_prefix(fleet: &str) -> String {
    format!("{fleet}-{}", std::process::id())
}

async fn watch(
    args: &UpArgs,
    scenario: &Scenario,
    out: &Path,
    children: &mut Children,
    inbox: &mut mpsc::Receiver<News>,
) -> Result<Report> {
    let bar = progress_bar();
    let mut told = now();
    let mut report: Option<Report> = None;
    let mut last_words: Vec<String> = Vec::new();
    children.start_coordinator(args, out)?;
    while let Some(news) = inbox.recv().await {
        match news {
            News::Line(line) => match serde_json::from_str(&line) {
                Ok(Line::Listening { listening }) => {
                    bar.println(format!(
                        "coordinator listens on {listening} (oxplow status --connect {listening})"
                    ));
                    children.start_rest(args, scenario, &listening)?;
                }
                Ok(Line::Status { progress }) => show_progress(&bar, &progress, &mut told),
                Ok(Line::End(end)) => report = Some(end),
                Err(_) => bar.println(line),
            },
            News::Log(line) => {
                last_words.push(line.clone());
                let surplus = last_words.len().saturating_sub(8);
                last_words.drain(..surplus);
                say(&bar, &line);
            }
            News::Ended { name, status, ok } if name == "coordinator" => {
                bar.finish_and_clear();
                return report.ok_or_else(|| {
                    let hint = if ok { "" } else { "; its last words are above" };
                    anyhow::anyhow!("the coordinator ended before the mission ({status}){hint}")
                });
            }
            News::Ended { name, status, .. } if name == "sim" && report.is_none() => {
                bail!("the sim ended before the mission ({status}): {}", last_words.join(" | "));
            }
            News::Ended { name, status, .. } => {
                if report.is_none() {
                    say(&bar, &format!("the agent of {name} ended ({status})"));
                }
            }
        }
    }
    bail!("all processes ended")
}

fn progress_bar() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(1000), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("[{elapsed}] {bar:40} {msg}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}

/// Above the bar on a terminal, plainly elsewhere.
fn say(bar: &ProgressBar, line: &str) {
    if std::io::stderr().is_terminal() {
        bar.println(line);
    } else {
        eprintln!("{line}");
    }
}

fn show_progress(bar: &ProgressBar, progress: &Progress, told: &mut Instant) {
    let text = format!("{:.1} % covered, {:.0} s to go", progress.covered_percent, progress.remaining_s);
    if std::io::stderr().is_terminal() {
        bar.set_position((progress.covered_percent * 10.0) as u64);
        bar.set_message(text);
    } else if told.elapsed() > Duration::from_secs(5) {
        *told = now();
        eprintln!("              {text}");
    }
}

#[expect(clippy::disallowed_methods, reason = "the supervisor is a driver")]
fn now() -> Instant {
    Instant::now()
}

impl Children {
    fn start_coordinator(&mut self, args: &UpArgs, out: &Path) -> Result<()> {
        let mut command = own_command("coordinator")?;
        command
            .arg(&args.scenario)
            .args(["--listen", &args.listen, "--fleet", &args.fleet, "--json"])
            .args(["--speed", &args.speed.to_string()])
            .arg("--out")
            .arg(out);
        self.start("coordinator", command)
    }

    /// The sim and the agents, once the coordinator listens.
    fn start_rest(&mut self, args: &UpArgs, scenario: &Scenario, locator: &str) -> Result<()> {
        let prefix = base_prefix(&args.fleet);
        let mut sim = own_command("sim")?;
        sim.arg(&args.scenario)
            .args(["--connect", locator, "--fleet", &args.fleet, "--base-prefix", &prefix])
            .args(["--speed", &args.speed.to_string()]);
        if let Some(seed) = args.seed {
            sim.args(["--seed", &seed.to_string()]);
        }
        self.start("sim", sim)?;
        for robot in &scenario.file.robots {
            let mut agent = own_command("agent")?;
            agent.args(["--id", &robot.id, "--connect", locator]).args([
                "--fleet",
                &args.fleet,
                "--base-prefix",
                &prefix,
            ]);
            self.start(&robot.id, agent)?;
        }
        Ok(())
    }

    fn start(&mut self, name: &str, mut command: Command) -> Result<()> {
        let mut child = command
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .kill_on_drop(true)
            .spawn()
            .with_context(|| format!("{name} was not started"))?;
        if let Some(pid) = child.id().and_then(|pid| i32::try_from(pid).ok()) {
            self.pids.push((name.to_owned(), pid));
        }
        let readers = [
            child.stdout.take().map(|stream| self.read(stream, News::Line)),
            child.stderr.take().map(|stream| self.read(stream, News::Log)),
        ];
        self.reapers.push(tokio::spawn(reap(name.to_owned(), child, readers, self.news.clone())));
        Ok(())
    }

    fn read(
        &self,
        stream: impl AsyncRead + Unpin + Send + 'static,
        news: impl Fn(String) -> News + Send + 'static,
    ) -> JoinHandle<()> {
        let sender = self.news.clone();
        tokio::spawn(async move {
            let mut lines = BufReader::new(stream).lines();
            while let Ok(Some(line)) = lines.next_line().await {
                if sender.send(news(line)).await.is_err() {
                    break;
                }
            }
        })
    }

    /// Asks all to end, and ends those that do not.
    async fn end_all(mut self) {
        for signal in [Signal::SIGTERM, Signal::SIGCONT] {
            self.signal_all(signal);
        }
        let _ = tokio::time::timeout(GRACE, async {
            for reaper in &mut self.reapers {
                let _ = reaper.await;
            }
        })
        .await;
        self.signal_all(Signal::SIGKILL);
        for reaper in self.reapers {
            if !reaper.is_finished() {
                let _ = tokio::time::timeout(GRACE, reaper).await;
            }
        }
    }

    /// Only to children that have not been reaped: their pid is still theirs.
    fn signal_all(&self, signal: Signal) {
        for ((_, pid), reaper) in self.pids.iter().zip(&self.reapers) {
            if !reaper.is_finished() {
                let _ = kill(Pid::from_raw(*pid), signal);
            }
        }
    }
}

async fn reap(
    name: String,
    mut child: Child,
    readers: [Option<JoinHandle<()>>; 2],
    news: mpsc::Sender<News>,
) {
    let status = child.wait().await;
    for reader in readers.into_iter().flatten() {
        let _ = reader.await;
    }
    let (status, ok) = match status {
        Ok(status) => (status.to_string(), status.success()),
        Err(error) => (error.to_string(), false),
    };
    let _ = news.try_send(News::Ended { name, status, ok });
}

fn own_command(subcommand: &str) -> Result<Command> {
    let executable = std::env::current_exe().context("the path of this program is not known")?;
    let mut command = Command::new(executable);
    command.arg(subcommand);
    // One worker thread for all of zenoh's queues: measured as enough, and half the threads.
    command.env(
        "ZENOH_RUNTIME",
        "(rx:(handover:app),acc:(handover:app),tx:(handover:app),net:(handover:app),app:(worker_threads:1))",
    );
    Ok(command)
}
