//! The agent: drives one robot along its order and reports what it swept.
//!
//! [`Agent`] is a state machine without I/O: [`Agent::handle`] takes one [`Input`] at a time and returns what has
//! to be done about it. `driver.rs` is the only file with zenoh, iceoryx2 and a clock.

mod agent;

pub use agent::{Agent, Input, Output};
