//! The world the robots live in, its faults, and a rehearsal of the whole fleet in one thread.

mod battery;
mod body;
mod clearance;
mod collisions;
mod contact;
mod drive;
#[cfg(feature = "driver")]
pub mod driver;
mod faults;
mod floor_crew;
mod localisation;
mod obstacle;
mod people;
mod random_streams;
mod range_finder;
mod scenario;
mod station;
#[cfg(test)]
mod testing;
mod world;

pub use drive::{Refusal, WATCHDOG};
pub use faults::{Fault, FaultEntry, ProcessAction};
pub use scenario::*;
pub use world::{STEP, World};
