//! zenoh sessions with the settings that were measured: the coordinator's is the router, everybody else is a client
//! of it; no multicast, no gossip; a lease of one second; nothing ever blocks on a slow receiver.

use anyhow::{Context, Result, anyhow, bail};
use std::{
    path::PathBuf,
    sync::mpsc,
    time::{Duration, Instant},
};
use zenoh::{Config, Session, Wait, qos::CongestionControl, qos::Priority};

/// Loss of a session is noticed after this, milliseconds.
const LEASE_MS: u32 = 1000;
/// Even a reply may hold up a sender for this long at most, microseconds.
const BLOCKED_MAX_US: u32 = 200_000;
/// An attempt to open a session that takes longer than this is left behind, and another one made.
const ATTEMPT_MAX: Duration = Duration::from_secs(10);

/// Where to connect or listen, and a file of further zenoh settings.
#[derive(Debug, Clone, Default)]
pub struct Endpoint {
    /// For example `tcp/127.0.0.1:7447`.
    pub locator: String,
    /// A zenoh configuration file (JSON5); what it sets wins over our settings, mode and endpoint excepted.
    pub config_file: Option<PathBuf>,
    /// Prefix of all keys of the session, for several fleets on one router.
    pub namespace: Option<String>,
}

/// How urgent a message is; the queues are separate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Urgency {
    /// Orders, grants, stops: at once and before all others.
    Command,
    /// States and the like.
    Data,
    /// What may come late: pictures, status.
    Background,
}

/// Opens the coordinator's session: a router that listens.
///
/// # Errors
///
/// When the port is taken, or the configuration is not valid.
pub fn open_router(at: &Endpoint) -> Result<Session> {
    let mut config = settings(at)?;
    set(&mut config, "mode", "\"router\"")?;
    set(&mut config, "listen/endpoints", &format!("[\"{}\"]", at.locator))?;
    let (done, opened) = mpsc::channel();
    std::thread::spawn(move || {
        let _ = done.send(zenoh::open(config).wait());
    });
    let session = opened
        .recv_timeout(ATTEMPT_MAX)
        .map_err(|_| anyhow!("zenoh did not come up within {} s", ATTEMPT_MAX.as_secs()))?;
    session.map_err(|error| anyhow!("{error}")).with_context(|| {
        format!(
            "cannot listen on {}: is another coordinator running there? Choose another port with --listen \
             tcp/127.0.0.1:PORT",
            at.locator
        )
    })
}

/// Opens a client's session, trying again until it works or `patience` is over.
///
/// # Errors
///
/// When nobody was reached within `patience`, or the configuration is not valid.
pub fn open_client(at: &Endpoint, patience: Duration) -> Result<Session> {
    let begun = Instant::now();
    let mut pause = Duration::from_millis(50);
    loop {
        let mut config = settings(at)?;
        set(&mut config, "mode", "\"client\"")?;
        set(&mut config, "connect/endpoints", &format!("[\"{}\"]", at.locator))?;
        let (done, opened) = mpsc::channel();
        std::thread::spawn(move || {
            let _ = done.send(zenoh::open(config).wait());
        });
        let left = patience.saturating_sub(begun.elapsed()).max(Duration::from_millis(100));
        if let Ok(Ok(session)) = opened.recv_timeout(left.min(ATTEMPT_MAX)) {
            return Ok(session);
        }
        if begun.elapsed() >= patience {
            bail!("no coordinator was reached at {} within {:.0} s", at.locator, patience.as_secs_f64());
        }
        std::thread::sleep(pause.min(patience.saturating_sub(begun.elapsed())));
        pause = (pause * 2).min(Duration::from_secs(1));
    }
}

/// Our settings, under those of the file: where the file says nothing (or what zenoh does by itself), ours hold.
fn settings(at: &Endpoint) -> Result<Config> {
    let mut config = match &at.config_file {
        Some(file) => Config::from_file(file)
            .map_err(|error| anyhow!("{error}"))
            .with_context(|| format!("{}: not a zenoh configuration", file.display()))?,
        None => Config::default(),
    };
    let ours = [
        ("scouting/multicast/enabled", "false".to_owned()),
        ("scouting/gossip/enabled", "false".to_owned()),
        ("transport/link/tx/lease", LEASE_MS.to_string()),
        ("transport/link/tx/queue/congestion_control/block/wait_before_close", BLOCKED_MAX_US.to_string()),
        ("connect/retry", "{period_init_ms: 200, period_max_ms: 1000}".to_owned()),
    ];
    let by_itself = Config::default();
    for (key, value) in &ours {
        if config.get_json(key).ok() == by_itself.get_json(key).ok() {
            set(&mut config, key, value)?;
        }
    }
    if let Some(namespace) = &at.namespace {
        set(&mut config, "namespace", &format!("\"{namespace}\""))?;
    }
    Ok(config)
}

fn set(config: &mut Config, key: &str, value: &str) -> Result<()> {
    config.insert_json5(key, value).map_err(|error| anyhow!("zenoh setting {key} = {value}: {error}"))
}

/// The port a router listens on.
pub fn bound_port(session: &Session) -> Option<u16> {
    let locators = session.info().locators().wait();
    locators.iter().find_map(|locator| locator.to_string().rsplit(':').next()?.parse().ok())
}

/// Puts a message; never blocks: what does not fit is dropped, and repeated by whoever needs it to arrive.
pub fn put(session: &Session, key: &str, bytes: Vec<u8>, urgency: Urgency) {
    let priority = match urgency {
        Urgency::Command => Priority::InteractiveHigh,
        Urgency::Data => Priority::Data,
        Urgency::Background => Priority::Background,
    };
    let sent = session
        .put(key, bytes)
        .congestion_control(CongestionControl::Drop)
        .priority(priority)
        .express(urgency == Urgency::Command)
        .wait();
    if let Err(error) = sent {
        tracing::debug!(key, %error, "a message was not sent");
    }
}

/// Asks for a reply. No reply at all means that nobody was reached.
///
/// # Errors
///
/// When nobody answered within `patience`.
pub fn get(session: &Session, key: &str, payload: Vec<u8>, patience: Duration) -> Result<Vec<u8>> {
    let replies = session
        .get(key)
        .payload(payload)
        .timeout(patience)
        .wait()
        .map_err(|error| anyhow!("asking {key}: {error}"))?;
    while let Ok(reply) = replies.recv() {
        match reply.result() {
            Ok(sample) => return Ok(sample.payload().to_bytes().into_owned()),
            Err(error) => tracing::debug!(key, ?error, "an error instead of a reply"),
        }
    }
    bail!("nobody answers at {key}")
}
