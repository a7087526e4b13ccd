//! The messages of the fleet: data only.
//!
//! ```text
//!            State, Factsheet, Connection                OperatorCommand
//!   agent ───────────────────────────────▶ coordinator ◀──────────────── command line
//!         ◀───────────────────────────────     │
//!            Order, Grant, InstantActions      │ FleetStatus, CoverageDelta, Decision, Event, …
//!     ▲                                        ▼
//!     │ BaseState, Setpoint (iceoryx2)      observers, log
//!     ▼
//!   robot's base, or the sim
//! ```
//!
//! What is on the wire is what is in the log: protobuf, package `oxplow.v1`, compiled from `proto/`.
//! [`decode`] never panics, whatever the bytes; [`validate`] refuses what is not finite, too long or badly named.

mod encoding;
pub mod keys;
mod timestamp;
mod validation;

/// The generated messages.
pub mod v1 {
    #![allow(
        missing_docs,
        clippy::pedantic,
        clippy::doc_markdown,
        reason = "generated; documented in the .proto files"
    )]
    include!(concat!(env!("OUT_DIR"), "/oxplow.v1.rs"));
}

pub use encoding::{DESCRIPTORS, DecodeError, MESSAGE_BYTES_MAX, decode, encode};
pub use timestamp::{LOG_EPOCH_NS, Timestamp};
pub use validation::{Bounds, Invalid, Validate, valid_id};
