//! What happened, one line each, as a person reads it. Same seed, same transcript, byte by byte.

use coordinator::Publication;
use protocol::{Timestamp, v1};
use std::fmt::Write;

/// The story of one run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Transcript {
    text: String,
}

impl Transcript {
    /// The whole text.
    pub fn text(&self) -> &str {
        &self.text
    }

    pub(crate) fn line(&mut self, now: Timestamp, who: &str, event: &str, text: &str) {
        let who = if who.is_empty() { "fleet" } else { who };
        writeln!(self.text, "{now}  {who:<6} {event}  {text}").expect("a String takes everything");
    }

    /// Events say all that decisions say.
    pub(crate) fn publication(&mut self, now: Timestamp, publication: &Publication) {
        if let Publication::Event(event) = publication {
            self.line(now, &event.serial_number, &event.event, &event.text);
        }
    }

    pub(crate) fn fault(&mut self, now: Timestamp, fault: &v1::FaultInjected) {
        self.line(now, &fault.target, "FAULT", &format!("{}: {}", fault.kind, fault.text));
    }

    pub(crate) fn contact(&mut self, now: Timestamp, contact: &v1::Contact) {
        let at = contact.position.unwrap_or_default();
        let text = format!("with {} at ({:.2}, {:.2}) m", contact.other, at.x_m, at.y_m);
        self.line(now, &contact.serial_number, "CONTACT", &text);
    }
}
