//! A small run, made up by hand, is recorded; strangers read it.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

mod story;

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
    let path = save("cut.mcap", &log[..flushed]);
    if let Some((fine, said)) = read_with_python(&path, &["--cut"]) {
        assert!(fine, "{said}");
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
