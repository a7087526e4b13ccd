//! Floors as robots map them, straight from ROS `map_server` files: tilted, ragged and speckled, with ground behind
//! doors that are too narrow. Each is covered as far as a body gets; what is left is named with its reason.

use protocol::v1::MissionState;
use sim::{Options, Rehearsal, Scenario};
use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

/// Two robots at stations of the instance (`docs` of the instances: stations 0 and 1, radius, tool, speed).
fn scenario(map: &str, robot: [f64; 3], stations: [(f64, f64); 2]) -> Option<Scenario> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/instances/indoor");
    if !folder.join(map).is_file() {
        println!("skipped: {} is not here", folder.join(map).display());
        return None;
    }
    let [body_radius_m, tool_width_m, speed_m_per_s] = robot;
    let mut text = format!(
        "[mission]\nmap = \"{map}\"\n[robot]\nbody_radius_m = {body_radius_m}\ntool_width_m = {tool_width_m}\n\
         speed_m_per_s = {speed_m_per_s}\nangular_speed_rad_per_s = 1.0\n"
    );
    for (number, (x_m, y_m)) in stations.into_iter().enumerate() {
        write!(text, "[[robots]]\nid = \"r{}\"\nx_m = {x_m}\ny_m = {y_m}\n", number + 1)
            .expect("a String takes all");
    }
    Some(Scenario::parse(&text, &folder.join("mine.toml")).unwrap_or_else(|error| panic!("{error}")))
}

fn covers(map: &str, robot: [f64; 3], stations: [(f64, f64); 2]) {
    let Some(scenario) = scenario(map, robot, stations) else { return };
    let outcome =
        Rehearsal::run(&Arc::new(scenario), 1, Options::default(), None).expect("the floor is sound");
    let result = outcome.result.clone().expect("it ends");
    let progress = result.progress.expect("it has progress");
    println!(
        "{map}: {} {:.2} % of {:.1} m² in {:.0} s, {:.1} m² untouchable, {} gaps",
        result.mission_state().as_str_name(),
        progress.covered_percent,
        progress.coverable_m2,
        result.duration_s,
        progress.untouchable_m2,
        result.gaps.len()
    );
    assert_eq!(outcome.violations, [], "{}", outcome.transcript.text());
    assert_eq!(outcome.contacts, 0);
    let ended = result.mission_state();
    assert!(
        matches!(ended, MissionState::Completed | MissionState::CompletedWithGaps),
        "{}",
        ended.as_str_name()
    );
    let too_narrow = |gap: &protocol::v1::Gap| gap.reason().as_str_name() == "TOO_NARROW";
    assert!(result.gaps.iter().all(too_narrow), "{:?}", result.gaps);
    assert!(progress.untouchable_m2 > 0.0);
}

#[test]
fn a_depot() {
    covers("depot.yaml", [0.25, 0.5, 0.5], [(3.325, 4.075), (2.875, 12.325)]);
}

#[test]
fn a_tilted_basement_with_speckles() {
    covers("basement.yaml", [0.22, 0.5, 0.4], [(7.775, 4.725), (21.025, 6.625)]);
}

#[test]
fn a_furnished_flat() {
    covers("small_house.yaml", [0.17, 0.3, 0.3], [(15.725, 5.625), (11.425, 9.525)]);
}

/// A door of 0.5 m and a body of 0.6 m: the room behind is named before the start, ends as a gap, and the rest is covered.
#[test]
fn a_room_behind_a_door_narrower_than_the_robot_is_named() {
    let rows =
        ["........@.......", "........@.......", "................", "........@.......", "........@......."];
    let map =
        format!("type octile\nheight {}\nwidth {}\nmap\n{}\n", rows.len(), rows[0].len(), rows.join("\n"));
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    std::fs::write(folder.join("narrow_door.map"), map).expect("the folder can be written");
    let text = "[mission]\nmap = \"narrow_door.map\"\nmetres_per_character = 0.5\n[robot]\nbody_radius_m = 0.3\n\
                [[robots]]\nid = \"r1\"\nx_m = 1.25\ny_m = 1.25\n";
    let scenario = Scenario::parse(text, &folder.join("mine.toml")).unwrap_or_else(|error| panic!("{error}"));
    let outcome =
        Rehearsal::run(&Arc::new(scenario), 1, Options::default(), None).expect("the floor is sound");
    let result = outcome.result.clone().expect("it ends");
    assert_eq!(outcome.violations, [], "{}", outcome.transcript.text());
    assert_eq!(result.mission_state(), MissionState::CompletedWithGaps);
    let [gap] = &result.gaps[..] else { panic!("{:?}", result.gaps) };
    let centre = gap.centre.expect("it is somewhere");
    assert!(gap.reason().as_str_name() == "TOO_NARROW" && centre.x_m > 4.5, "{gap:?}");
    let progress = result.progress.expect("it has progress");
    let covered = progress.covered_percent;
    assert!((45.0..55.0).contains(&covered), "{covered} %");
    // Said before the first plan, too, and with the same area.
    let text = outcome.transcript.text();
    let said = text.find("OUT OF REACH").expect("it is said");
    assert!(said < text.find("START").expect("it is planned"), "{text}");
    let [part] = &result.out_of_reach[..] else { panic!("{:?}", result.out_of_reach) };
    assert_eq!(part, gap);
    assert!((progress.out_of_reach_m2 - gap.area_m2).abs() < 1e-9, "{} m²", progress.out_of_reach_m2);
}
