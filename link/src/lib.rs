//! How the processes of a fleet are joined.
//!
//! ```text
//!   coordinator ◀── zenoh, one router session ──▶ agents, sim, command line (clients)
//!   sim         ◀── iceoryx2, one bus per robot ──▶ agent
//! ```
//!
//! Only drivers use this crate. It holds no decisions: settings as they were measured, opening with retries that
//! can be given up, and a clock that may run faster than the machine's.
#![expect(
    clippy::disallowed_methods,
    reason = "clocks and waiting live in drivers, and here for all of them"
)]

mod bus;
mod clock;
mod session;

pub use bus::{AgentEnd, BodyEnd, Bus, BusError, remove_left_behind};
pub use clock::Clock;
pub use session::{Endpoint, Urgency, bound_port, get, open_client, open_router, put};
