//! Which fleet a command talks to, and where.

use anyhow::Result;
use clap::Args;
use link::Endpoint;
use std::{io::IsTerminal, path::PathBuf, time::Duration};
use zenoh::Session;

/// Where a coordinator listens when nothing else is said.
pub const DEFAULT_LOCATOR: &str = "tcp/127.0.0.1:7447";
/// The fleet when nothing else is said.
pub const DEFAULT_FLEET: &str = "oxplow";
/// How long a command waits for the coordinator.
const PATIENCE: Duration = Duration::from_secs(3);

/// Which fleet, and where its coordinator listens.
#[derive(Debug, Clone, Args)]
pub struct FleetArgs {
    /// Where the coordinator listens
    #[arg(long, value_name = "LOCATOR", default_value = DEFAULT_LOCATOR)]
    pub connect: String,
    /// Name of the fleet
    #[arg(long, value_name = "NAME", default_value = DEFAULT_FLEET, value_parser = fleet_name)]
    pub fleet: String,
    /// A zenoh configuration file with further settings (TLS, access control, …)
    #[arg(long, value_name = "FILE.json5")]
    pub zenoh_config: Option<PathBuf>,
}

/// A fleet's name is part of every key.
pub fn fleet_name(name: &str) -> Result<String, String> {
    if protocol::valid_id(name) {
        Ok(name.to_owned())
    } else {
        Err("1 to 64 of A-Z a-z 0-9 _ . - are allowed".to_owned())
    }
}

/// Nobody answered.
#[derive(Debug)]
pub struct NotReached(pub String);

impl std::fmt::Display for NotReached {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for NotReached {}

impl FleetArgs {
    /// The endpoint to connect to.
    pub fn endpoint(&self) -> Endpoint {
        Endpoint { locator: self.connect.clone(), config_file: self.zenoh_config.clone(), namespace: None }
    }

    /// A session with the fleet's coordinator.
    ///
    /// # Errors
    ///
    /// [`NotReached`] when nobody listens there.
    pub fn open(&self) -> Result<Session> {
        link::open_client(&self.endpoint(), PATIENCE).map_err(|_| {
            anyhow::Error::new(NotReached(format!(
                "no coordinator is reached at {}: is one running? `oxplow up SCENARIO.toml` prints where it listens; \
                 say so with --connect",
                self.connect
            )))
        })
    }

    /// Asks a question of the fleet.
    ///
    /// # Errors
    ///
    /// [`NotReached`] when nobody answers.
    pub fn ask(&self, key: &str, payload: Vec<u8>, whom: &str) -> Result<Vec<u8>> {
        let session = self.open()?;
        link::get(&session, key, payload, PATIENCE).map_err(|_| {
            anyhow::Error::new(NotReached(format!(
                "the {whom} of fleet `{}` does not answer at {}: check --fleet",
                self.fleet, self.connect
            )))
        })
    }
}

/// Colour is for terminals, and for those who did not set `NO_COLOR`.
pub fn wants_colour(stream: &impl IsTerminal) -> bool {
    stream.is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}
