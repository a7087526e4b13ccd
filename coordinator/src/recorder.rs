//! The log: every message of the wire, as MCAP.

use crate::Publication;
use protocol::v1;

/// One thing to be logged.
#[derive(Debug, Clone)]
pub enum Record {
    /// From a robot.
    Factsheet(Box<v1::Factsheet>),
    /// From a robot.
    Connection(v1::Connection),
    /// From a robot.
    State(Box<v1::State>),
    /// To a robot.
    Order {
        /// The robot.
        robot: String,
        /// What was sent.
        order: v1::Order,
    },
    /// To a robot.
    Grant {
        /// The robot.
        robot: String,
        /// What was sent.
        grant: v1::Grant,
    },
    /// To a robot.
    InstantActions {
        /// The robot.
        robot: String,
        /// What was sent.
        actions: v1::InstantActions,
    },
    /// To those who watch.
    Publication(Publication),
    /// From a person.
    Operator(v1::OperatorCommand),
    /// From the sim.
    Truth(Box<v1::GroundTruth>),
    /// From the sim.
    Contact(v1::Contact),
    /// From the sim.
    Fault(v1::FaultInjected),
    /// From the driver.
    Transport(v1::TransportStats),
}
