//! Why a scenario is refused: which file, which line, which key, and what to do about it.

use std::path::PathBuf;
use terrain::{FloorError, MapFileError};
use thiserror::Error;
use toml::de::{DeTable, DeValue};

/// Why a scenario cannot be played.
#[derive(Debug, Error)]
pub enum ScenarioError {
    /// The file, or the map it names, cannot be read.
    #[error("{}: {source}; check the path (a map is looked for beside the scenario file)", path.display())]
    Read {
        /// What was looked for.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// No TOML, an unknown key, a value of the wrong kind.
    #[error("{}:{line}: {what}", path.display())]
    Format {
        /// The scenario file.
        path: PathBuf,
        /// Line in it, from 1.
        line: usize,
        /// What is wrong.
        what: String,
    },
    /// A value that makes no sense.
    #[error("{}:{line}: `{key}`: {what}", path.display())]
    Value {
        /// The scenario file.
        path: PathBuf,
        /// Line in it, from 1.
        line: usize,
        /// The key, as `robots[2].x_m`.
        key: String,
        /// What is wrong, and what to do.
        what: String,
    },
    /// The map cannot be read; it is looked for beside the scenario file.
    #[error("mission.map: {0} (a map is looked for beside the scenario file)")]
    Map(#[from] MapFileError),
}

/// A value that makes no sense, before file and line are known.
#[derive(Debug, PartialEq)]
pub(crate) struct Refused {
    pub(crate) key: String,
    pub(crate) what: String,
}

impl Refused {
    pub(crate) fn new(key: impl Into<String>, what: impl Into<String>) -> Self {
        Self { key: key.into(), what: what.into() }
    }

    pub(crate) fn floor(error: &FloorError) -> Self {
        let key = match error {
            FloorError::Length { key: "cell_m", .. } | FloorError::TooManyCells { .. } => "mission.cell_m",
            FloorError::Length { key: "tool_width_m", .. } => "robot.tool_width_m",
            _ => "robot.body_radius_m",
        };
        Self::new(key, error.to_string())
    }
}

/// The line (from 1) on which a key such as `robots[2].x_m` stands; of the longest part of it that is there.
pub(crate) fn line_of(text: &str, key: &str) -> usize {
    line_at(text, place_of(text, key).unwrap_or(0))
}

/// The line (from 1) of a byte.
pub(crate) fn line_at(text: &str, byte: usize) -> usize {
    1 + text.bytes().take(byte).filter(|&byte| byte == b'\n').count()
}

fn place_of(text: &str, key: &str) -> Option<usize> {
    let document = DeTable::parse(text).ok()?;
    let mut table: &DeTable<'_> = document.get_ref();
    let mut place = None;
    for step in key.split('.') {
        let (name, entry) = split_entry(step);
        let Some((found, value)) = table.get_key_value(name) else { break };
        place = Some(found.span().start);
        let mut value: &DeValue<'_> = value.get_ref();
        if let (Some(entry), DeValue::Array(array)) = (entry, value) {
            let Some(item) = array.get(entry) else { break };
            place = Some(item.span().start);
            value = item.get_ref();
        }
        let Some(inner) = value.as_table() else { break };
        table = inner;
    }
    place
}

fn split_entry(step: &str) -> (&str, Option<usize>) {
    match step.split_once('[') {
        Some((name, entry)) => (name, entry.trim_end_matches(']').parse().ok()),
        None => (step, None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str =
        "[mission]\nid = \"m\"\n\n[[robots]]\nid = \"r1\"\n\n[[robots]]\nid = \"r2\"\nx_m = 1.0\n";

    #[test]
    fn a_key_is_found_in_a_table_and_in_an_array_of_tables() {
        assert_eq!(line_of(TEXT, "mission.id"), 2);
        assert_eq!(line_of(TEXT, "robots[1].x_m"), 9);
    }

    #[test]
    fn a_missing_key_gives_the_line_of_its_table() {
        assert_eq!(line_of(TEXT, "robots[1].y_m"), 7);
        assert_eq!(line_of(TEXT, "mission.map"), 1);
    }
}
