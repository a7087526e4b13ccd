//! The agent: drives one robot along its order and reports what it swept.
//!
//! [`Agent`] is a state machine without I/O: [`Agent::handle`] takes one [`Input`] at a time and returns what has
//! to be done about it. `driver.rs` is the only file with zenoh, iceoryx2 and a clock.

mod agent;
mod base;
mod bend;
#[cfg(feature = "driver")]
pub mod driver;
mod lease;
mod localisation;
mod obstacle_watch;
mod order_book;
mod path_follower;
mod sweep_log;

pub use agent::{Agent, Input, Output};
pub use base::{Base, BaseError};
