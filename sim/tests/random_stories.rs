//! Random faults under checkers: whatever goes wrong, nobody is touched, nothing is claimed that was not swept,
//! and in the end everything that can be reached is covered.
//!
//! `STORIES=79..80 cargo test -p sim --test random_stories -- --nocapture` plays other stories, and shows them.

use sim::{Options, Outcome, Rehearsal, random_story};
use std::ops::Range;

/// Played in every test run.
const STORIES: Range<u64> = 0..100;

fn wanted() -> Option<Range<u64>> {
    let text = std::env::var("STORIES").ok()?;
    let (from, to) = text.split_once("..").expect("STORIES=FROM..TO");
    Some(from.parse().expect("a number")..to.parse().expect("a number"))
}

fn play(seed: u64) -> Outcome {
    let options = Options { virtual_max_s: 1800.0, ..Options::default() };
    Rehearsal::run(&random_story(seed), seed, options, None).expect("the floor is sound")
}

#[test]
fn no_story_breaks_an_invariant() {
    let shown = wanted();
    let mut broken = Vec::new();
    for seed in shown.clone().unwrap_or(STORIES) {
        let outcome = play(seed);
        if shown.is_some() {
            println!("{}", outcome.transcript.text());
        }
        for violation in outcome.violations.iter().take(3) {
            broken.push(format!("story {seed}: {violation}"));
        }
    }
    let replay = "replay with STORIES=N..N+1 cargo test -p sim --test random_stories -- --nocapture";
    assert!(broken.is_empty(), "{}\n{replay}", broken.join("\n"));
}

#[test]
fn the_same_story_reads_the_same_twice() {
    for seed in [3, 4] {
        let (once, again) = (play(seed), play(seed));
        assert_eq!(once.transcript.text(), again.transcript.text());
        assert_eq!(once.violations, again.violations);
    }
}
