//! One robot's mind: what can happen to it, and what it does about it.

use protocol::{Timestamp, v1};

/// What can happen to an agent.
#[derive(Debug, Clone, PartialEq)]
pub enum Input {
    /// The base measured something (50 times a second).
    Base(Box<v1::BaseState>),
    /// The coordinator sent an order or an update of one.
    Order(Box<v1::Order>),
    /// The coordinator granted ground, or renewed the lease.
    Grant(v1::Grant),
    /// The coordinator asks for something at once.
    InstantActions(v1::InstantActions),
    /// The link to the coordinator came up or went down.
    Link(bool),
    /// The time asked for by `next_wakeup` has come.
    Woken,
}

/// What an agent asks its driver to do.
#[derive(Debug, Clone, PartialEq)]
pub enum Output {
    /// Send to the base.
    Setpoint(v1::Setpoint),
    /// Send to the coordinator.
    State(Box<v1::State>),
    /// Send to the coordinator.
    Factsheet(Box<v1::Factsheet>),
    /// Send to the coordinator.
    Connection(v1::Connection),
}

/// The state machine.
#[derive(Debug)]
pub struct Agent {}

impl Agent {
    /// An agent for robot `serial_number`; `boot_id` is drawn anew at each start. It knows what its robot is from
    /// the first `BaseState.description`, and does nothing before.
    pub fn new(_serial_number: &str, _boot_id: u64, _pid: u32) -> Self {
        todo!("agent work")
    }

    /// Takes in one input at time `now` on the agent's own clock and returns what has to be done about it.
    pub fn handle(&mut self, _now: Timestamp, _input: Input) -> Vec<Output> {
        todo!("agent work")
    }

    /// When to be woken if nothing else happens, and why.
    pub fn next_wakeup(&self) -> Option<(Timestamp, &'static str)> {
        todo!("agent work")
    }
}
