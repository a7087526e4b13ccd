//! Holds the arrows of ARCHITECTURE.md: who may know whom, and where I/O lives.

use std::{collections::BTreeSet, fs, path::Path, process::Command};

/// Crates that do I/O: nobody pure may depend on them, however indirectly.
const IO_CRATES: &[&str] = &["zenoh", "iceoryx2", "tokio"];
/// Words by which a file does I/O or reads a clock.
const IO_WORDS: &[&str] =
    &["zenoh::", "iceoryx2::", "tokio::", "Instant::now", "SystemTime::now", "thread::sleep"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All crates that `package` is built from, without its default features.
fn dependencies(package: &str) -> BTreeSet<String> {
    let output = Command::new(env!("CARGO"))
        .args(["tree", "--offline", "--no-default-features", "--edges", "normal", "--prefix", "none"])
        .args(["--format", "{p}", "--package", package])
        .current_dir(root())
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let tree = String::from_utf8(output.stdout).expect("cargo prints UTF-8");
    tree.lines().filter_map(|line| line.split_whitespace().next()).map(str::to_owned).collect()
}

#[track_caller]
fn assert_knows_none_of(package: &str, forbidden: &[&str]) {
    let known = dependencies(package);
    assert!(known.contains(package), "cargo tree shows {package} itself");
    for name in forbidden {
        assert!(!known.contains(*name), "{package} must not know {name}");
    }
}

#[test]
fn terrain_knows_nobody() {
    assert_knows_none_of("terrain", IO_CRATES);
    assert_knows_none_of(
        "terrain",
        &["planner", "protocol", "coordinator", "agent", "sim", "console", "oxplow"],
    );
}

#[test]
fn planner_knows_only_terrain() {
    assert_knows_none_of("planner", IO_CRATES);
    assert_knows_none_of(
        "planner",
        &["protocol", "coordinator", "agent", "sim", "console", "oxplow", "mcap"],
    );
}

#[test]
fn benchmark_runs_planners_and_no_fleet() {
    assert_knows_none_of("benchmark", IO_CRATES);
    assert_knows_none_of("benchmark", &["protocol", "coordinator", "agent", "sim", "console", "oxplow"]);
}

#[test]
fn protocol_is_data_only() {
    assert_knows_none_of("protocol", IO_CRATES);
    assert_knows_none_of(
        "protocol",
        &["terrain", "planner", "coordinator", "agent", "sim", "console", "oxplow"],
    );
}

#[test]
fn the_console_knows_neither_planner_nor_coordinator() {
    assert_knows_none_of("console", IO_CRATES);
    assert_knows_none_of("console", &["planner", "coordinator", "agent", "sim", "oxplow"]);
}

#[test]
fn the_cores_are_free_of_io() {
    assert_knows_none_of("coordinator", IO_CRATES);
    assert_knows_none_of("coordinator", &["agent", "sim", "console", "oxplow"]);
    assert_knows_none_of("agent", IO_CRATES);
    assert_knows_none_of("agent", &["planner", "coordinator", "sim", "console", "oxplow"]);
    assert_knows_none_of("sim", IO_CRATES);
}

#[test]
fn only_drivers_do_io() {
    let mut seen = 0;
    for package in ["terrain", "planner", "protocol", "coordinator", "agent", "sim", "console"] {
        visit(&root().join(package).join("src"), &mut |file, text| {
            seen += 1;
            if is_driver(file) {
                return;
            }
            for word in IO_WORDS {
                let used =
                    text.lines().any(|line| line.contains(word) && !line.trim_start().starts_with("//"));
                assert!(!used, "{} uses {word}, which only driver.rs may", file.display());
            }
        });
    }
    assert!(seen > 40, "only {seen} files seen: is the layout another one?");
}

fn is_driver(file: &Path) -> bool {
    file.components().any(|part| part.as_os_str() == "driver.rs" || part.as_os_str() == "driver")
}

fn visit(folder: &Path, check: &mut impl FnMut(&Path, &str)) {
    for entry in fs::read_dir(folder).expect("the crate has a src folder") {
        let path = entry.expect("the folder can be listed").path();
        if path.is_dir() {
            visit(&path, check);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            check(&path, &fs::read_to_string(&path).expect("sources are text"));
        }
    }
}
