//! Bad input of every kind: a clear error that names file, line, key or robot, and what to do; nothing else happens.

mod common;

use common::{Fleet, oxplow, scenario};

/// What `oxplow up` says of a scenario, which it must refuse.
#[track_caller]
fn refused(name: &str, text: &str) -> String {
    let fleet = Fleet::new(name, text);
    let output = fleet.up(1.0);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(!fleet.log().exists(), "nothing is run");
    said
}

#[track_caller]
fn assert_names(said: &str, words: &[&str]) {
    for word in words {
        assert!(said.contains(word), "`{word}` is not in: {said}");
    }
}

#[test]
fn a_missing_map_is_named() {
    let said = refused("map", &scenario(2, "").replace("floor.map", "nowhere.map"));
    assert_names(&said, &["nowhere.map", "map"]);
}

#[test]
fn an_unknown_key_is_named_with_its_line() {
    let said = refused("key", &scenario(2, "[sim]\nspede = 3\n"));
    assert_names(&said, &["scenario.toml", "spede"]);
}

#[test]
fn a_pose_that_is_not_a_number_is_named() {
    let robots = "[[robots]]\nid = \"r1\"\nx_m = nan\ny_m = 1.0\n";
    let said = refused("nan", &scenario(2, robots).replace("[fleet]\ncount = 2\nspread = true\n", ""));
    assert_names(&said, &["x_m"]);
}

#[test]
fn two_robots_with_one_id_are_named() {
    let robots =
        "[[robots]]\nid = \"r1\"\nx_m = 1.0\ny_m = 1.0\n[[robots]]\nid = \"r1\"\nx_m = 3.0\ny_m = 1.0\n";
    let said = refused("twice", &scenario(2, robots).replace("[fleet]\ncount = 2\nspread = true\n", ""));
    assert_names(&said, &["r1"]);
}

#[test]
fn a_start_in_a_wall_is_named() {
    let robots = "[[robots]]\nid = \"r7\"\nx_m = 4.9\ny_m = 3.0\n";
    let said = refused("wall", &scenario(2, robots).replace("[fleet]\ncount = 2\nspread = true\n", ""));
    assert_names(&said, &["r7"]);
}

#[test]
fn a_body_wider_than_every_passage_is_said() {
    let said = refused("wide", &scenario(2, "").replace("body_radius_m = 0.177", "body_radius_m = 9.0"));
    assert_names(&said, &["9"]);
}

#[test]
fn a_tool_wider_than_every_passage_is_said() {
    let said = refused("tool", &scenario(2, "").replace("tool_width_m = 0.75", "tool_width_m = 9.0"));
    assert_names(&said, &["tool_width_m", "9 m", "every passage"]);
}

#[test]
fn a_run_is_never_overwritten() {
    let fleet = Fleet::new("twice", &scenario(2, ""));
    std::fs::create_dir_all(fleet.out()).expect("a folder");
    std::fs::write(fleet.log(), b"a run").expect("a file");
    let output = fleet.up(1.0);
    assert_eq!(output.status.code(), Some(1));
    assert_names(&String::from_utf8_lossy(&output.stderr), &["--out"]);
    assert_eq!(std::fs::read(fleet.log()).expect("it is still there"), b"a run");
}

#[test]
fn wrong_usage_is_exit_code_2() {
    for words in
        [vec![], vec!["up"], vec!["fault", "nonsense", "r1"], vec!["agent"], vec!["demo", "--robots", "1"]]
    {
        assert_eq!(oxplow(&words).status.code(), Some(2), "{words:?}");
    }
}

#[test]
fn every_command_has_help_with_an_example() {
    for command in ["demo", "up", "sim", "coordinator", "agent", "fault", "status", "rehearse", "plan"] {
        let output = oxplow(&[command, "--help"]);
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success() && text.contains("Example"), "{command}: {text}");
    }
}
