//! S2: no robot ever touches a wall or an obstacle, nor drives into a person. A person who walks into a standing
//! robot is none of our doing.

use super::{Checker, Seen};
use crate::world::World;

pub(super) struct NoObstacleEntered;

impl Checker for NoObstacleEntered {
    fn look(&mut self, world: &mut World, seen: &Seen<'_>) -> Option<String> {
        let Seen::Contact(contact) = seen else { return None };
        let ours = world.robot_index(&contact.other).is_none() && !contact.person_walked_into;
        ours.then(|| format!("{} drives into {}", contact.serial_number, contact.other))
    }
}
