//! The bus between an agent and its robot's base: iceoryx2, one pair of services per robot, protobuf bytes.
//!
//! ```text
//!   body end (sim)   ── state, 50 Hz ──▶ wake-up ──▶   agent end
//!                    ◀──── setpoint ─────────────
//! ```
//!
//! Services overflow silently by design: the newest counts, and sequence numbers tell what was missed. All sizes
//! are explicit, and every run has a prefix of its own, so that runs on one machine do not meet.

use iceoryx2::{
    port::{listener::Listener, notifier::Notifier, publisher::Publisher, subscriber::Subscriber},
    prelude::*,
};
use prost::Message;
use protocol::v1;
use std::time::Duration;

/// The longest message, bytes: a base state with a scan of 128 beams and a description.
const MESSAGE_MAX: usize = 4096;
/// Messages that wait for a slow reader; beyond that the oldest is dropped.
const BUFFERED: usize = 16;
/// Where the files of the services are kept, when it is there: it is in memory.
const MEMORY_ROOT: &str = "/dev/shm/oxplow";

/// Why a bus does not work.
#[derive(Debug)]
pub struct BusError(String);

impl std::fmt::Display for BusError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "the bus to the robot's base (iceoryx2): {}", self.0)
    }
}

impl std::error::Error for BusError {}

/// Removes what processes that were killed left of a run in shared memory. To be called when all of them have ended.
pub fn remove_left_behind(prefix: &str) {
    let ours = format!("{prefix}_");
    for folder in ["/dev/shm", MEMORY_ROOT] {
        remove_files(std::path::Path::new(folder), &ours);
    }
    for folder in ["nodes", "services"] {
        remove_files(&std::path::Path::new(MEMORY_ROOT).join(folder), &ours);
    }
}

fn remove_files(folder: &std::path::Path, ours: &str) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        if !entry.file_name().to_string_lossy().starts_with(ours) {
            continue;
        }
        let path = entry.path();
        let gone = if path.is_dir() { std::fs::remove_dir_all(&path) } else { std::fs::remove_file(&path) };
        if let Err(error) = gone {
            tracing::debug!(path = %path.display(), %error, "a file of the bus stays behind");
        }
    }
}

fn failed(what: &str) -> impl Fn(String) -> BusError + '_ {
    move |reason| BusError(format!("{what}: {reason}"))
}

/// All buses of one process in one run.
#[derive(Debug)]
pub struct Bus {
    node: Node<ipc::Service>,
}

impl Bus {
    /// Joins the buses of the run with this prefix.
    ///
    /// # Errors
    ///
    /// [`BusError`] when the prefix is not a file name, or shared memory is not to be had.
    pub fn join(prefix: &str) -> Result<Self, BusError> {
        set_log_level(LogLevel::Error);
        let mut config = Config::default();
        config.global.prefix = FileName::new(format!("{prefix}_").as_bytes())
            .map_err(|error| failed("prefix")(format!("{error:?}")))?;
        if std::fs::create_dir_all(MEMORY_ROOT).is_ok() {
            let root =
                Path::new(MEMORY_ROOT.as_bytes()).map_err(|error| failed("root")(format!("{error:?}")))?;
            config.global.set_root_path(&root);
        }
        let node = NodeBuilder::new()
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>()
            .map_err(|error| failed("node")(format!("{error:?}")))?;
        Ok(Self { node })
    }

    /// The body's end of a robot's bus.
    ///
    /// # Errors
    ///
    /// [`BusError`].
    pub fn body_end(&self, robot: &str) -> Result<BodyEnd, BusError> {
        let state = self.bytes(&format!("{robot}/state"))?;
        let setpoint = self.bytes(&format!("{robot}/setpoint"))?;
        let wake = self.wake(robot)?;
        Ok(BodyEnd {
            states: publisher(&state)?,
            setpoints: subscriber(&setpoint)?,
            wake: wake
                .notifier_builder()
                .create()
                .map_err(|error| failed("notifier")(format!("{error:?}")))?,
        })
    }

    /// The agent's end of a robot's bus.
    ///
    /// # Errors
    ///
    /// [`BusError`].
    pub fn agent_end(&self, robot: &str) -> Result<AgentEnd, BusError> {
        let state = self.bytes(&format!("{robot}/state"))?;
        let setpoint = self.bytes(&format!("{robot}/setpoint"))?;
        let wake = self.wake(robot)?;
        Ok(AgentEnd {
            states: subscriber(&state)?,
            setpoints: publisher(&setpoint)?,
            wake: wake
                .listener_builder()
                .create()
                .map_err(|error| failed("listener")(format!("{error:?}")))?,
        })
    }

    /// Frees what processes of this run left behind that are dead.
    pub fn clean_up(&self) {
        let _ = self.node.try_cleanup_dead_nodes();
    }

