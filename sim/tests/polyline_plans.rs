//! Plans that leave the lattice are driven like any other: as planned without faults, and to the last cell with them.
//!
//! With rows of the table, and with a stand-in that rounds the corners of a lattice plan: smooth lines beside the cells'
//! centres, which leave a little unswept. `STORIES=7..8 cargo test -p sim --test polyline_plans -- --nocapture` plays other random
//! stories, and shows them.

use coordinator::{PlanRequest, recorder::Record};
use planner::{Plan, PlanError, PlanOptions, Route, VerifiedPlan, planners::keeps_to_lattice};
use protocol::Timestamp;
use sim::{Options, Outcome, Rehearsal, Scenario, random_story};
use std::{
    collections::BTreeMap,
    f64::consts::FRAC_PI_2,
    ops::Range,
    path::{Path, PathBuf},
    sync::Arc,
};
use terrain::{MotionModel, Point, Segment, Vector};

const ROUNDED: &str = "rounded";

/// A lattice plan with its corners rounded, where there is room.
fn rounded(request: &PlanRequest) -> Result<VerifiedPlan, PlanError> {
    if keeps_to_lattice(&request.options.planner) {
        return request.run();
    }
    let mut on_lattice = request.clone();
    on_lattice.options = PlanOptions { planner: "tmstc-star".to_owned(), ..request.options.clone() };
    on_lattice.incumbent.clear();
    let plan = on_lattice.run()?;
    let routes = plan.routes().iter().map(|route| Route::new(round(request, &route.points))).collect();
    let mut instance = request.instance().with_open_starts();
    instance.coverage_min = 0.9;
    let unsupported =
        |error: planner::VerifyError| PlanError::Unsupported { planner: ROUNDED, reason: error.to_string() };
    planner::accept(&instance, Plan { routes }, ROUNDED).map_err(unsupported)
}

fn round(request: &PlanRequest, points: &[Point]) -> Vec<Point> {
    let radius_m = 0.5 * request.floor.lattice().cell_m;
    let mut line: Vec<Point> = points.first().copied().into_iter().collect();
    for three in points.windows(3) {
        let (before, after) = ((three[1] - three[0]), (three[2] - three[1]));
        let from = three[1] - before * 0.5;
        let quarter = before.dot(&after).abs() < 1e-9 && before.norm() > radius_m;
        let arc = quarter.then(|| arc(from, before.normalize(), after.normalize(), radius_m));
        let is_free = |arc: &Vec<Point>| {
            arc.windows(2).all(|pair| request.floor.segment_is_free(Segment::new(pair[0], pair[1])))
        };
        match arc.filter(is_free) {
            Some(arc) => line.extend(arc),
            None => line.extend([three[1]]),
        }
    }
    line.extend(points.last().filter(|_| points.len() > 1));
    line
}

fn arc(from: Point, along: Vector, then: Vector, radius_m: f64) -> Vec<Point> {
    let share = |step: u32| f64::from(step) / 8.0 * FRAC_PI_2;
    let place = |a: f64| from + along * (radius_m * a.sin()) + then * (radius_m * (1.0 - a.cos()));
    (0..=8).map(share).map(place).collect()
}

fn scenarios() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios")
}

fn load(file: &str, change: impl FnOnce(&mut Scenario)) -> Arc<Scenario> {
    let mut scenario = Scenario::load(scenarios().join(file)).unwrap_or_else(|error| panic!("{error}"));
    ROUNDED.clone_into(&mut scenario.file.mission.planner);
    change(&mut scenario);
    Arc::new(scenario)
}

/// The stand-in plans for [`ROUNDED`]; rows of the table plan for themselves.
fn options_for(planner: &str) -> Options {
    let planner = if planner == ROUNDED { rounded } else { PlanRequest::run };
    Options { planner, virtual_max_s: 7200.0, ..Options::default() }
}

fn state_of(outcome: &Outcome) -> &'static str {
    outcome.result.as_ref().map_or("none", |result| result.mission_state().as_str_name())
}

/// What was seen of one robot's first order.
#[derive(Debug, Default)]
struct Track {
    heading_rad: f64,
    ordered: Option<Timestamp>,
    nodes: BTreeMap<(u64, u64), Point>,
    passed: (u64, u64),
    passed_at: Timestamp,
}

impl Track {
    /// How long the places that were passed take by the time model, and how long they took, seconds.
    fn planned_and_driven_s(&self, motion: &MotionModel) -> (f64, f64) {
        let points: Vec<Point> = self.nodes.range(..=self.passed).map(|(_, &point)| point).collect();
        let planned_s = motion.path_s(&points, Some(self.heading_rad));
        (planned_s, self.passed_at.secs_since(self.ordered.expect("every robot has work")))
    }
}

