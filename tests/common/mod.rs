//! What the tests with processes share.
#![allow(dead_code, reason = "each test file uses a part of it")]
#![allow(clippy::missing_panics_doc, missing_docs, reason = "test support")]

use prost::Message;
use std::{
    fs,
    io::{BufRead, BufReader},
    path::{Path, PathBuf},
    process::{Child, Command, Output, Stdio},
    sync::{Arc, Mutex},
    time::{Duration, Instant},
};

/// A small floor with a wall in the middle.
const MAP: &str = "type octile
height 12
width 20
map
....................
....................
....................
....................
.........@@.........
.........@@.........
.........@@.........
.........@@.........
....................
....................
....................
....................
";

/// A scenario on the small floor; `more` is appended.
pub fn scenario(robots: u32, more: &str) -> String {
    format!(
        "[mission]
id = \"test\"
map = \"floor.map\"
metres_per_character = 0.5
cell_m = 0.5
planner = \"tmstc-star\"

[robot]
body_radius_m = 0.177
tool_width_m = 0.75

[fleet]
count = {robots}
spread = true

{more}"
    )
}

/// Runs the built program to its end.
pub fn oxplow(words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_oxplow"))
        .args(words)
        .env_remove("RUST_LOG")
        .env("RUST_BACKTRACE", "0")
        .stdin(Stdio::null())
        .output()
        .expect("the program starts")
}

/// Lets the processes go on for a while.
#[expect(clippy::disallowed_methods, reason = "a test with processes waits")]
pub fn pause(time: Duration) {
    std::thread::sleep(time);
}

/// A fleet with a name, a folder and a scenario of its own.
pub struct Fleet {
    pub name: String,
    pub scenario: PathBuf,
    folder: tempfile::TempDir,
}

impl Fleet {
    pub fn new(name: &str, scenario: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("scenario.toml");
        fs::write(folder.path().join("floor.map"), MAP).expect("it is writable");
        fs::write(&path, scenario).expect("it is writable");
        Self { name: format!("t-{name}-{}", std::process::id()), scenario: path, folder }
    }

    pub fn out(&self) -> PathBuf {
        self.folder.path().join("out")
    }

    pub fn log(&self) -> PathBuf {
        self.out().join("run.mcap")
    }

    /// `oxplow up`, to its end.
    pub fn up(&self, speed: f64) -> Output {
        let (scenario, out) = (self.scenario.display().to_string(), self.out().display().to_string());
        oxplow(&["up", &scenario, "--out", &out, "--fleet", &self.name, "--speed", &speed.to_string()])
    }

    /// The processes one by one, as a person would start them.
    pub fn start(&self, speed: f64) -> Processes {
        let speed = speed.to_string();
        let scenario = self.scenario.display().to_string();
        let out = self.out().display().to_string();
        let words = ["coordinator", &scenario, "--listen", "tcp/127.0.0.1:0", "--json", "--out", &out];
        let mut coordinator = spawn(&[&words[..], &["--fleet", &self.name, "--speed", &speed]].concat());
        let mut line = String::new();
        let mut stdout = BufReader::new(coordinator.stdout.take().expect("it is piped"));
        stdout.read_line(&mut line).expect("it says where it listens");
        std::thread::spawn(move || stdout.lines().count());
        let said: serde_json::Value = serde_json::from_str(&line).expect("a JSON line");
        let locator = said["listening"].as_str().expect("a locator").to_owned();
        let events = Arc::new(Mutex::new(String::new()));
        let (sink, stderr) = (Arc::clone(&events), coordinator.stderr.take().expect("it is piped"));
        std::thread::spawn(move || {
            for line in BufReader::new(stderr).lines().map_while(Result::ok) {
                sink.lock().expect("no panic").push_str(&(line + "\n"));
            }
        });
        let mut children = vec![coordinator];
        let joined = ["--connect", &locator, "--fleet", &self.name, "--base-prefix", &self.name];
        children.push(spawn(&[&["sim", &scenario, "--speed", &speed], &joined[..]].concat()));
        for robot in 1..=robots_in(&self.scenario) {
            let id = format!("r{robot}");
            children.push(spawn(&[&["agent", "--id", &id], &joined[..]].concat()));
        }
        for child in children.iter_mut().skip(1) {
            let (stdout, stderr) = (child.stdout.take(), child.stderr.take());
            std::thread::spawn(move || stdout.map(|stream| BufReader::new(stream).lines().count()));
            std::thread::spawn(move || stderr.map(|stream| BufReader::new(stream).lines().count()));
        }
        Processes { children, locator, events, base_prefix: self.name.clone() }
    }
}

