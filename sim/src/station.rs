//! Charging stations: a robot that stands on one is charged, as long as it works.

use crate::world::World;
use protocol::Timestamp;
use terrain::Point;

/// So near must the middle of a robot be, metres.
const REACH_M: f64 = 0.15;

/// A station in the world.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Charger {
    pub(crate) id: String,
    pub(crate) position: Point,
    pub(crate) outage: Option<Outage>,
}

/// A station is out of order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Outage {
    pub(crate) until: Option<Timestamp>,
}

impl World {
    /// Repairs stations whose outage is over, and sees who stands on which.
    pub(crate) fn dock(&mut self) {
        for charger in &mut self.chargers {
            if charger.outage.is_some_and(|outage| outage.until.is_some_and(|until| self.now >= until)) {
                charger.outage = None;
            }
        }
        for body in &mut self.bodies {
            let at = body.position();
            let touches =
                |charger: &Charger| charger.outage.is_none() && (charger.position - at).norm() <= REACH_M;
            let stands = body.on_floor && body.speed_m_per_s == 0.0;
            body.docked = if stands { self.chargers.iter().position(touches) } else { None };
        }
    }

    /// Gives the docked robots what `step_s` is worth.
    pub(crate) fn charge(&mut self, step_s: f64) {
        for body in self.bodies.iter_mut().filter(|body| body.docked.is_some()) {
            body.battery.charge(step_s);
        }
    }
}
