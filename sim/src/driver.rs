//! The world as a process: steps at a fixed rate on the machine's clock (times the speed), serves each robot's base
//! over iceoryx2, shows the truth over zenoh, takes faults, and does to processes what faults ask for.
#![expect(clippy::disallowed_methods, reason = "a driver has clocks and waits")]

use crate::{ProcessAction, STEP, Scenario, World};
use anyhow::{Context, Result, anyhow};
use link::{BodyEnd, Bus, Clock, Endpoint, Urgency, open_client};
use nix::{
    sys::signal::{Signal, kill},
    unistd::Pid,
};
use protocol::{Timestamp, decode, encode, keys, v1};
use std::{
    collections::BTreeMap,
    process::{Child, Command, Stdio},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
        mpsc::{Receiver, sync_channel},
    },
    time::{Duration, Instant},
};
use zenoh::{Session, Wait, query::Query};

/// The world may be so many steps late before it stops catching up.
const LATE_MAX: u32 = 25;
/// How long to try to reach the coordinator.
const PATIENCE: Duration = Duration::from_secs(30);

/// What to run, and whom to talk to.
#[derive(Debug, Clone)]
pub struct Options {
    /// The scenario.
    pub scenario: Arc<Scenario>,
    /// Seed of all noise.
    pub seed: u64,
    /// First part of all keys.
    pub fleet: String,
    /// Where the coordinator listens.
    pub connect: Endpoint,
    /// Prefix of the buses to the robots' bases.
    pub base_prefix: String,
    /// How many times faster than the machine's clock the world runs.
    pub speed: f64,
}

/// What zenoh brings.
enum Event {
    Fault(Query),
    Covered(f64),
}

/// Runs the world until `stop` is set.
///
/// # Errors
///
/// When the coordinator is not reached, or shared memory is not to be had.
pub fn run(options: &Options, stop: &Arc<AtomicBool>) -> Result<()> {
    raise_file_limit(options.scenario.file.robots.len());
    let bus = Bus::join(&options.base_prefix)?;
    let mut world = World::new(&options.scenario, options.seed);
    world.set_time_factor(options.speed);
    let ends = (0..world.robot_count())
        .map(|robot| bus.body_end(world.robot_id(robot)))
        .collect::<Result<Vec<BodyEnd>, _>>()?;
    let session =
        open_client(&options.connect, PATIENCE).context("start the coordinator first, or check --connect")?;
    let (inbox, _declared) = declare(&session, &options.fleet)?;
    let mut driver = Driver {
        pids: vec![None; world.robot_count()],
        world,
        ends,
        bus,
        session: session.clone(),
        options,
        children: BTreeMap::new(),
    };
    driver.run(&inbox, stop);
    driver.end_children();
    let _ = session.close().wait();
    Ok(())
}

/// Each robot takes about 15 files; the limit is raised as far as the system lets us.
fn raise_file_limit(robots: usize) {
    use nix::sys::resource::{Resource, getrlimit, setrlimit};
    let needed = 64 + 20 * robots as u64;
    let Ok((soft, hard)) = getrlimit(Resource::RLIMIT_NOFILE) else { return };
    if soft < needed && setrlimit(Resource::RLIMIT_NOFILE, needed.min(hard), hard).is_err() || hard < needed {
        tracing::warn!(
            needed,
            hard,
            "too few open files are allowed for so many robots: `ulimit -n` must be raised"
        );
    }
}

type Declared = (zenoh::query::Queryable<()>, zenoh::pubsub::Subscriber<()>);

fn declare(session: &Session, fleet: &str) -> Result<(Receiver<Event>, Declared)> {
    let failed = |error: zenoh::Error| anyhow!("zenoh: {error}");
    let (events, inbox) = sync_channel(64);
    let queue = events.clone();
    let faults = session
        .declare_queryable(keys::sim(fleet, "fault"))
        .callback(move |query| drop(queue.try_send(Event::Fault(query))))
        .wait()
        .map_err(failed)?;
    let status = session
        .declare_subscriber(keys::coordinator(fleet, "status"))
        .callback(move |sample| {
            let status: Result<v1::FleetStatus, _> = decode(&sample.payload().to_bytes());
            if let Some(progress) = status.ok().and_then(|status| status.progress) {
                let _ = events.try_send(Event::Covered(progress.covered_percent));
            }
        })
        .wait()
        .map_err(failed)?;
    Ok((inbox, (faults, status)))
}

struct Driver<'a> {
    world: World,
    ends: Vec<BodyEnd>,
    bus: Bus,
    session: Session,
    options: &'a Options,
    /// Process id of each robot's agent, as it told with its setpoints.
    pids: Vec<Option<u32>>,
    /// Agents that a fault made us start.
    children: BTreeMap<String, Child>,
}

