//! A table of results: Markdown for people, CSV for programs.

use crate::Picture;
use std::fmt::Write as _;

/// A table. All cells are text; numbers are formatted by those who know them.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Name of its files, without ending.
    pub name: String,
    /// Head line.
    pub title: String,
    /// What the columns mean, and on what conditions it was measured. Markdown.
    pub note: String,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// One entry per column in each.
    pub rows: Vec<Vec<String>>,
    /// What belongs to it.
    pub pictures: Vec<Picture>,
}

impl Table {
    /// A table without rows.
    pub fn new(name: &str, title: &str, note: &str, columns: &[&str]) -> Self {
        Self {
            name: name.to_owned(),
            title: title.to_owned(),
            note: note.to_owned(),
            columns: columns.iter().map(|&column| column.to_owned()).collect(),
            rows: Vec::new(),
            pictures: Vec::new(),
        }
    }

    /// Adds a row.
    pub fn push(&mut self, row: Vec<String>) {
        assert_eq!(row.len(), self.columns.len(), "one entry per column");
        self.rows.push(row);
    }

    /// As Markdown, with title, note, and links to its pictures in `folder` (as [`Picture::markdown`] has it).
    pub fn markdown_with_pictures(&self, folder: &str) -> String {
        let pictures = self.pictures.iter().map(|picture| format!("\n{}", picture.markdown(folder)));
        self.markdown() + &pictures.collect::<String>()
    }

    /// As Markdown, with title and note.
    pub fn markdown(&self) -> String {
        let mut text = format!("### {}\n\n{}\n\n", self.title, self.note);
        let mut line = |cells: &[String]| {
            let _ = writeln!(text, "| {} |", cells.join(" | "));
        };
        line(&self.columns);
        let numeric = |column: usize| {
            self.rows.iter().all(|row| {
                row[column].starts_with(|c: char| c.is_ascii_digit() || "-+–".contains(c))
                    || row[column].is_empty()
            })
        };
        let rule = |column| if numeric(column) { "--:".to_owned() } else { "---".to_owned() };
        line(&(0..self.columns.len()).map(rule).collect::<Vec<_>>());
        for row in &self.rows {
            line(row);
        }
        text
    }

    /// As CSV, head line first.
    pub fn csv(&self) -> String {
        let mut writer = csv::Writer::from_writer(Vec::new());
        for row in std::iter::once(&self.columns).chain(&self.rows) {
            writer.write_record(row).expect("writing to memory does not fail");
        }
        let bytes = writer.into_inner().expect("flushing to memory does not fail");
        String::from_utf8(bytes).expect("it was written from text")
    }
}

/// A number with one digit after the point.
pub(crate) fn tenths(value: f64) -> String {
    format!("{value:.1}")
}

/// A ratio.
pub(crate) fn ratio(value: f64) -> String {
    format!("{value:.3}")
}

/// Mean of some numbers; NaN of none.
pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_written_both_ways() {
        let mut table = Table::new("t", "Title", "Note.", &["map", "s"]);
        table.push(vec!["a, b".to_owned(), tenths(1.25)]);
        assert_eq!(table.csv(), "map,s\n\"a, b\",1.2\n");
        assert_eq!(table.markdown(), "### Title\n\nNote.\n\n| map | s |\n| --- | --: |\n| a, b | 1.2 |\n");
        table.pictures.push(Picture::new("p", "Caption", String::new()));
        assert!(table.markdown_with_pictures("bench").ends_with("| 1.2 |\n\n![Caption](bench/p.svg)\n"));
    }
}
