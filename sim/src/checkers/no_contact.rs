//! S1: no robot ever touches another.

use super::{Checker, Seen};
use crate::world::World;

pub(super) struct NoContact;

impl Checker for NoContact {
    fn look(&mut self, world: &mut World, seen: &Seen<'_>) -> Option<String> {
        let Seen::Contact(contact) = seen else { return None };
        world.robot_index(&contact.other)?;
        Some(format!("{} and {} touch", contact.serial_number, contact.other))
    }
}
