//! The coordinator as a process: zenoh's router, the machine's clock, the log.
//!
//! ```text
//!   zenoh callbacks ──▶ bounded queue ──▶ one loop: Coordinator::handle ──▶ puts (Drop)
//!                                            │    ▲                     └─▶ bounded queue ──▶ log thread (MCAP)
//!                                            ▼    │
//!                                       planner thread            replies thread ◀── queries
//! ```
//!
//! The loop never waits for anybody: planning, logging and replying have threads of their own, and every put drops
//! what a slow receiver does not take.
#![expect(clippy::disallowed_methods, reason = "a driver has clocks and waits")]

mod log_thread;

use crate::{
    Config, Coordinator, Input, Output, Publication,
    recorder::{Record, RunInfo},
};
use anyhow::{Context, Result, anyhow};
use link::{Clock, Endpoint, Urgency, bound_port, open_router};
use log_thread::LogThread;
use protocol::{
    Bounds, Timestamp, Validate, decode, encode, keys,
    v1::{self, MissionState},
};
use std::{
    collections::BTreeMap,
    path::PathBuf,
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, AtomicU64, Ordering},
        mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel},
    },
    time::Duration,
};
use zenoh::{Session, Wait, query::Query, sample::SampleKind};

/// Messages that wait for the loop; beyond that they are dropped and counted.
const QUEUE: usize = 8192;
/// The log goes on for so long after the end of the mission, seconds on the machine's clock.
const LINGER: Duration = Duration::from_millis(700);

/// What to run.
pub struct Options {
    /// The mission and its thresholds, in mission time.
    pub config: Config,
    /// Name of the fleet: first part of all keys.
    pub fleet: String,
    /// Where to listen.
    pub listen: Endpoint,
    /// How many times faster than the machine's clock the mission runs.
    pub speed: f64,
    /// The log to be written, if any.
    pub log: Option<(PathBuf, RunInfo)>,
}