/// Plays a scenario, and follows each robot up to the last place passed before anything was planned anew.
fn followed(scenario: &Arc<Scenario>, options: Options) -> (Outcome, BTreeMap<String, Track>) {
    let mut tracks: BTreeMap<String, Track> = BTreeMap::new();
    let mut planned_anew = false;
    let mut sink = |now: Timestamp, record: &Record| match record {
        Record::Order { robot, order } if order.plan_revision <= 1 => {
            let track = tracks.entry(robot.clone()).or_default();
            track.ordered.get_or_insert(now);
            let first = order.nodes.first().map_or(0, |node| node.sequence_id);
            track.nodes.retain(|&(order_id, sequence), _| order_id < order.order_id || sequence < first);
            for node in &order.nodes {
                track.nodes.insert((order.order_id, node.sequence_id), Point::new(node.x_m, node.y_m));
            }
        }
        Record::Order { .. } => planned_anew = true,
        Record::State(state) if !planned_anew => {
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
        _ => {}
    };
    let outcome = Rehearsal::run(scenario, 1, options, Some(&mut sink)).expect("the floor is sound");
    (outcome, tracks)
}

#[track_caller]
fn assert_completed(outcome: &Outcome) {
    println!("{}", outcome.transcript.text());
    assert_eq!(outcome.violations, [], "{}", outcome.transcript.text());
    assert_eq!((state_of(outcome), outcome.contacts), ("COMPLETED", 0), "{}", outcome.transcript.text());
}

/// Drives without faults: each robot is as fast as its plan to within a share of the plan, or only the fleet as a whole
/// where robots wait for each other.
#[track_caller]
fn assert_driven_as_planned(scenario: &Arc<Scenario>, within: f64, each: bool) {
    let motion = scenario.file.robot.motion();
    let planner = &scenario.file.mission.planner;
    let (outcome, tracks) = followed(scenario, options_for(planner));
    assert_completed(&outcome);
    let mut fleet = (0.0, 0.0);
    for (id, track) in &tracks {
        let (planned_s, driven_s) = track.planned_and_driven_s(&motion);
        let ratio = driven_s / planned_s;
        println!("{planner}: {id} planned {planned_s:.2} s, driven {driven_s:.2} s, ratio {ratio:.4}");
        assert!(!each || (ratio - 1.0).abs() < within, "{id}: {driven_s} s, planned {planned_s} s");
        fleet = (fleet.0 + planned_s, fleet.1 + driven_s);
    }
    let ratio = fleet.1 / fleet.0;
    println!("{planner}: fleet ratio {ratio:.4}");
    assert!((ratio - 1.0).abs() < within, "{planner}: driven {} s, planned {} s", fleet.1, fleet.0);
}

/// The office with its people, faults and stations, and other faults instead.
fn office(planner: &str, faults: &str) -> Arc<Scenario> {
    load("office.toml", |scenario| {
        planner.clone_into(&mut scenario.file.mission.planner);
        scenario.file.faults.clear();
        if !faults.is_empty() {
            scenario.file.faults.push(toml::from_str(faults).expect("a fault"));
        }
    })
}

const KILL: &str = "kind = \"kill\"\nrobot = \"r2\"\nwhen_covered_percent = 50.0\n";

#[test]
fn smooth_plans_are_driven_as_planned() {
    assert_driven_as_planned(&office(ROUNDED, ""), 0.05, true);
}

#[test]
fn spirals_are_driven_as_planned() {
    assert_driven_as_planned(&office("mcfs", ""), 0.05, true);
    if let Some(scenario) = of_mcfs("double_torus", "mcfs", "") {
        assert_driven_as_planned(&scenario, 0.05, false);
    }
}

/// Of the fleet: single robots wait where lanes of others cross theirs.
#[test]
fn lanes_are_driven_as_planned() {
    assert_driven_as_planned(&office("boustrophedon-lanes", ""), 0.02, false);
}

#[test]
fn with_a_robot_killed_half_way_a_smooth_plan_is_completed() {
    let scenario = office(ROUNDED, KILL);
    assert_completed(&Rehearsal::run(&scenario, 1, options_for(ROUNDED), None).expect("the floor is sound"));
}

/// `cargo test -p sim --test polyline_plans -- --ignored --nocapture`: the same two stories with each planner of the table
/// that leaves the lattice.
#[test]
#[ignore = "six planners, two missions each: about a minute"]
fn every_planner_that_leaves_the_lattice_is_driven_to_the_end() {
    for planner in planner::PLANNERS.iter().filter(|planner| !keeps_to_lattice(planner.name)) {
        for faults in ["", KILL] {
            println!("{}", planner.name);
            let scenario = office(planner.name, faults);
            let outcome = Rehearsal::run(&scenario, 1, options_for(planner.name), None);
            assert_completed(&outcome.expect("the floor is sound"));
        }
    }
}

/// Played in every test run: with the stand-in, and with each of [`ROWS`].
const STORIES: Range<u64> = 0..40;
const STORIES_OF_ROWS: Range<u64> = 0..4;
/// Rows of the table that leave the lattice, one of each kind: smooth lines and straight lanes.
const ROWS: [&str; 2] = ["mcfs", "boustrophedon-lanes"];

fn wanted() -> Option<Range<u64>> {
    let text = std::env::var("STORIES").ok()?;
    let (from, to) = text.split_once("..").expect("STORIES=FROM..TO");
    Some(from.parse().expect("a number")..to.parse().expect("a number"))
}

#[track_caller]
fn assert_no_story_is_broken(planner: &str, usual: Range<u64>) {
    let shown = wanted();
    let mut broken = Vec::new();
    for seed in shown.clone().unwrap_or(usual) {
        let mut scenario = Arc::unwrap_or_clone(random_story(seed));
        planner.clone_into(&mut scenario.file.mission.planner);
        let options = Options { virtual_max_s: 1800.0, ..options_for(planner) };
        let outcome = Rehearsal::run(&Arc::new(scenario), seed, options, None).expect("the floor is sound");
        if shown.is_some() {
            println!("{planner}, story {seed}\n{}", outcome.transcript.text());
        }
        for violation in outcome.violations.iter().take(3) {
            broken.push(format!("{planner}, story {seed}: {violation}"));
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn no_random_story_breaks_an_invariant() {
    assert_no_story_is_broken(ROUNDED, STORIES);
}

#[test]
fn no_random_story_of_the_rows_breaks_an_invariant() {
    for planner in ROWS {
        assert_no_story_is_broken(planner, STORIES_OF_ROWS);
    }
}

/// A floor of ../shared/instances/mcfs, five times as large (its tool is 0.1 m wide: as narrow as poses are noisy), with
/// the robots that it lists.
fn of_mcfs(name: &str, planner: &str, faults: &str) -> Option<Arc<Scenario>> {
    const LARGER: f64 = 5.0;
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../shared/instances/mcfs/{name}.json"));
    let Ok(text) = std::fs::read_to_string(file) else {
        println!("skipped: ../shared/instances/mcfs/{name}.json is not here");
        return None;
    };
    let value: serde_json::Value = serde_json::from_str(&text).expect("an instance");
    let ring = |ring: &serde_json::Value| -> Vec<[f64; 2]> {
        let corner =
            |at: &serde_json::Value| [0, 1].map(|axis| at[axis].as_f64().expect("a number") * LARGER);
        ring.as_array().expect("a ring").iter().map(corner).collect()
    };
    let holes: Vec<_> = value["polygon"]["holes"].as_array().into_iter().flatten().map(ring).collect();
    let larger = serde_json::json!({ "exterior": ring(&value["polygon"]["exterior"]), "holes": holes });
    let map = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.json"));
    std::fs::write(&map, larger.to_string()).expect("the folder for tests is writable");
    let count = value["robots"].as_array().map_or(1, Vec::len);
    let scenario = format!(
        "[mission]\nid = \"{name}\"\nmap = \"{}\"\n[robot]\ntool_width_m = 0.5\n\
         [fleet]\ncount = {count}\nspread = true\n{faults}",
        map.display()
    );
    let mut scenario =
        Scenario::parse(&scenario, Path::new("mcfs.toml")).unwrap_or_else(|error| panic!("{error}"));
    planner.clone_into(&mut scenario.file.mission.planner);
    Some(Arc::new(scenario))
}

#[track_caller]
fn is_completed_with_a_robot_killed(name: &str, planner: &str) {
    let Some(scenario) = of_mcfs(name, planner, &format!("[[fault]]\n{KILL}")) else { return };
    assert_completed(&Rehearsal::run(&scenario, 1, options_for(planner), None).expect("the floor is sound"));
}

#[test]
fn spirals_of_the_two_torus_with_a_robot_killed_half_way_are_completed() {
    is_completed_with_a_robot_killed("double_torus", "mcfs");
}

#[test]
fn spirals_of_the_office_with_a_robot_killed_half_way_are_completed() {
    is_completed_with_a_robot_killed("office", "mcfs");
}

#[test]
#[ignore = "planning the lanes of the 2-torus takes half a minute"]
fn lanes_of_the_two_torus_with_a_robot_killed_half_way_are_completed() {
    is_completed_with_a_robot_killed("double_torus", "boustrophedon-lanes");
}
