//! The world the robots live in, its faults, and a rehearsal of the whole fleet in one thread.

mod battery;
mod body;
mod checkers;
mod clearance;
mod collisions;
mod contact;
mod drive;
#[cfg(feature = "driver")]
pub mod driver;
mod faults;
mod floor_crew;
mod localisation;
mod network;
mod obstacle;
mod people;
mod random_story;
mod random_streams;
mod range_finder;
mod rehearsal;
mod scenario;
mod session;
mod station;
#[cfg(test)]
mod testing;
mod transcript;
mod world;

pub use checkers::Violation;
pub use drive::{Refusal, WATCHDOG};
pub use faults::{Fault, FaultEntry, ProcessAction, WalkKind};
pub use random_story::{random_faults, random_story};
pub use rehearsal::{Options, Outcome, Rehearsal, Sink};
pub use scenario::*;
pub use transcript::Transcript;
pub use world::{STEP, World};