    fn bytes(&self, name: &str) -> Result<Bytes, BusError> {
        let name = ServiceName::new(name).map_err(|error| failed(name)(format!("{error:?}")))?;
        self.node
            .service_builder(&name)
            .publish_subscribe::<[u8]>()
            .max_publishers(2)
            .max_subscribers(2)
            .max_nodes(6)
            .subscriber_max_buffer_size(BUFFERED)
            .subscriber_max_borrowed_samples(2)
            .history_size(0)
            .enable_safe_overflow(true)
            .open_or_create()
            .map_err(|error| failed("service")(format!("{error:?}")))
    }

    fn wake(
        &self,
        robot: &str,
    ) -> Result<iceoryx2::service::port_factory::event::PortFactory<ipc::Service>, BusError> {
        let name = ServiceName::new(&format!("{robot}/wake"))
            .map_err(|error| failed("wake")(format!("{error:?}")))?;
        self.node
            .service_builder(&name)
            .event()
            .max_notifiers(2)
            .max_listeners(2)
            .max_nodes(6)
            .open_or_create()
            .map_err(|error| failed("service")(format!("{error:?}")))
    }
}

type Bytes = iceoryx2::service::port_factory::publish_subscribe::PortFactory<ipc::Service, [u8], ()>;

fn publisher(service: &Bytes) -> Result<Publisher<ipc::Service, [u8], ()>, BusError> {
    service
        .publisher_builder()
        .initial_max_slice_len(MESSAGE_MAX)
        .max_loaned_samples(2)
        .create()
        .map_err(|error| failed("publisher")(format!("{error:?}")))
}

fn subscriber(service: &Bytes) -> Result<Subscriber<ipc::Service, [u8], ()>, BusError> {
    service
        .subscriber_builder()
        .buffer_size(BUFFERED)
        .create()
        .map_err(|error| failed("subscriber")(format!("{error:?}")))
}

fn send(publisher: &Publisher<ipc::Service, [u8], ()>, message: &impl Message) -> Result<(), BusError> {
    let bytes = message.encode_to_vec();
    if bytes.len() > MESSAGE_MAX {
        return Err(BusError(format!("a message of {} bytes; at most {MESSAGE_MAX} go", bytes.len())));
    }
    let sample =
        publisher.loan_slice_uninit(bytes.len()).map_err(|error| failed("loan")(format!("{error:?}")))?;
    sample.write_from_slice(&bytes).send().map_err(|error| failed("send")(format!("{error:?}")))?;
    Ok(())
}

fn receive<M: Message + Default>(
    subscriber: &Subscriber<ipc::Service, [u8], ()>,
) -> Result<Option<M>, BusError> {
    loop {
        let sample = subscriber.receive().map_err(|error| failed("receive")(format!("{error:?}")))?;
        let Some(sample) = sample else { return Ok(None) };
        match protocol::decode(sample.payload()) {
            Ok(message) => return Ok(Some(message)),
            Err(error) => tracing::warn!(%error, "a message on the bus is dropped"),
        }
    }
}

/// The body's end: states go out, setpoints come in.
#[derive(Debug)]
pub struct BodyEnd {
    states: Publisher<ipc::Service, [u8], ()>,
    setpoints: Subscriber<ipc::Service, [u8], ()>,
    wake: Notifier<ipc::Service>,
}

impl BodyEnd {
    /// Sends what the base measured, and wakes the agent.
    ///
    /// # Errors
    ///
    /// [`BusError`].
    pub fn send(&self, state: &v1::BaseState) -> Result<(), BusError> {
        send(&self.states, state)?;
        let _ = self.wake.notify();
        Ok(())
    }

    /// The next setpoint, oldest first.
    ///
    /// # Errors
    ///
    /// [`BusError`].
    pub fn receive(&self) -> Result<Option<v1::Setpoint>, BusError> {
        receive(&self.setpoints)
    }
}

/// The agent's end: states come in, setpoints go out.
#[derive(Debug)]
pub struct AgentEnd {
    states: Subscriber<ipc::Service, [u8], ()>,
    setpoints: Publisher<ipc::Service, [u8], ()>,
    wake: Listener<ipc::Service>,
}

impl AgentEnd {
    /// Waits until the base says something, at most so long.
    pub fn wait(&self, at_most: Duration) {
        let _ = self.wake.timed_wait(|_| {}, at_most);
    }

    /// The next measurement, oldest first.
    ///
    /// # Errors
    ///
    /// [`BusError`].
    pub fn receive(&self) -> Result<Option<v1::BaseState>, BusError> {
        receive(&self.states)
    }

    /// Sends a setpoint.
    ///
    /// # Errors
    ///
    /// [`BusError`].
    pub fn send(&self, setpoint: &v1::Setpoint) -> Result<(), BusError> {
        send(&self.setpoints, setpoint)
    }
}
