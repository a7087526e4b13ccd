//! A clock that runs `factor` times as fast as the machine's.

use protocol::Timestamp;
use std::time::{Duration, Instant};

/// Time since a start, times a factor. Each process has its own; none is ever set.
#[derive(Debug, Clone, Copy)]
pub struct Clock {
    start: Instant,
    factor: f64,
}

impl Clock {
    /// A clock that begins now.
    pub fn start(factor: f64) -> Self {
        assert!(factor.is_finite() && factor > 0.0, "a clock runs forwards");
        Self { start: Instant::now(), factor }
    }

    /// The time.
    pub fn now(&self) -> Timestamp {
        Timestamp::from_secs_f64(self.start.elapsed().as_secs_f64() * self.factor)
    }

    /// How many times faster than the machine's clock it runs.
    pub fn factor(&self) -> f64 {
        self.factor
    }

    /// How long on the machine's clock until a moment; zero when it is past.
    pub fn until(&self, moment: Timestamp) -> Duration {
        Duration::from_secs_f64(moment.secs_since(self.now()) / self.factor)
    }

    /// Waits until a moment.
    pub fn sleep_until(&self, moment: Timestamp) {
        std::thread::sleep(self.until(moment));
    }
}