/// What the loop is told.
enum Event {
    Message { noun: &'static str, robot: String, bytes: Vec<u8> },
    Token { robot: String, boot_id: u64, alive: bool },
    Operator(Query),
    Sim { noun: &'static str, bytes: Vec<u8> },
    Input(Box<Input>),
}

/// Runs a mission to its end, or until `stop` is set. `ready` is told the port that is listened on, `watch` all that
/// is published.
///
/// # Errors
///
/// When the port is taken, the log cannot be written, or the robots fit nowhere on the map.
pub fn run(
    mut options: Options,
    stop: &Arc<AtomicBool>,
    ready: impl FnOnce(u16),
    watch: impl FnMut(&Publication),
) -> Result<MissionState> {
    stretch_timing(&mut options);
    let core = Coordinator::new(options.config.clone())?;
    let session = open_router(&options.listen)?;
    let (events, inbox) = sync_channel(QUEUE);
    let dropped = Arc::new(AtomicU64::new(0));
    let snapshot = Arc::new(Mutex::new(Vec::new()));
    let _declared = declare(&session, &options, &events, &dropped, &snapshot)?;
    let log = options.log.take().map(|(path, run)| LogThread::start(&path, &run)).transpose()?;
    ready(bound_port(&session).unwrap_or_default());
    let bounds = bounds_of(&options.config);
    let mut driver = Driver {
        core,
        fleet: options.fleet,
        session: session.clone(),
        clock: Clock::start(options.speed),
        log,
        events,
        queries: BTreeMap::new(),
        snapshot,
        bounds,
        dropped,
        stats: v1::TransportStats::default(),
        headers: BTreeMap::new(),
        next_stats: Timestamp::ZERO,
        watch,
    };
    let state = driver.run(&inbox, stop);
    driver.finish()?;
    let _ = session.close().wait();
    Ok(state)
}

/// Time-outs of communication stay what they are on the machine's clock, however fast the mission runs.
fn stretch_timing(options: &mut Options) {
    let factor = options.speed.max(1.0);
    let timing = &mut options.config.timing;
    for limit in [
        &mut timing.suspect_after_s,
        &mut timing.lost_after_s,
        &mut timing.lease_s,
        &mut timing.join_timeout_s,
        &mut timing.muster_s,
    ] {
        *limit *= factor;
    }
}

fn bounds_of(config: &Config) -> Bounds {
    let (low, high) = (config.mission.map.origin(), config.mission.map.corner());
    Bounds { x_min: low.x - 10.0, y_min: low.y - 10.0, x_max: high.x + 10.0, y_max: high.y + 10.0 }
}

/// What keeps the declarations of the session alive.
struct Declared {
    _subscribers: Vec<zenoh::pubsub::Subscriber<()>>,
    _queryables: Vec<zenoh::query::Queryable<()>>,
    _token: zenoh::liveliness::LivelinessToken,
}

fn declare(
    session: &Session,
    options: &Options,
    events: &SyncSender<Event>,
    dropped: &Arc<AtomicU64>,
    snapshot: &Arc<Mutex<Vec<u8>>>,
) -> Result<Declared> {
    let failed = |error: zenoh::Error| anyhow!("zenoh: {error}");
    let fleet = &options.fleet;
    let mut subscribers = Vec::new();
    for &noun in keys::UP {
        let queue = Queue::new(events, dropped);
        let subscriber = session.declare_subscriber(keys::all_robots(fleet, noun)).callback(move |sample| {
            if let Some((robot, _)) = keys::parse_robot(sample.key_expr().as_str()) {
                let bytes = sample.payload().to_bytes().into_owned();
                queue.push(Event::Message { noun, robot: robot.to_owned(), bytes });
            }
        });
        subscribers.push(subscriber.wait().map_err(failed)?);
    }
    for noun in ["truth", "contacts", "faults"] {
        let queue = Queue::new(events, dropped);
        let subscriber = session.declare_subscriber(keys::sim(fleet, noun)).callback(move |sample| {
            queue.push(Event::Sim { noun, bytes: sample.payload().to_bytes().into_owned() });
        });
        subscribers.push(subscriber.wait().map_err(failed)?);
    }
    let queue = Queue::new(events, dropped);
    let tokens = session.liveliness().declare_subscriber(keys::all_alive(fleet)).history(true).callback(
        move |sample| {
            if let Some((robot, boot_id)) = keys::parse_alive(sample.key_expr().as_str()) {
                let alive = sample.kind() == SampleKind::Put;
                queue.push(Event::Token { robot: robot.to_owned(), boot_id, alive });
            }
        },
    );
    subscribers.push(tokens.wait().map_err(failed)?);
    let queue = Queue::new(events, dropped);
    let operator = session
        .declare_queryable(keys::operator(fleet))
        .callback(move |query| queue.push(Event::Operator(query)))
        .wait()
        .map_err(failed)?;
    let shared = Arc::clone(snapshot);
    let status = session
        .declare_queryable(keys::query(fleet, "status"))
        .callback(move |query| {
            let bytes = shared.lock().map(|bytes| bytes.clone()).unwrap_or_default();
            reply_aside(query, bytes);
        })
        .wait()
        .map_err(failed)?;
    let token = session
        .liveliness()
        .declare_token(keys::coordinator_alive(fleet, options.config.term))
        .wait()
        .map_err(failed)?;
    Ok(Declared { _subscribers: subscribers, _queryables: vec![operator, status], _token: token })
}

/// Replies block for a moment when the asker is slow: a thread of their own does it.
fn reply_aside(query: Query, bytes: Vec<u8>) {
    std::thread::spawn(move || {
        let key = query.key_expr().clone();
        if let Err(error) = query.reply(key, bytes).wait() {
            tracing::debug!(%error, "a reply was not sent");
        }
    });
}

/// The way into the loop, which drops and counts what does not fit.
struct Queue {
    events: SyncSender<Event>,
    dropped: Arc<AtomicU64>,
}

impl Queue {
    fn new(events: &SyncSender<Event>, dropped: &Arc<AtomicU64>) -> Self {
        Self { events: events.clone(), dropped: Arc::clone(dropped) }
    }

    fn push(&self, event: Event) {
        if self.events.try_send(event).is_err() {
            self.dropped.fetch_add(1, Ordering::Relaxed);
        }
    }
}

struct Driver<W> {
    core: Coordinator,
    fleet: String,
    session: Session,
    clock: Clock,
    log: Option<LogThread>,
    events: SyncSender<Event>,
    /// Operators' queries that wait for their reply, by command.
    queries: BTreeMap<u64, Query>,
    snapshot: Arc<Mutex<Vec<u8>>>,
    bounds: Bounds,
    dropped: Arc<AtomicU64>,
    stats: v1::TransportStats,
    /// Last header of each robot's topics, to count what was lost.
    headers: BTreeMap<(String, &'static str), (u64, u64)>,
    next_stats: Timestamp,
    watch: W,
}

impl<W: FnMut(&Publication)> Driver<W> {
    fn run(&mut self, inbox: &Receiver<Event>, stop: &Arc<AtomicBool>) -> MissionState {
        let mut ended_at: Option<Timestamp> = None;
        loop {
            let now = self.clock.now();
            if self.core.ended() {
                let since = *ended_at.get_or_insert(now);
                let linger = LINGER.mul_f64(self.clock.factor());
                if now.since(since) >= linger {
                    return self.core.mission_state();
                }
            }
            if stop.load(Ordering::Relaxed) && ended_at.is_none() {
                let command = v1::OperatorCommand {
                    verb: v1::Verb::Cancel.into(),
                    who: "the process's end".to_owned(),
                    ..v1::OperatorCommand::default()
                };
                self.feed(Input::Operator(command));
            }
            let patience = self.core.next_wakeup().map_or(Duration::from_millis(100), |(due, _)| {
                self.clock.until(due).min(Duration::from_millis(100))
            });
            match inbox.recv_timeout(patience) {
                Ok(event) => self.take(event),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return self.core.mission_state(),
            }
            let now = self.clock.now();
            if self.core.next_wakeup().is_some_and(|(due, _)| due <= now) {
                self.feed(Input::Woken);
            }
            self.publish_stats(now);
        }
    }

    fn take(&mut self, event: Event) {
        match event {
            Event::Message { noun, robot, bytes } => self.take_message(noun, &robot, &bytes),
            Event::Token { robot, boot_id, alive } => {
                if !protocol::valid_id(&robot) {
                    self.stats.rejected += 1;
                } else if alive {
                    self.feed(Input::Alive { robot, boot_id });
                } else {
                    self.feed(Input::Gone { robot, boot_id });
                }
            }
            Event::Operator(query) => self.take_operator(query),
            Event::Sim { noun, bytes } => self.take_sim(noun, &bytes),
            Event::Input(input) => self.feed(*input),
        }
    }

    fn take_message(&mut self, noun: &'static str, robot: &str, bytes: &[u8]) {
        self.stats.received += 1;
        let taken = match noun {
            "state" => self.checked::<v1::State>(robot, noun, bytes).map(|state| {
                self.record(|| Record::State(Box::new(state.clone())));
                self.feed(Input::State(Box::new(state)));
            }),
            "factsheet" => self.checked::<v1::Factsheet>(robot, noun, bytes).map(|sheet| {
                self.record(|| Record::Factsheet(Box::new(sheet.clone())));
                self.feed(Input::Factsheet(Box::new(sheet)));
            }),
            _ => self.checked::<v1::Connection>(robot, noun, bytes).map(|connection| {
                self.record(|| Record::Connection(connection.clone()));
                self.feed(Input::Connection(connection));
            }),
        };
        if let Err(reason) = taken {
            self.stats.rejected += 1;
            tracing::warn!(robot, noun, %reason, "a message is refused");
        }
    }

    /// A message that is well formed, within bounds, and from the robot whose key it came by.
    fn checked<M>(&mut self, robot: &str, noun: &'static str, bytes: &[u8]) -> Result<M>
    where
        M: prost::Message + Default + Validate + HasHeader,
    {
        let message: M = decode(bytes)?;
        message.validate(&self.bounds)?;
        let header = message.header().context("no header")?;
        if header.serial_number != robot {
            anyhow::bail!("it came by the key of `{robot}` and says `{}`", header.serial_number);
        }
        self.count(robot, noun, header.boot_id, header.header_id);
        Ok(message)
    }

    fn count(&mut self, robot: &str, noun: &'static str, boot_id: u64, header_id: u64) {
        let last = self.headers.entry((robot.to_owned(), noun)).or_insert((boot_id, header_id));
        if last.0 == boot_id && header_id <= last.1 && header_id != last.1 {
            self.stats.duplicates += 1;
        } else if last.0 == boot_id && header_id > last.1 + 1 {
            self.stats.lost += header_id - last.1 - 1;
        }
        if last.0 != boot_id || header_id > last.1 {
            *last = (boot_id, header_id);
        }
    }

    fn take_operator(&mut self, query: Query) {
        let bytes = query.payload().map(|payload| payload.to_bytes().into_owned()).unwrap_or_default();
        let command: Result<v1::OperatorCommand> =
            decode(&bytes).map_err(Into::into).and_then(|command: v1::OperatorCommand| {
                command.validate(&self.bounds).map(|()| command).map_err(Into::into)
            });
        match command {
            Ok(command) => {
                self.queries.insert(command.command_id, query);
                self.record(|| Record::Operator(command.clone()));
                self.feed(Input::Operator(command));
            }
            Err(reason) => {
                self.stats.rejected += 1;
                let reply = v1::OperatorReply { reason: reason.to_string(), ..v1::OperatorReply::default() };
                reply_aside(query, encode(&reply));
            }
        }
    }

    fn take_sim(&mut self, noun: &str, bytes: &[u8]) {
        let record = match noun {
            "truth" => decode(bytes).map(|truth| Record::Truth(Box::new(truth))),
            "contacts" => decode(bytes).map(Record::Contact),
            _ => decode(bytes).map(Record::Fault),
        };
        match record {
            Ok(record) => self.record(|| record),
            Err(_) => self.stats.rejected += 1,
        }
    }

    fn feed(&mut self, input: Input) {
        let outputs = self.core.handle(self.clock.now(), input);
        for output in outputs {
            self.carry_out(output);
        }
    }

    fn carry_out(&mut self, output: Output) {
        match output {
            Output::Order { robot, order } => {
                self.send(&robot, "order", encode(&order));
                self.record(|| Record::Order { robot, order });
            }
            Output::Grant { robot, grant } => {
                self.send(&robot, "grant", encode(&grant));
                self.record(|| Record::Grant { robot, grant });
            }
            Output::InstantActions { robot, actions } => {
                self.send(&robot, "instantActions", encode(&actions));
                self.record(|| Record::InstantActions { robot, actions });
            }
            Output::Plan(request) => self.plan(request),
            Output::BreakOffs(request) => self.choose_break_offs(request),
            Output::Publish(publication) => self.publish(publication),
            Output::Reply(reply) => {
                if let Some(query) = self.queries.remove(&reply.command_id) {
                    reply_aside(query, encode(&reply));
                }
            }
        }
    }

    fn send(&self, robot: &str, noun: &str, bytes: Vec<u8>) {
        link::put(&self.session, &keys::robot(&self.fleet, robot, noun), bytes, Urgency::Command);
    }

    fn plan(&self, request: Box<crate::PlanRequest>) {
        let events = self.events.clone();
        std::thread::spawn(move || {
            let begun = std::time::Instant::now();
            let result = request.run();
            let planning_s = begun.elapsed().as_secs_f64();
            let input = Input::Planned { revision: request.revision, result, planning_s };
            let _ = events.send(Event::Input(Box::new(input)));
        });
    }

    fn choose_break_offs(&self, request: Box<crate::BreakOffRequest>) {
        let events = self.events.clone();
        std::thread::spawn(move || {
            let input = Input::BrokenOff { revision: request.revision, breaks: request.run() };
            let _ = events.send(Event::Input(Box::new(input)));
        });
    }

    fn publish(&mut self, publication: Publication) {
        let (noun, bytes) = match &publication {
            Publication::Status(status) => ("status", encode(&**status)),
            Publication::Coverage(delta) => ("coverage", encode(delta)),
            Publication::Decision(decision) => ("decisions", encode(decision)),
            Publication::Event(event) => ("events", encode(event)),
            Publication::Reservations(reservations) => ("reservations", encode(reservations)),
            Publication::Result(result) => ("result", encode(result)),
        };
        if noun == "status"
            && let Ok(mut snapshot) = self.snapshot.lock()
        {
            snapshot.clone_from(&bytes);
        }
        link::put(&self.session, &keys::coordinator(&self.fleet, noun), bytes, Urgency::Background);
        (self.watch)(&publication);
        self.record(|| Record::Publication(publication));
    }

    fn record(&self, record: impl FnOnce() -> Record) {
        if let Some(log) = &self.log {
            log.record(self.clock.now(), record());
        }
    }

    fn publish_stats(&mut self, now: Timestamp) {
        if now < self.next_stats {
            return;
        }
        self.next_stats = now + Duration::from_secs(1);
        self.stats.timestamp_ns = now.as_nanos();
        self.stats.record_dropped =
            self.log.as_ref().map_or(0, LogThread::dropped) + self.dropped.load(Ordering::Relaxed);
        self.stats.coordinator_cpu_s = cpu_seconds();
        let stats = self.stats;
        link::put(
            &self.session,
            &keys::coordinator(&self.fleet, "stats"),
            encode(&stats),
            Urgency::Background,
        );
        self.record(|| Record::Transport(stats));
    }

    fn finish(mut self) -> Result<()> {
        match self.log.take() {
            Some(log) => log.finish(),
            None => Ok(()),
        }
    }
}

/// Messages that begin with a header.
trait HasHeader {
    fn header(&self) -> Option<&v1::Header>;
}

impl HasHeader for v1::State {
    fn header(&self) -> Option<&v1::Header> {
        self.header.as_ref()
    }
}

impl HasHeader for v1::Factsheet {
    fn header(&self) -> Option<&v1::Header> {
        self.header.as_ref()
    }
}

impl HasHeader for v1::Connection {
    fn header(&self) -> Option<&v1::Header> {
        self.header.as_ref()
    }
}

/// User and system time of this process so far, as Linux tells it (100 ticks a second); 0 elsewhere.
fn cpu_seconds() -> f64 {
    let Ok(stat) = std::fs::read_to_string("/proc/self/stat") else { return 0.0 };
    let after_name = stat.rsplit(')').next().unwrap_or_default();
    let fields: Vec<&str> = after_name.split_whitespace().collect();
    let ticks = |at: usize| fields.get(at).and_then(|field| field.parse::<f64>().ok()).unwrap_or(0.0);
    (ticks(11) + ticks(12)) / 100.0
}
