//! One event, one line, for a person at night:
//! `00:03:12.4  r3  LOST  no state for 0.5 s → 41 cells to r1 (+38 s), r5 (+12 s)`.

use crate::palette::{self, paint};
use protocol::Timestamp;

/// The words that mean that the fleet lost something, and those that mean that it got something back.
const LOSSES: &[&str] =
    &["LOST", "HUNG", "STUCK", "FAILED", "STRANDED", "CONTACT", "ERROR", "CANCELLED", "ABANDONED"];
const CARES: &[&str] =
    &["SUSPECT", "BLOCKED", "QUARANTINE", "LOW_BATTERY", "SLOW", "DEADLOCK", "FAULT", "GAP"];
const GAINS: &[&str] = &["JOINED", "CLEARED", "CHARGED", "RECOVERED", "COMPLETED"];

/// The line of an event at `at` of mission time. Without a robot it is about the fleet. Control characters in
/// what others said are left out, so that a line stays a line.
pub fn event_line(at: Timestamp, robot: &str, event: &str, text: &str, colour: bool) -> String {
    let robot = if robot.is_empty() { "fleet" } else { robot };
    let time = paint(&at.to_string(), palette::DIM, colour);
    let robot = paint(&printable(robot), palette::CYAN, colour);
    let word = paint(&printable(event), tone(event), colour);
    format!("{time}  {robot}  {word}  {}", printable(text)).trim_end().to_owned()
}

fn tone(event: &str) -> &'static str {
    let is_in = |words: &[&str]| words.contains(&event);
    if is_in(LOSSES) {
        palette::RED
    } else if is_in(CARES) {
        palette::YELLOW
    } else if is_in(GAINS) {
        palette::GREEN
    } else {
        palette::BOLD
    }
}

/// A text without what would move a terminal's cursor.
pub(crate) fn printable(text: &str) -> String {
    text.chars().map(|character| if character.is_control() { ' ' } else { character }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_event_reads_as_the_contract_says() {
        let text = "no state for 0.5 s → 41 cells to r1 (+38 s), r5 (+12 s)";
        let line = event_line(Timestamp::from_secs_f64(192.44), "r3", "LOST", text, false);
        assert_eq!(line, "00:03:12.4  r3  LOST  no state for 0.5 s → 41 cells to r1 (+38 s), r5 (+12 s)");
    }

    #[test]
    fn colour_adds_nothing_but_colour() {
        let plain = event_line(Timestamp::ZERO, "", "COMPLETED", "96 m² in 80 s", false);
        let painted = event_line(Timestamp::ZERO, "", "COMPLETED", "96 m² in 80 s", true);
        assert!(painted.contains("\x1b[32mCOMPLETED\x1b[0m"));
        let mut bare = painted;
        for code in ["\x1b[0m", "\x1b[2m", "\x1b[36m", "\x1b[32m"] {
            bare = bare.replace(code, "");
        }
        assert_eq!(bare, plain);
    }

    #[test]
    fn a_robot_cannot_move_the_cursor() {
        let line = event_line(Timestamp::ZERO, "r1", "SAID", "\x1b[2J\nall is well", false);
        assert_eq!(line, "00:00:00.0  r1  SAID   [2J all is well");
    }
}
