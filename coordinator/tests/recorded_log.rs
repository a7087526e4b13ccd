//! A small run, made up by hand, is recorded; strangers read it.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

mod story;

use coordinator::Publication;
use coordinator::recorder::{Record, RecordError, Recorder};
use foxglove::messages::SceneUpdate;
use prost::Message as _;
use protocol::{Timestamp, v1};
use std::collections::BTreeSet;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

fn temporary(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

fn save(name: &str, log: &[u8]) -> PathBuf {
    let path = temporary(name);
    std::fs::File::create(&path).unwrap().write_all(log).unwrap();
    path
}

/// Runs `tests/read_mcap.py`; `None` when its packages are not installed.
fn read_with_python(log: &Path, options: &[&str]) -> Option<(bool, String)> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/read_mcap.py");
    let python = std::env::var_os("OXPLOW_PYTHON").unwrap_or_else(|| "python3".into());
    let output = Command::new(python).arg(script).arg(log).args(options).output().ok()?;
    let said = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    if output.status.code() == Some(77) {
        println!("{said}");
        return None;
    }
    Some((output.status.success(), said))
}

#[test]
fn python_reads_what_we_wrote() {
    let path = save("whole.mcap", &story::recorded());
    if let Some((fine, said)) = read_with_python(&path, &[]) {
        assert!(fine, "{said}");
    }
}

#[test]
fn a_log_cut_off_by_a_kill_is_read_up_to_the_last_flush() {
    let (log, flushed) = story::recorded_until(story::END_S / 2.0);
    for torn_off in [0, 10, 100, 4000] {
        let path = save("cut.mcap", &log[..flushed - torn_off]);
        if let Some((fine, said)) = read_with_python(&path, &["--cut"]) {
            assert!(fine, "{said}");
        }
    }
}

#[test]
fn the_same_records_give_the_same_bytes() {
    assert!(story::recorded() == story::recorded());
}

#[test]
fn a_picture_is_drawn_from_the_log_alone() {
    let path = save("picture.mcap", &story::recorded());
    let svg = console::picture_from_log(&path).unwrap();
    std::fs::write(temporary("picture.svg"), &svg).unwrap();
    assert!(svg.contains("100.0 % covered"), "{svg}");
    assert!(svg.contains("<title>covered by r1</title>"));
    assert!(svg.contains("<title>blocked, from r1</title>"));
    assert_eq!(svg.matches("<polyline").count(), 2);
}

/// A disk with so much room left.
struct Disk(usize);

impl std::io::Write for Disk {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0 = self.0.checked_sub(bytes.len()).ok_or(std::io::ErrorKind::StorageFull)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_full_disk_is_an_error_and_no_panic() {
    assert!(Recorder::new(Disk(100), &story::run_info()).is_err());
    let mut recorder = Recorder::new(Disk(40_000), &story::run_info()).unwrap();
    let state = Record::State(Box::default());
    let mut log_states = || {
        for tick in 0..100_000_u32 {
            recorder.record(Timestamp::from_nanos(u64::from(tick)), &state)?;
            recorder.flush()?;
        }
        Ok::<(), RecordError>(())
    };
    let error = log_states().unwrap_err().to_string();
    assert!(error.contains("the log cannot be written"), "{error}");
    assert!(recorder.flush().is_err());
    assert!(recorder.finish().is_err());
}

#[test]
fn whoever_gives_no_good_id_gets_no_topic() {
    let mut recorder = Recorder::new(Vec::new(), &story::run_info()).unwrap();
    for number in 0..3000 {
        for serial_number in [format!("../{number}"), format!("r{number}")] {
            let header = v1::Header { serial_number, ..Default::default() };
            let state = v1::State { header: Some(header), ..Default::default() };
            recorder.record(Timestamp::ZERO, &Record::State(Box::new(state))).unwrap();
        }
    }
    let log = recorder.finish().unwrap();
    let topics = topics(&log);
    assert!(topics.contains("/robots/unknown/state"));
    assert!(topics.iter().filter(|topic| topic.ends_with("/state")).count() <= 1025);
    assert!(topics.iter().all(|topic| !topic.contains("..")));
}

fn topics(log: &[u8]) -> BTreeSet<String> {
    let summary = mcap::Summary::read(log).unwrap().unwrap();
    summary.channels.values().map(|channel| channel.topic.clone()).collect()
}

#[test]
fn a_lost_robot_leaves_no_ghost_in_the_scene() {
    let robot = |role: v1::RobotRole| v1::RobotStatus {
        serial_number: "r1".to_owned(),
        role: role as i32,
        pose: Some(v1::Pose::default()),
        ..Default::default()
    };
    let mut recorder = Recorder::new(Vec::new(), &story::run_info()).unwrap();
    for (at_s, role) in
        [(1.0, v1::RobotRole::RoleIdle), (2.0, v1::RobotRole::RoleIdle), (3.0, v1::RobotRole::RoleLost)]
    {
        let status = v1::FleetStatus { robots: vec![robot(role)], ..Default::default() };
        let record = Record::Publication(Publication::Status(Box::new(status)));
        recorder.record(Timestamp::from_secs_f64(at_s), &record).unwrap();
    }
    let log = recorder.finish().unwrap();
    let scenes: Vec<SceneUpdate> = mcap::MessageStream::new(&log)
        .unwrap()
        .map(Result::unwrap)
        .filter(|message| message.channel.topic == "/fleet/scene")
        .map(|message| SceneUpdate::decode(message.data.as_ref()).unwrap())
        .collect();
    assert_eq!(scenes.len(), 2, "what did not change is not written again");
    assert_eq!(scenes[0].entities[0].id, "robot/r1");
    assert_eq!(scenes[1].deletions[0].id, "robot/r1");
}
