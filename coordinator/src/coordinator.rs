//! One match over everything that can happen.

use crate::{Config, Input, Output};
use protocol::Timestamp;
use terrain::FloorError;

/// The state machine.
#[derive(Debug)]
pub struct Coordinator {}

impl Coordinator {
    /// A coordinator for one mission.
    ///
    /// # Errors
    ///
    /// [`FloorError`] when the robots of the mission fit nowhere on its map.
    pub fn new(_config: Config) -> Result<Self, FloorError> {
        todo!("coordinator work")
    }

    /// Takes in one input at time `now` and returns what has to be done about it.
    pub fn handle(&mut self, _now: Timestamp, _input: Input) -> Vec<Output> {
        todo!("coordinator work")
    }

    /// When to be woken if nothing else happens, and why.
    pub fn next_wakeup(&self) -> Option<(Timestamp, &'static str)> {
        todo!("coordinator work")
    }

    /// Whether the mission has ended.
    pub fn ended(&self) -> bool {
        todo!("coordinator work")
    }
}
