//! `oxplow bench` on a few small instances; skipped where the instances are not there.

use std::{
    path::Path,
    process::{Command, Output},
};

fn bench(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_oxplow")).arg("bench").args(arguments).output().expect("oxplow runs")
}

/// The tables that a quick run prints, or nothing where there are no instances.
fn quick(name: &str) -> Option<String> {
    let instances = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/instances");
    if !instances.exists() {
        println!("skipped: {} is not there", instances.display());
        return None;
    }
    let out = tempfile::tempdir().expect("a folder for the tables");
    let (folder, out_path) = (instances.display().to_string(), out.path().display().to_string());
    let output = bench(&[name, "--quick", "--instances", &folder, "--out", &out_path]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let written = std::fs::read_dir(out.path()).expect("tables are written").count();
    assert!(written >= 2, "a CSV and a Markdown file for each table");
    Some(String::from_utf8(output.stdout).expect("tables are UTF-8"))
}

/// Fields of the rows of Markdown tables whose entry in column `column` is `word`.
fn rows(text: &str, column: usize, word: &str) -> Vec<Vec<String>> {
    let fields =
        |line: &str| line.trim_matches('|').split('|').map(|field| field.trim().to_owned()).collect();
    let rows = text.lines().filter(|line| line.starts_with('|')).map(fields);
    rows.filter(|row: &Vec<String>| row.get(column).is_some_and(|field| field == word)).collect()
}

#[test]
fn tables_of_the_tmstc_paper() {
    let Some(text) = quick("tmstc") else { return };
    let timed: Vec<_> = rows(&text, 3, "tmstc-star").into_iter().filter(|row| row.len() == 9).collect();
    assert_eq!(timed.len(), 4, "one map, two teams, two modes");
    for row in timed {
        let to_authors: f64 = row[6].parse().expect("a ratio");
        assert!(to_authors <= 1.01, "{row:?}");
    }
}

#[test]
fn figure_6_of_the_mfc_paper() {
    let Some(text) = quick("mfc") else { return };
    let ratios: Vec<f64> = rows(&text, 4, "mfc").iter().map(|row| row[7].parse().expect("a ratio")).collect();
    assert_eq!(ratios.len(), 8, "four teams, two modes");
    assert!(ratios.iter().all(|ratio| (1.0..1.6).contains(ratio)), "{ratios:?}");
}

#[test]
fn grid_instances() {
    let Some(text) = quick("grid") else { return };
    let bounds: Vec<f64> = rows(&text, 3, "forest-search")
        .iter()
        .filter(|row| row.len() == 9)
        .map(|row| row[5].parse().expect("a ratio"))
        .collect();
    assert!(bounds.len() > 3 && bounds.iter().all(|ratio| *ratio >= 1.0), "{bounds:?}");
}

#[test]
fn a_hall_with_people() {
    let Some(text) = quick("people") else { return };
    let rows = rows(&text, 0, "10");
    assert_eq!(rows.len(), 1, "{text}");
    let covered_percent: f64 = rows[0][2].parse().expect("a number");
    assert!(covered_percent > 5.0, "a quick run sees the begin of the day: {text}");
    assert_eq!([&rows[0][8], &rows[0][10]], ["0", "0"], "contacts, stranded: {text}");
}

#[test]
fn missing_instances_are_named_with_the_way_out() {
    let output = bench(&["tmstc", "--instances", "/nowhere"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1));
    assert!(said.contains("/nowhere/tmstc") && said.contains("--instances"), "{said}");
}

#[test]
fn a_document_without_marks_is_left_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("page.md");
    std::fs::write(&path, "# Mine\n").expect("written");
    let output = bench(&["growth", "--quick", "--docs", &path.display().to_string()]);
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(std::fs::read_to_string(&path).expect("read"), "# Mine\n");
}
