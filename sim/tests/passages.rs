//! Two rooms, and a corridor at a slant between them that is hardly wider than the body: no straight move of the lattice
//! leads through it, a passage does. Whatever happens to a robot in there, it gets out again.

use protocol::v1::MissionState;
use sim::{Options, Outcome, Rehearsal, Scenario};
use std::path::Path;
use std::sync::Arc;

/// Squares of 0.05 m.
const COLUMNS: i32 = 120;
const ROWS: i32 = 60;

/// Writes the floor as a map of ROS; the corridor is so many squares wide.
fn map(folder: &Path, width: i32) -> String {
    let is_free = |x: i32, y: i32| !(30..90).contains(&x) || (y * 100 - x * 37 - 900).abs() < width * 53;
    let mut picture = format!("P5\n{COLUMNS} {ROWS}\n255\n").into_bytes();
    for y in (0..ROWS).rev() {
        picture.extend((0..COLUMNS).map(|x| if is_free(x, y) { 254 } else { 0 }));
    }
    let header = format!(
        "image: slanted_{width}.pgm\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\n\
         free_thresh: 0.196\n"
    );
    let name = format!("slanted_{width}.yaml");
    std::fs::write(folder.join(format!("slanted_{width}.pgm")), picture).expect("the folder can be written");
    std::fs::write(folder.join(&name), header).expect("the folder can be written");
    name
}

/// What happens when a robot starts in the room on the left; nothing may be broken.
fn played(width: i32, more: &str) -> Outcome {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let text = format!(
        "[mission]\nmap = \"{}\"\nreturn_to_start = true\n[robot]\nbody_radius_m = 0.25\ntool_width_m = 0.6\n\
         [[robots]]\nid = \"r1\"\nx_m = 0.6\ny_m = 1.4\n{more}",
        map(folder, width)
    );
    let scenario =
        Scenario::parse(&text, &folder.join("mine.toml")).unwrap_or_else(|error| panic!("{error}"));
    let outcome =
        Rehearsal::run(&Arc::new(scenario), 1, Options::default(), None).expect("the floor is sound");
    println!("{}", outcome.transcript.text());
    assert_eq!(outcome.violations, []);
    assert_eq!(outcome.contacts, 0);
    outcome
}

/// The mission covers all that there is.
fn assert_whole(outcome: &Outcome) {
    let result = outcome.result.as_ref().expect("it ends");
    assert_eq!(result.mission_state(), MissionState::Completed);
    assert_eq!((&result.gaps[..], &result.out_of_reach[..]), (&[][..], &[][..]));
    let covered = result.progress.expect("it has progress").covered_percent;
    assert!((covered - 100.0).abs() < 1e-9, "{covered} %");
}

#[test]
fn the_other_room_is_covered_by_way_of_a_passage() {
    let outcome = played(15, "");
    assert_whole(&outcome);
    assert!(outcome.transcript.text().contains("GOES"));
}

#[test]
fn a_robot_that_starts_anew_in_a_passage_goes_on() {
    let restart = "[[fault]]\nkind = \"restart\"\nrobot = \"r1\"\nafter_s = 2.0\nat_s = 36.5\n";
    let outcome = played(15, restart);
    assert!(outcome.transcript.text().contains("RESTARTED"));
    assert_whole(&outcome);
}

#[test]
fn a_passage_that_is_shut_for_a_while_is_taken_later() {
    let block = "[[fault]]\nkind = \"block\"\nx_m = 4.3\ny_m = 2.05\nwidth_m = 0.3\nheight_m = 0.3\nfor_s = 40.0\n\
                 at_s = 33.0\n";
    let outcome = played(15, block);
    assert!(outcome.transcript.text().contains("LOOKS"));
    assert_whole(&outcome);
}

/// No way for the body: the other room is out of reach, until a robot joins in there.
#[test]
fn who_joins_beyond_covers_what_was_out_of_reach() {
    let late = "[[robots]]\nid = \"r2\"\nx_m = 5.4\ny_m = 1.4\n\
                [[fault]]\nkind = \"restart\"\nrobot = \"r2\"\nafter_s = 20.0\nat_s = 0.0\n";
    let outcome = played(13, late);
    let text = outcome.transcript.text();
    let (said, joined) = (text.find("OUT OF REACH"), text.find("r2     JOINED"));
    assert!(said.expect("it is said") < joined.expect("it joins"), "{text}");
    assert_whole(&outcome);
}