impl Driver<'_> {
    fn run(&mut self, inbox: &Receiver<Event>, stop: &Arc<AtomicBool>) {
        let mut clock = Clock::start(self.options.speed);
        let mut due = Timestamp::ZERO;
        let mut told_late = Instant::now();
        while !stop.load(Ordering::Relaxed) {
            due = due + STEP;
            clock.sleep_until(due);
            if clock.now().since(due) > STEP * LATE_MAX {
                if told_late.elapsed() > Duration::from_secs(5) {
                    tracing::warn!(
                        speed = self.options.speed,
                        "the machine is too slow for this speed: time is stretched"
                    );
                    told_late = Instant::now();
                }
                clock = Clock::start(self.options.speed);
                due = Timestamp::ZERO;
            }
            self.take_events(inbox);
            self.take_setpoints();
            self.world.step();
            self.send_states();
            self.show();
            self.act();
        }
    }

    fn take_events(&mut self, inbox: &Receiver<Event>) {
        while let Ok(event) = inbox.try_recv() {
            match event {
                Event::Covered(percent) => self.world.tell_covered(percent),
                Event::Fault(query) => self.take_fault(&query),
            }
        }
    }

    fn take_fault(&mut self, query: &Query) {
        let bytes = query.payload().map(|payload| payload.to_bytes().into_owned()).unwrap_or_default();
        let answer = decode::<v1::FaultCommand>(&bytes)
            .map_err(|error| error.to_string())
            .and_then(|command| self.world.command(&command.toml).map(|()| command.command_id));
        let reply = match answer {
            Ok(command_id) => v1::FaultReply { command_id, accepted: true, reason: String::new() },
            Err(reason) => v1::FaultReply { command_id: 0, accepted: false, reason },
        };
        if let Err(error) = query.reply(query.key_expr().clone(), encode(&reply)).wait() {
            tracing::debug!(%error, "a reply was not sent");
        }
    }

    fn take_setpoints(&mut self) {
        for (robot, end) in self.ends.iter().enumerate() {
            loop {
                match end.receive() {
                    Ok(Some(setpoint)) => {
                        self.pids[robot] = Some(setpoint.pid);
                        self.world.setpoint(robot, &setpoint);
                    }
                    Ok(None) => break,
                    Err(error) => {
                        tracing::warn!(robot = self.world.robot_id(robot), %error, "no setpoints");
                        break;
                    }
                }
            }
        }
    }

    fn send_states(&mut self) {
        for (robot, end) in self.ends.iter().enumerate() {
            let state = self.world.base_state(robot);
            if let Err(error) = end.send(&state) {
                tracing::warn!(robot = self.world.robot_id(robot), %error, "no base state");
            }
        }
    }

    fn show(&mut self) {
        let fleet = &self.options.fleet;
        if let Some(truth) = self.world.take_truth() {
            link::put(&self.session, &keys::sim(fleet, "truth"), encode(&truth), Urgency::Data);
        }
        for contact in self.world.take_contacts() {
            tracing::error!(robot = contact.serial_number, other = contact.other, "contact");
            link::put(&self.session, &keys::sim(fleet, "contacts"), encode(&contact), Urgency::Data);
        }
        for fault in self.world.take_faults() {
            link::put(&self.session, &keys::sim(fleet, "faults"), encode(&fault), Urgency::Data);
        }
    }

    fn act(&mut self) {
        for action in self.world.take_process_actions() {
            let done = match &action {
                ProcessAction::Kill(robot) => self.signal(robot, Signal::SIGKILL),
                ProcessAction::Hang(robot) => self.signal(robot, Signal::SIGSTOP),
                ProcessAction::Thaw(robot) => self.signal(robot, Signal::SIGCONT),
                ProcessAction::Restart(robot) => self.restart(robot),
            };
            if let Err(error) = done {
                tracing::warn!(?action, error = format!("{error:#}"), "a fault could not be carried out");
            }
        }
        self.children.retain(|_, child| matches!(child.try_wait(), Ok(None)));
    }

    fn signal(&self, robot: &str, signal: Signal) -> Result<()> {
        let index = self.world.robot_index(robot).context("no such robot")?;
        let pid = self.pids[index].context("its agent has not been heard of")?;
        if !is_agent_of(pid, robot) {
            anyhow::bail!("process {pid} is not the agent of {robot} (any more)");
        }
        kill(Pid::from_raw(i32::try_from(pid)?), signal).context("the signal was not sent")
    }

    /// Starts the agent of a robot anew, after making sure that the old one is gone.
    fn restart(&mut self, robot: &str) -> Result<()> {
        let _ = self.signal(robot, Signal::SIGKILL);
        self.bus.clean_up();
        let child = Command::new(std::env::current_exe()?)
            .args(["agent", "--id", robot, "--connect", &self.options.connect.locator])
            .args(["--fleet", &self.options.fleet, "--base-prefix", &self.options.base_prefix])
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .spawn()
            .context("the agent was not started")?;
        self.children.insert(robot.to_owned(), child);
        Ok(())
    }

    fn end_children(&mut self) {
        for child in self.children.values_mut() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// Whether a process is our agent for this robot, as its command line says.
fn is_agent_of(pid: u32, robot: &str) -> bool {
    let Ok(command) = std::fs::read(format!("/proc/{pid}/cmdline")) else { return false };
    let words: Vec<&[u8]> = command.split(|&byte| byte == 0).collect();
    words.contains(&b"agent".as_slice()) && words.contains(&robot.as_bytes())
}
