//! oxplow: what a person looks at: verification of a log, status, pictures.
//!
//! ```text
//!   RUN.mcap ──▶ log_reader ──┬──▶ verify   what truly happened, against what was claimed
//!                             └──▶ picture  the floor as SVG
//!   FleetStatus ──────────────▶ status, event_line
//! ```
//!
//! Everything here reads; nothing here decides.

mod event_line;
mod ledger;
mod log_reader;
mod palette;
mod picture;
mod status;
pub mod verify;

pub use event_line::event_line;
pub use ledger::{Claim, Ledger};
pub use log_reader::{LogError, RECORD_BYTES_MAX};
pub use picture::{Picture, picture_from_log};
pub use status::{StatusReport, status_text};
pub use verify::{Verdict, verify_bytes, verify_log};
