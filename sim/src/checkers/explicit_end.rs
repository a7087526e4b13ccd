//! L8: the mission ends, and says how.

use super::{Checker, Seen};
use crate::world::World;

pub(super) struct ExplicitEnd;

impl Checker for ExplicitEnd {
    fn look(&mut self, world: &mut World, seen: &Seen<'_>) -> Option<String> {
        match seen {
            Seen::End { result: None, .. } => {
                Some(format!("no end after {:.0} s", world.now().as_secs_f64()))
            }
            _ => None,
        }
    }
}
