//! Planned is driven: without faults a robot takes the time that its plan says.
//!
//! What is compared, from what was recorded: the time model's estimate of all places that a robot was ordered to
//! drive, and the time from its first order until it has passed the last of them.

use coordinator::recorder::Record;
use protocol::Timestamp;
use sim::{Options, Rehearsal, Scenario};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use terrain::Point;

fn scenarios() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios")
}

/// What was seen of one robot.
#[derive(Debug, Default)]
struct Track {
    heading_rad: f64,
    ordered: Option<Timestamp>,
    nodes: BTreeMap<(u64, u64), Point>,
    passed: (u64, u64),
    passed_at: Timestamp,
}

/// One rehearsal: planned and driven time of each robot, seconds, and of the whole mission.
#[derive(Debug)]
struct Driven {
    robots: Vec<(String, f64, f64)>,
    makespan: (f64, f64),
    replans: u32,
}

fn rehearse(scenario: &Arc<Scenario>) -> Driven {
    let motion = scenario.file.robot.motion();
    let mut tracks: BTreeMap<String, Track> = BTreeMap::new();
    let mut began: Option<Timestamp> = None;
    let mut done = Timestamp::ZERO;
    let mut sink = |now: Timestamp, record: &Record| match record {
        Record::Order { robot, order } => {
            began.get_or_insert(now);
            let track = tracks.entry(robot.clone()).or_default();
            track.ordered.get_or_insert(now);
            let first = order.nodes.first().map_or(0, |node| node.sequence_id);
            track.nodes.retain(|&(order_id, sequence), _| order_id < order.order_id || sequence < first);
            for node in &order.nodes {
                track.nodes.insert((order.order_id, node.sequence_id), Point::new(node.x_m, node.y_m));
            }
        }
        Record::State(state) => {
            let Some(header) = &state.header else { return };
            let track = tracks.entry(header.serial_number.clone()).or_default();
            if track.ordered.is_none() {
                track.heading_rad = state.pose.map_or(0.0, |pose| pose.theta_rad);
            }
            let passed = (state.order_id, state.last_node_sequence_id);
            if passed > track.passed {
                (track.passed, track.passed_at) = (passed, now);
            }
        }
        Record::Publication(coordinator::Publication::Result(_)) => done = now,
        _ => {}
    };
    let options = Options { virtual_max_s: 7200.0, ..Options::default() };
    let outcome = Rehearsal::run(scenario, 1, options, Some(&mut sink)).expect("the floor is sound");
    assert_eq!(outcome.violations, [], "{}", outcome.transcript.text());
    let result = outcome.result.expect("it ends");
    assert_eq!(result.mission_state().as_str_name(), "COMPLETED", "{}", outcome.transcript.text());
    let robots = tracks
        .iter()
        .map(|(id, track)| {
            let points: Vec<Point> = track.nodes.values().copied().collect();
            let ordered = track.ordered.expect("every robot has work");
            (id.clone(), motion.path_s(&points, Some(track.heading_rad)), track.passed_at.secs_since(ordered))
        })
        .collect();
    let driven_s = done.secs_since(began.expect("there was an order"));
    Driven { robots, makespan: (result.planned_makespan_s, driven_s), replans: result.replans }
}

fn show(name: &str, driven: &Driven) {
    for (id, planned_s, driven_s) in &driven.robots {
        let ratio = driven_s / planned_s;
        println!("{name:24} {id:9} planned {planned_s:8.2} s  driven {driven_s:8.2} s  ratio {ratio:.4}");
    }
    let (planned_s, driven_s) = driven.makespan;
    let (ratio, replans) = (driven_s / planned_s, driven.replans);
    println!(
        "{name:24} makespan  planned {planned_s:8.2} s  driven {driven_s:8.2} s  ratio {ratio:.4}  {replans} replans"
    );
}

fn without_faults(file: &str) -> Arc<Scenario> {
    let mut scenario = Scenario::load(scenarios().join(file)).unwrap_or_else(|error| panic!("{error}"));
    scenario.file.faults.clear();
    Arc::new(scenario)
}

/// Where robots have room, the time model tells what is driven; on crowded floors they wait for one another as well.
#[test]
fn on_floors_with_room_driven_time_is_within_two_percent_of_the_plan() {
    for file in ["office.toml", "denver_2.toml"] {
        let driven = rehearse(&without_faults(file));
        show(file, &driven);
        assert_eq!(driven.replans, 0, "{file}");
        for (id, planned_s, driven_s) in &driven.robots {
            assert!(
                (driven_s / planned_s - 1.0).abs() < 0.02,
                "{file} {id}: {driven_s} s, planned {planned_s} s"
            );
        }
        let (planned_s, driven_s) = driven.makespan;
        assert!((driven_s / planned_s - 1.0).abs() < 0.02, "{file}: {driven_s} s, planned {planned_s} s");
    }
}
