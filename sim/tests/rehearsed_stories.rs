//! One small story per kind of fault, rehearsed: scenario in, transcript out. Each names the words that its
//! transcript must have, in this order, and how it ends; no story may break an invariant.

use sim::{Options, Outcome, Rehearsal, Scenario};
use std::path::{Path, PathBuf};
use std::sync::Arc;

fn scenarios() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios")
}

fn rehearse(path: &Path, seed: u64) -> Outcome {
    let scenario = Arc::new(Scenario::load(path).unwrap_or_else(|error| panic!("{error}")));
    let options = Options { virtual_max_s: 7200.0, ..Options::default() };
    Rehearsal::run(&scenario, seed, options, None).expect("the floor is sound")
}

fn state_of(outcome: &Outcome) -> &'static str {
    outcome.result.as_ref().map_or("none", |result| result.mission_state().as_str_name())
}

/// The transcript has these words in this order, the mission ends so, and nothing was broken.
fn tells(story: &str, words: &[&str], end: &str) {
    let outcome = rehearse(&scenarios().join(format!("stories/{story}.toml")), 1);
    let text = outcome.transcript.text();
    let mut rest = text;
    for word in words {
        let at = rest.find(word).unwrap_or_else(|| panic!("no `{word}` (in this order) in\n{text}"));
        rest = &rest[at + word.len()..];
    }
    assert_eq!(outcome.violations, [], "{text}");
    assert_eq!(state_of(&outcome), end, "{text}");
}

#[test]
fn kill() {
    tells("kill", &["FAULT  kill", "r2     SUSPECT", "cells to", "QUARANTINE", "carried_off"], "COMPLETED");
}

#[test]
fn hang() {
    tells("hang", &["FAULT  hang", "r2     SUSPECT", "cells to", "r2     JOINED  is back"], "COMPLETED");
}

#[test]
fn thaw() {
    tells("thaw", &["FAULT  hang", "r3     SUSPECT", "FAULT  thaw", "r3     JOINED"], "COMPLETED");
}

#[test]
fn restart() {
    tells("restart", &["FAULT  restart", "r2     RESTARTED", "r2     JOINED"], "COMPLETED");
}

#[test]
fn cut_link() {
    tells("cut_link", &["FAULT  cut_link", "r2     SUSPECT", "r2     JOINED  is back"], "COMPLETED");
}

#[test]
fn block() {
    tells("block", &["FAULT  block", "BLOCKED  obstacle", "CLEARED"], "COMPLETED");
}

#[test]
fn block_for_ever() {
    tells("block_for_ever", &["FAULT  block", "BLOCKED  obstacle", "LOOKS"], "COMPLETED_WITH_GAPS");
}

#[test]
fn people() {
    tells("people", &["FAULT  people"], "COMPLETED");
}

#[test]
fn queue() {
    tells("queue", &["FAULT  queue: 4 people", "BLOCKED  obstacle", "CLEARED"], "COMPLETED");
}

#[test]
fn battery_drop() {
    tells("battery_drop", &["FAULT  battery_drop", "r2     LOW BATTERY", "r2     CHARGING"], "COMPLETED");
}

#[test]
fn battery_drain() {
    tells("battery_drain", &["FAULT  battery_drain", "r2     LOW BATTERY"], "COMPLETED");
}

#[test]
fn wheel_stuck() {
    tells(
        "wheel_stuck",
        &["FAULT  wheel_stuck", "r2     STUCK", "r2     JOINED  is tried again"],
        "COMPLETED",
    );
}

#[test]
fn wheel_slip() {
    tells("wheel_slip", &["FAULT  wheel_slip"], "COMPLETED");
}

#[test]
fn slow() {
    tells("slow", &["FAULT  slow", "REBALANCED"], "COMPLETED");
}

#[test]
fn station_out_of_order() {
    let words = ["r1     LOW BATTERY", "r1     STATION OUT OF ORDER  s1", "r1     CHARGING  at s2"];
    tells("station_out_of_order", &words, "COMPLETED");
}

#[test]
fn every_kind_of_fault_has_its_story() {
    for kind in sim::Fault::KINDS {
        assert!(scenarios().join(format!("stories/{kind}.toml")).is_file(), "no story of `{kind}`");
    }
}

#[test]
fn the_demo_loses_a_robot_and_completes() {
    let outcome = rehearse(&scenarios().join("demo.toml"), 1);
    assert_eq!((state_of(&outcome), outcome.violations.as_slice()), ("COMPLETED", [].as_slice()));
}

#[test]
fn denver_survives_its_bad_day() {
    let path = scenarios().join("denver_2.toml");
    if !scenarios().join("../../shared/instances/tmstc/denver_2.map").is_file() {
        println!("skipped: ../shared/instances/tmstc/denver_2.map is not here");
        return;
    }
    let outcome = rehearse(&path, 2);
    assert_eq!(outcome.violations, [], "{}", outcome.transcript.text());
    assert!(state_of(&outcome).starts_with("COMPLETED"), "{}", outcome.transcript.text());
}
