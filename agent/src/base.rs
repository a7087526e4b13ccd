//! The robot under the agent: what it measures, and what it is told.

use protocol::v1;
use thiserror::Error;

/// Why a base cannot be talked to.
#[derive(Debug, Clone, Error, PartialEq)]
pub enum BaseError {
    /// The bus to the robot is broken.
    #[error("the link to the robot's base is broken: {0}")]
    Broken(String),
}

/// A robot's base: the simulated one over iceoryx2, a stand-in in memory, or a driver for a real robot.
pub trait Base {
    /// What was measured since the last call, oldest first, one a call; `None` when there is nothing new.
    ///
    /// # Errors
    ///
    /// [`BaseError::Broken`].
    fn read(&mut self) -> Result<Option<v1::BaseState>, BaseError>;

    /// Tells the base what to do until the next setpoint.
    ///
    /// # Errors
    ///
    /// [`BaseError::Broken`].
    fn write(&mut self, setpoint: &v1::Setpoint) -> Result<(), BaseError>;
}
