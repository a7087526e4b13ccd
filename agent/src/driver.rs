//! The agent as a process: zenoh to the coordinator, iceoryx2 to its robot's base, the machine's clock.
//!
//! One thread: it waits for the base, drains what zenoh brought, hands both to the [`Agent`], and sends what that
//! returns. zenoh's own threads only push into a bounded queue; what does not fit is dropped, since everything is
//! repeated.
#![expect(clippy::disallowed_methods, reason = "a driver has clocks and waits")]

use crate::{Agent, Input, Output};
use anyhow::{Context, Result, bail};
use link::{AgentEnd, Bus, Clock, Endpoint, Urgency, open_client};
use protocol::{decode, encode, keys, v1};
use std::{
    hash::{BuildHasher, Hasher},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
        mpsc::{Receiver, SyncSender, sync_channel},
    },
    time::{Duration, Instant},
};
use zenoh::{Session, Wait};

/// Messages that wait for the agent's thread.
const QUEUE: usize = 256;
/// How long to wait for the robot's base before giving up.
const BASE_PATIENCE: Duration = Duration::from_secs(30);
/// How long the base may be silent on the way, on the machine's clock.
const BASE_SILENCE_MAX: Duration = Duration::from_secs(20);

/// Who the agent is and whom it talks to.
#[derive(Debug, Clone)]
pub struct Options {
    /// The robot.
    pub id: String,
    /// The fleet it belongs to: first part of all keys.
    pub fleet: String,
    /// Where the coordinator listens.
    pub connect: Endpoint,
    /// Prefix of the bus to the robot's base.
    pub base_prefix: String,
    /// How long to try to reach the coordinator before giving up.
    pub patience: Duration,
}

/// Runs until `stop` is set, or the base falls silent.
///
/// # Errors
///
/// When the coordinator or the base is not reached.
pub fn run(options: &Options, stop: &Arc<AtomicBool>) -> Result<()> {
    let bus = Bus::join(&options.base_prefix)?;
    let base = bus.agent_end(&options.id)?;
    let mut driver = Driver::new(options, base)?;
    driver.connect(options.patience)?;
    let ended = driver.run(stop);
    driver.say_goodbye();
    ended
}

/// What zenoh brought.
enum Message {
    Order(Box<v1::Order>),
    Grant(v1::Grant),
    Actions(v1::InstantActions),
}

struct Driver<'a> {
    options: &'a Options,
    agent: Agent,
    boot_id: u64,
    base: AgentEnd,
    clock: Clock,
    factor: f64,
    wire: Option<Wire>,
    reconnect_at: Option<Instant>,
    heard_base: Instant,
    missed: u64,
    last_sequence: u64,
}

/// An open session with what is declared on it.
struct Wire {
    session: Session,
    messages: Receiver<Message>,
    _subscriptions: Vec<zenoh::pubsub::Subscriber<()>>,
    _token: zenoh::liveliness::LivelinessToken,
}

impl<'a> Driver<'a> {
    fn new(options: &'a Options, base: AgentEnd) -> Result<Self> {
        if !protocol::valid_id(&options.id) {
            bail!("`{}` is not a robot id: 1 to 64 of A-Z a-z 0-9 _ . -", options.id);
        }
        let boot_id = draw_boot_id();
        Ok(Self {
            options,
            agent: Agent::new(&options.id, boot_id, std::process::id()),
            boot_id,
            base,
            clock: Clock::start(1.0),
            factor: 1.0,
            wire: None,
            reconnect_at: None,
            heard_base: Instant::now(),
            missed: 0,
            last_sequence: 0,
        })
    }

    fn connect(&mut self, patience: Duration) -> Result<()> {
        self.wire = Some(Wire::open(self.options, self.boot_id, patience)?);
        let outputs = self.agent.handle(self.clock.now(), Input::Link(true));
        self.carry_out(outputs);
        tracing::info!(robot = %self.options.id, at = %self.options.connect.locator, "connected");
        Ok(())
    }

    fn run(&mut self, stop: &Arc<AtomicBool>) -> Result<()> {
        let begun = Instant::now();
        let mut described = false;
        while !stop.load(Ordering::Relaxed) {
            self.base.wait(Duration::from_millis(5));
            while let Some(state) = self.base.receive()? {
                described |= state.description.is_some();
                self.heard_base = Instant::now();
                self.take_base(state);
            }
            self.drain_wire();
            self.wake();
            if !described && begun.elapsed() > BASE_PATIENCE {
                bail!(
                    "the base of robot {} does not answer on bus `{}`: is `oxplow sim` running, with this robot \
                     in its scenario?",
                    self.options.id,
                    self.options.base_prefix
                );
            }
            if described && self.heard_base.elapsed() > BASE_SILENCE_MAX {
                bail!("the base of robot {} has fallen silent", self.options.id);
            }
        }
        Ok(())
    }