fn robots_in(scenario: &Path) -> u32 {
    let text = fs::read_to_string(scenario).expect("it was written");
    let count = text.lines().find_map(|line| line.strip_prefix("count = ")).expect("it has a count");
    count.parse().expect("a number")
}

fn spawn(words: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_oxplow"))
        .args(words)
        .env("RUST_BACKTRACE", "0")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts")
}

/// Processes that are ended, by their pid, when this is dropped.
pub struct Processes {
    children: Vec<Child>,
    pub locator: String,
    events: Arc<Mutex<String>>,
    base_prefix: String,
}

impl Processes {
    /// SIGKILL.
    pub fn kill_coordinator(&mut self) {
        self.children[0].kill().expect("it runs");
        self.children[0].wait().expect("it is our child");
    }

    /// Waits until the coordinator has ended by itself; its exit code.
    #[expect(clippy::disallowed_methods, reason = "a test with processes waits")]
    pub fn coordinator_ends(&mut self) -> Option<i32> {
        let begun = Instant::now();
        while begun.elapsed() < Duration::from_secs(20) {
            if let Ok(Some(status)) = self.children[0].try_wait() {
                return status.code();
            }
            pause(Duration::from_millis(50));
        }
        panic!("the coordinator goes on");
    }

    /// Waits until the coordinator's log has a word.
    #[expect(clippy::disallowed_methods, reason = "a test with processes waits")]
    pub fn wait_for(&self, word: &str) {
        let begun = Instant::now();
        while begun.elapsed() < Duration::from_secs(40) {
            if self.events.lock().expect("no panic").contains(word) {
                return;
            }
            pause(Duration::from_millis(50));
        }
        panic!("no {word} in\n{}", self.events.lock().expect("no panic"));
    }
}

impl Drop for Processes {
    fn drop(&mut self) {
        for child in &mut self.children {
            let _ = child.kill();
            let _ = child.wait();
        }
        link::remove_left_behind(&self.base_prefix);
    }
}

/// What a test wants to know of a log.
#[derive(Default)]
pub struct Log {
    pub messages: usize,
    pub last_s: f64,
    faults: Vec<(f64, String)>,
    /// When an order went out, and its plan.
    orders: Vec<(f64, u64)>,
}

impl Log {
    pub fn read(path: &Path) -> Self {
        let bytes = fs::read(path).expect("there is a log");
        let options = mcap::read::Options::IgnoreEndMagic;
        let stream = mcap::MessageStream::new_with_options(&bytes, options.into()).expect("an MCAP file");
        let mut log = Self::default();
        for message in stream.map_while(Result::ok) {
            let at_s = message.log_time.saturating_sub(protocol::LOG_EPOCH_NS) as f64 / 1e9;
            log.messages += 1;
            log.last_s = log.last_s.max(at_s);
            let topic = message.channel.topic.as_str();
            if topic == "/fleet/faults" {
                let fault = protocol::v1::FaultInjected::decode(&*message.data).expect("a fault");
                log.faults.push((at_s, fault.kind));
            } else if topic.ends_with("/order") {
                let order = protocol::v1::Order::decode(&*message.data).expect("an order");
                log.orders.push((at_s, order.plan_revision));
            }
        }
        log
    }

    /// Seconds from the first fault of a kind to the first order of a newer plan.
    pub fn order_changed_after(&self, kind: &str) -> Option<f64> {
        let (fault_s, _) = self.faults.iter().find(|(_, name)| name == kind)?;
        let before = self.orders.iter().filter(|(at_s, _)| at_s < fault_s).map(|&(_, plan)| plan).max()?;
        let changed = self.orders.iter().find(|&&(at_s, plan)| at_s >= *fault_s && plan > before)?;
        Some(changed.0 - fault_s)
    }
}

/// Lets the PyPI readers judge a log; says so when they are not there.
pub fn python_reads(log: &Path, more: &[&str]) {
    const NOT_THERE: i32 = 77;
    let python = std::env::var("OXPLOW_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/read_mcap.py");
    let output = Command::new(&python).arg(script).args(more).arg(log).output();
    match output {
        Ok(output) if output.status.code() == Some(NOT_THERE) => {
            println!("skipped: {python} has no mcap and mcap-protobuf-support");
        }
        Ok(output) => {
            let (out, err) =
                (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
            assert!(output.status.success(), "{out}{err}");
        }
        Err(error) => println!("skipped: {python} does not start: {error}"),
    }
}
