//! Scenario files: the default file is the reference, the schema is up to date, and what is wrong is refused with
//! file, line and key.

use sim::{Scenario, ScenarioFile, scenario_schema};
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(name: &str) -> String {
    std::fs::read_to_string(root().join(name)).expect(name)
}

/// What is said about a scenario in the folder `scenarios`.
fn refusal(text: &str) -> String {
    let path = root().join("scenarios/mine.toml");
    Scenario::parse(text, &path).map(|_| ()).expect_err("it is refused").to_string()
}

fn with(lines: &str) -> String {
    format!("[mission]\nmap = \"../maps/demo.map\"\nmetres_per_character = 0.5\n{lines}")
}

const TWO: &str =
    "[[robots]]\nid = \"r1\"\nx_m = 1.25\ny_m = 1.25\n[[robots]]\nid = \"r2\"\nx_m = 3.25\ny_m = 1.25\n";

#[test]
fn the_default_file_states_the_defaults() {
    let stated: ScenarioFile = toml::from_str(&read("scenarios/default.toml")).expect("it parses");
    let least: ScenarioFile = toml::from_str("[mission]\nmap = \"m.map\"").expect("it parses");
    assert_eq!(stated.robot, least.robot);
    assert_eq!(stated.coordinator, least.coordinator);
    assert_eq!(stated.sim, least.sim);
    assert_eq!(stated.network, least.network);
    assert_eq!(stated.mission.planner, least.mission.planner);
    assert_eq!(stated.mission.id, least.mission.id);
    assert!((stated.cell_m() - least.cell_m()).abs() < 1e-12);
}

#[test]
fn the_reference_names_every_key_and_the_default_file_all_but_those_of_faults() {
    let schema = serde_json::to_value(scenario_schema()).expect("a schema is JSON");
    let (default, reference) = (read("scenarios/default.toml"), read("docs/scenario.md"));
    let (mut keys, mut of_faults) = (Vec::new(), Vec::new());
    collect_keys(&schema["$defs"]["FaultEntry"], &mut of_faults);
    collect_keys(&schema, &mut keys);
    assert!(keys.len() > 70, "{}", keys.len());
    for key in keys {
        let in_heading = reference.contains(&format!("[{key}]"));
        assert!(in_heading || reference.contains(&format!("`{key}`")), "docs/scenario.md: no `{key}`");
        assert!(of_faults.contains(&key) || default.contains(&key), "scenarios/default.toml: no `{key}`");
    }
}

fn collect_keys(schema: &serde_json::Value, keys: &mut Vec<String>) {
    if let Some(properties) = schema.get("properties").and_then(|properties| properties.as_object()) {
        keys.extend(properties.keys().cloned());
    }
    match schema {
        serde_json::Value::Object(map) => map.values().for_each(|value| collect_keys(value, keys)),
        serde_json::Value::Array(list) => list.iter().for_each(|value| collect_keys(value, keys)),
        _ => {}
    }
}

/// `WRITE=1 cargo test -p sim --test scenario_files` writes it anew.
#[test]
fn the_schema_file_is_up_to_date() {
    let schema = serde_json::to_string_pretty(&scenario_schema()).expect("a schema is JSON") + "\n";
    let path = root().join("docs/scenario.schema.json");
    if std::env::var_os("WRITE").is_some() {
        std::fs::write(&path, &schema).expect("it can be written");
    }
    let written = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(written == schema, "docs/scenario.schema.json is stale: run the test with WRITE=1");
}

#[test]
fn every_scenario_of_ours_is_sound() {
    let stories = std::fs::read_dir(root().join("scenarios/stories")).expect("stories");
    let ours = std::fs::read_dir(root().join("scenarios")).expect("scenarios").chain(stories);
    for entry in ours {
        let path = entry.expect("a file").path();
        let is_ours = path.extension().is_some_and(|extension| extension == "toml");
        if is_ours && !path.ends_with("denver_2.toml") {
            Scenario::load(&path).unwrap_or_else(|error| panic!("{error}"));
        }
    }
}

#[test]
fn a_missing_map_is_named_with_its_path() {
    let said = refusal("[mission]\nmap = \"no.map\"\n[fleet]\ncount = 1\n");
    assert!(said.contains("scenarios/no.map") && said.contains("beside the scenario file"), "{said}");
}

#[test]
fn an_unknown_key_is_named_with_its_line() {
    let said = refusal(&with("sede = 3\n[fleet]\ncount = 1\n"));
    assert!(said.contains("mine.toml:4: ") && said.contains("`sede`"), "{said}");
}

#[test]
fn not_a_number_is_refused() {
    let said = refusal(&with(&TWO.replace("x_m = 3.25", "x_m = nan")));
    assert!(said.contains("mine.toml:10: `robots[1].x_m`"), "{said}");
    let said = refusal(&with(&format!("[robot]\nspeed_m_per_s = nan\n{TWO}")));
    assert!(said.contains("`robot.speed_m_per_s`: is NaN"), "{said}");
}

#[test]
fn two_robots_with_one_id_are_refused() {
    let said = refusal(&with(&TWO.replace("r2", "r1")));
    assert!(said.contains("`robots[1].id`") && said.contains("twice"), "{said}");
}

#[test]
fn a_bad_id_is_refused() {
    let said = refusal(&with(&TWO.replace("r2", "r/2")));
    assert!(said.contains("`r/2` is no id"), "{said}");
}

#[test]
fn a_start_in_a_wall_is_refused_with_a_free_place() {
    let said = refusal(&with(&TWO.replace("x_m = 3.25", "x_m = 6.25")));
    assert!(said.contains("in a wall") && said.contains("nearest free place"), "{said}");
}

#[test]
fn starts_in_one_another_are_refused() {
    let said = refusal(&with(&TWO.replace("x_m = 3.25", "x_m = 1.3")));
    assert!(said.contains("in one another"), "{said}");
}

#[test]
fn a_station_in_a_wall_is_refused() {
    let station = "[[stations]]\nid = \"s1\"\nx_m = 6.25\ny_m = 1.25\n";
    let said = refusal(&with(&format!("{TWO}{station}")));
    assert!(said.contains("`stations[0].x_m`") && said.contains("no robot can dock"), "{said}");
}

#[test]
fn a_body_wider_than_every_passage_is_refused() {
    let said = refusal(&with(&format!("[robot]\nbody_radius_m = 4.0\n{TWO}")));
    assert!(said.contains("`robot.body_radius_m`") && said.contains("too narrow"), "{said}");
}

#[test]
fn a_cell_that_the_tool_cannot_sweep_whole_is_refused() {
    let said = refusal(&with(&format!("cell_m = 0.7\n{TWO}")));
    assert!(said.contains("`mission.cell_m`") && said.contains("at most 0.54 m"), "{said}");
}

#[test]
fn a_fault_on_nobody_is_refused_with_who_there_is() {
    let said = refusal(&with(&format!("{TWO}[[fault]]\nkind = \"kill\"\nrobot = \"r7\"\nat_s = 1\n")));
    assert!(said.contains("`fault[0]`") && said.contains("r1, r2"), "{said}");
}

#[test]
fn no_robot_and_both_ways_of_naming_them_are_refused() {
    assert!(refusal(&with("")).contains("there is no robot"));
    assert!(refusal(&with(&format!("[fleet]\ncount = 2\n{TWO}"))).contains("keep one of the two"));
    assert!(refusal(&with("[fleet]\ncount = 4000\n")).contains("lower `count`"));
}