    fn take_base(&mut self, state: v1::BaseState) {
        if state.time_factor > 0.0 && (state.time_factor - self.factor).abs() > 1e-9 {
            self.factor = state.time_factor;
            self.clock = Clock::start(self.factor);
        }
        if self.last_sequence != 0 && state.sequence > self.last_sequence + 1 {
            self.missed += state.sequence - self.last_sequence - 1;
            tracing::debug!(missed = self.missed, "measurements of the base were missed");
        }
        self.last_sequence = state.sequence;
        self.obey_the_jammer(state.radio_jammed);
        let outputs = self.agent.handle(self.clock.now(), Input::Base(Box::new(state)));
        self.carry_out(outputs);
    }

    /// Simulation only: a jammed radio takes the session down without a goodbye, and lets it come back.
    fn obey_the_jammer(&mut self, jammed: bool) {
        if jammed && self.wire.is_some() {
            tracing::info!("the link is cut");
            self.wire = None;
            let outputs = self.agent.handle(self.clock.now(), Input::Link(false));
            self.carry_out(outputs);
        }
        let due = self.reconnect_at.is_none_or(|at| Instant::now() >= at);
        if !jammed && self.wire.is_none() && due && self.connect(Duration::from_millis(300)).is_err() {
            self.reconnect_at = Some(Instant::now() + Duration::from_millis(500));
        }
    }

    fn drain_wire(&mut self) {
        while let Some(message) = self.wire.as_ref().and_then(|wire| wire.messages.try_recv().ok()) {
            let input = match message {
                Message::Order(order) => Input::Order(order),
                Message::Grant(grant) => Input::Grant(grant),
                Message::Actions(actions) => Input::InstantActions(actions),
            };
            let outputs = self.agent.handle(self.clock.now(), input);
            self.carry_out(outputs);
        }
    }

    fn wake(&mut self) {
        let now = self.clock.now();
        if self.agent.next_wakeup().is_some_and(|(due, _)| due <= now) {
            let outputs = self.agent.handle(now, Input::Woken);
            self.carry_out(outputs);
        }
    }

    fn carry_out(&mut self, outputs: Vec<Output>) {
        for output in outputs {
            match output {
                Output::Setpoint(setpoint) => {
                    if let Err(error) = self.base.send(&setpoint) {
                        tracing::warn!(%error, "a setpoint was not sent");
                    }
                }
                Output::State(state) => self.send("state", encode(&*state), Urgency::Data),
                Output::Factsheet(sheet) => self.send("factsheet", encode(&*sheet), Urgency::Data),
                Output::Connection(connection) => self.send("connection", encode(&connection), Urgency::Data),
            }
        }
    }

    fn send(&self, noun: &str, bytes: Vec<u8>, urgency: Urgency) {
        if let Some(wire) = &self.wire {
            link::put(
                &wire.session,
                &keys::robot(&self.options.fleet, &self.options.id, noun),
                bytes,
                urgency,
            );
        }
    }

    fn say_goodbye(&mut self) {
        let outputs = self.agent.shutdown(self.clock.now());
        self.carry_out(outputs);
        if let Some(wire) = self.wire.take() {
            let _ = wire.session.close().wait();
        }
    }
}

impl Wire {
    fn open(options: &Options, boot_id: u64, patience: Duration) -> Result<Self> {
        let session = open_client(&options.connect, patience)
            .context("start the coordinator first, or check --connect")?;
        let (queue, messages) = sync_channel(QUEUE);
        let declared = |error: zenoh::Error| anyhow::anyhow!("zenoh: {error}");
        let mut subscriptions = Vec::new();
        for noun in keys::DOWN {
            let key = keys::robot(&options.fleet, &options.id, noun);
            let queue = queue.clone();
            let subscription = session
                .declare_subscriber(key)
                .callback(move |sample| push(&queue, noun, &sample.payload().to_bytes()))
                .wait()
                .map_err(declared)?;
            subscriptions.push(subscription);
        }
        let token = session
            .liveliness()
            .declare_token(keys::alive(&options.fleet, &options.id, boot_id))
            .wait()
            .map_err(declared)?;
        Ok(Self { session, messages, _subscriptions: subscriptions, _token: token })
    }
}

fn push(queue: &SyncSender<Message>, noun: &str, bytes: &[u8]) {
    let message = match noun {
        "order" => decode(bytes).map(|order| Message::Order(Box::new(order))),
        "grant" => decode(bytes).map(Message::Grant),
        _ => decode(bytes).map(Message::Actions),
    };
    match message {
        Ok(message) => drop(queue.try_send(message)),
        Err(error) => tracing::warn!(noun, %error, "a message is dropped"),
    }
}

/// Drawn by the operating system's randomness behind the standard library's hash keys.
fn draw_boot_id() -> u64 {
    let mut hasher = std::collections::hash_map::RandomState::new().build_hasher();
    hasher.write_u32(std::process::id());
    hasher.finish().max(1)
}
