//! Real processes on this machine: coordinator, sim and agents, joined by zenoh and iceoryx2, hurt by real signals.
//!
//! Every test has a fleet, a bus prefix and a free port of its own, and ends only what it started, by pid.

mod common;

use common::{Fleet, oxplow, scenario};
use std::time::Duration;

/// Times as they are on the machine's clock, measured and printed; bounds are five times what we claim, since test
/// machines are busy.
const KILLED_MAX_S: f64 = 2.5;
const HUNG_MAX_S: f64 = 7.5;

#[test]
fn a_fleet_loses_robots_and_finishes() {
    let faults = "
[[fault]]
kind = \"kill\"
robot = \"r2\"
at_s = 12.0
carried_off_after_s = 15.0
[[fault]]
kind = \"hang\"
robot = \"r3\"
at_s = 24.0
for_s = 14.0
";
    let fleet = Fleet::new("loses", &scenario(4, faults));
    let output = fleet.up(1.0);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{}\n{text}", String::from_utf8_lossy(&output.stdout));
    let log = common::Log::read(&fleet.log());
    for (fault, bound_s) in [("kill", KILLED_MAX_S), ("hang", HUNG_MAX_S)] {
        let took_s =
            log.order_changed_after(fault).unwrap_or_else(|| panic!("no new order after {fault}\n{text}"));
        println!("{fault}: orders of others changed after {took_s:.2} s");
        assert!(took_s < bound_s, "{fault}: {took_s:.2} s");
    }
    let verdict = oxplow(&["verify", &fleet.log().display().to_string()]);
    assert!(verdict.status.success(), "{}", String::from_utf8_lossy(&verdict.stdout));
    common::python_reads(&fleet.log(), &[]);
}

#[test]
fn the_log_of_a_killed_coordinator_is_readable_and_true() {
    let fleet = Fleet::new("killed", &scenario(3, ""));
    let mut processes = fleet.start(4.0);
    common::pause(Duration::from_secs(6));
    processes.kill_coordinator();
    drop(processes);
    let log = common::Log::read(&fleet.log());
    assert!(log.messages > 500, "{} messages", log.messages);
    assert!(log.last_s > 12.0, "the log ends at {:.1} s of mission time", log.last_s);
    let verdict = oxplow(&["verify", &fleet.log().display().to_string()]);
    let text = String::from_utf8_lossy(&verdict.stdout).into_owned();
    assert!(
        matches!(verdict.status.code(), Some(0 | 3)),
        "{text}{}",
        String::from_utf8_lossy(&verdict.stderr)
    );
    common::python_reads(&fleet.log(), &["--cut"]);
}

#[test]
fn a_person_can_ask_pause_resume_and_cancel() {
    let fleet = Fleet::new("asked", &scenario(3, ""));
    let mut processes = fleet.start(2.0);
    let at = processes.locator.clone();
    let ask = |words: &[&str]| {
        let mut all = words.to_vec();
        all.extend(["--connect", &at, "--fleet", &fleet.name]);
        oxplow(&all)
    };
    processes.wait_for("START");
    let status = ask(&["status", "--json"]);
    let status: serde_json::Value = serde_json::from_slice(&status.stdout).expect("status --json is JSON");
    assert_eq!(status["robots"].as_array().map(Vec::len), Some(3), "{status}");
    assert!(ask(&["pause"]).status.success());
    common::pause(Duration::from_millis(1500));
    let paused = String::from_utf8_lossy(&ask(&["status"]).stdout).into_owned();
    assert!(paused.contains("PAUSED"), "{paused}");
    assert!(ask(&["resume"]).status.success());
    let refused = ask(&["fault", "kill", "nobody"]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("nobody"));
    assert!(ask(&["fault", "battery_drop", "r1", "to_percent=40"]).status.success());
    assert!(ask(&["cancel"]).status.success());
    processes.wait_for("CANCELLED");
    assert_eq!(processes.coordinator_ends(), Some(1), "a cancelled mission is no success");
}

#[test]
fn a_port_that_is_taken_is_said() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a free port");
    let locator = format!("tcp/{}", taken.local_addr().expect("it is bound"));
    let fleet = Fleet::new("taken", &scenario(2, ""));
    let output = oxplow(&["coordinator", &fleet.scenario.display().to_string(), "--listen", &locator]);
    assert_eq!(output.status.code(), Some(1));
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(text.contains("cannot listen") && text.contains("--listen"), "{text}");
}

#[test]
fn a_coordinator_without_agents_gives_up_and_says_why() {
    let timing = "[coordinator]\njoin_timeout_s = 2.0\n";
    let fleet = Fleet::new("alone", &scenario(2, timing));
    let path = fleet.scenario.display().to_string();
    let output = oxplow(&["coordinator", &path, "--listen", "tcp/127.0.0.1:0"]);
    assert_eq!(output.status.code(), Some(1));
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(text.contains("no agent has joined within 2 s") && text.contains("oxplow agent"), "{text}");
}

#[test]
fn nobody_there_is_exit_code_5() {
    for words in [vec!["status"], vec!["pause"], vec!["fault", "kill", "r1"]] {
        let mut all = words.clone();
        all.extend(["--connect", "tcp/127.0.0.1:9"]);
        let output = oxplow(&all);
        assert_eq!(output.status.code(), Some(5), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    }
}
