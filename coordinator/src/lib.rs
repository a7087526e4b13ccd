//! The coordinator: decides who covers what, grants space, replans, keeps the ledger.
//!
//! [`Coordinator`] is a state machine without I/O: [`Coordinator::handle`] takes one [`Input`] at a time and
//! returns what has to be done about it. `driver.rs` is the only file with zenoh, tokio and a clock.

mod announce;
mod blockage;
mod break_off;
mod charging;
mod config;
mod coordinator;
#[cfg(feature = "driver")]
pub mod driver;
mod ending;
mod energy;
mod input;
mod ledger;
mod operator;
mod output;
mod passing;
mod places;
mod presence;
mod range;
mod reach;
pub mod recorder;
mod replan;
mod result;
mod resuming;
mod robot;

mod route;
mod sending;
#[cfg(test)]
mod tests;
mod traffic;
mod way;
mod zones;

pub use break_off::{BreakOffRequest, ChosenBreak};
pub use config::{Config, Mission, Station, Timing};
pub use coordinator::{Coordinator, WALL_MARGIN_M};
pub use input::Input;
pub use output::{Output, PlanRequest, Publication};
