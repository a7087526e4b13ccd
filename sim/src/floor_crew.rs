//! The floor crew: people who take a dead machine off the floor, and put it back when its agent runs again.
//!
//! This is the one thing in the world that helps the fleet: without it a machine that died in a doorway would cut
//! off the ground behind it for ever. `[sim] carry_off_after_s` says how long it takes, or that nobody comes. A
//! machine counts as dead when its agent has been silent for that long; it is kept by its start, where it goes
//! back on the floor as soon as its agent is heard again and the place is free.

use crate::{drive::WATCHDOG, world::World};
use std::time::Duration;

impl World {
    /// Looks at all machines; once a second is enough.
    pub(crate) fn let_the_crew_work(&mut self) {
        for robot in 0..self.bodies.len() {
            let silent_s = self.now.secs_since(self.bodies[robot].heard);
            if self.bodies[robot].on_floor {
                if silent_s >= self.bodies[robot].carry_off_after_s {
                    self.carry_off(robot);
                }
            } else if silent_s < Duration::from_secs(1).max(5 * WATCHDOG).as_secs_f64() {
                self.put_back(robot);
            }
        }
    }

    fn carry_off(&mut self, robot: usize) {
        let (scenario, seed) = (self.scenario.clone(), self.seed);
        self.bodies[robot].carry_off(&scenario, seed);
        let id = self.bodies[robot].id.clone();
        self.tell("carried_off", &id, "the floor crew took the silent machine off the floor");
    }

    fn put_back(&mut self, robot: usize) {
        let at = self.bodies[robot].position();
        if !self.is_free_for_body(at, Some(robot)) {
            return;
        }
        self.bodies[robot].on_floor = true;
        self.bodies[robot].carry_off_after_s = self.scenario.file.sim.carry_off_after_s.seconds();
        let id = self.bodies[robot].id.clone();
        self.tell("put_back", &id, "the floor crew put the machine back at its start");
    }
}
