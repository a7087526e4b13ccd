//! Two robots sweep a room, row by row; everything they would have said, without any of them.
//!
//! ```text
//!   ############
//!   #..........#  r2 takes the upper two rows
//!   #..........#
//!   #..........#  r1 takes the lower two rows
//!   #..........#
//!   ############
//! ```

use coordinator::recorder::{Record, Recorder, RunInfo};
use coordinator::{Mission, Publication, Station};
use protocol::{Timestamp, v1};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::Write;
use std::rc::Rc;
use std::sync::Arc;
use terrain::{Cell, GridMap, Lattice, Point};

pub const END_S: f64 = 12.0;
const SPEED_M_PER_S: f64 = 0.5;
const CELL_M: f64 = 0.25;
const ROOM: &str = "
    ############
    #..........#
    #..........#
    #..........#
    #..........#
    ############";

/// A writer whose bytes can be looked at while it is written to.
#[derive(Clone, Default)]
struct Shared(Rc<RefCell<Vec<u8>>>);

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.borrow_mut().write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// The whole run, as a log.
pub fn recorded() -> Vec<u8> {
    recorded_with(|_, _| {})
}

/// The whole run, as a log, with records changed on their way: `twist(seconds, record)`.
pub fn recorded_with(twist: impl FnMut(f64, &mut Record)) -> Vec<u8> {
    let mut recorder = Recorder::new(Vec::new(), &run_info()).unwrap();
    play(&mut recorder, END_S + 1.0, twist);
    recorder.finish().unwrap()
}

/// The run up to a moment, without an end, and how many bytes of it had been flushed by then.
pub fn recorded_until(until_s: f64) -> (Vec<u8>, usize) {
    let bytes = Shared::default();
    let mut recorder = Recorder::new(bytes.clone(), &run_info()).unwrap();
    play(&mut recorder, until_s, |_, _| {});
    recorder.flush().unwrap();
    let flushed = bytes.0.borrow().len();
    std::mem::forget(recorder);
    let log = bytes.0.borrow().clone();
    (log, flushed)
}

pub fn run_info() -> RunInfo {
    let map = GridMap::from_drawing(ROOM, CELL_M).unwrap();
    RunInfo {
        mission: Mission {
            id: "story".to_owned(),
            map: Arc::new(map),
            cell_m: CELL_M,
            body_radius_m: 0.07,
            tool_width_m: 0.4,
            stations: vec![Station { id: "dock1".to_owned(), position: Point::new(0.375, 0.375) }],
            planner: "stc".to_owned(),
            return_to_start: false,
            robots: vec!["r1".to_owned(), "r2".to_owned()],
        },
        scenario_toml: "# made up\n".to_owned(),
        map_file: None,
        seed: 1,
        notes: BTreeMap::new(),
    }
}

fn lattice() -> Lattice {
    Lattice { origin: Point::origin(), cell_m: CELL_M, columns: 12, rows: 6 }
}

/// The cells of a robot in the order of driving: its lower row eastwards, its upper row back.
fn route(robot: usize) -> Vec<Cell> {
    let row = 1 + 2 * robot as i32;
    (1..=10).map(|x| Cell::new(x, row)).chain((1..=10).rev().map(|x| Cell::new(x, row + 1))).collect()
}

fn pose_at(robot: usize, at_s: f64) -> v1::Pose {
    let route = route(robot);
    let driven = (at_s * SPEED_M_PER_S / CELL_M).min(route.len() as f64 - 1.0);
    let (index, share) = (driven.floor() as usize, driven.fract());
    let from = lattice().center(route[index]);
    let to = lattice().center(route[(index + 1).min(route.len() - 1)]);
    let here = from + (to - from) * share;
    let ahead = to - from;
    v1::Pose { x_m: here.x, y_m: here.y, theta_rad: ahead.y.atan2(ahead.x) }
}

fn cells_done(robot: usize, at_s: f64) -> usize {
    ((at_s * SPEED_M_PER_S / CELL_M) as usize + 1).min(route(robot).len())
}

fn play<W: Write>(recorder: &mut Recorder<W>, until_s: f64, mut twist: impl FnMut(f64, &mut Record)) {
    let mut record = |at_s: f64, mut record: Record| {
        twist(at_s, &mut record);
        recorder.record(Timestamp::from_secs_f64(at_s), &record).unwrap();
    };
    for robot in 0..2 {
        record(0.0, Record::Factsheet(Box::new(factsheet(robot))));
        record(0.0, order(robot));
    }
    record(0.0, delta(1, &first_runs(), Some(geometry())));
    let mut done = [0_usize; 2];
    let mut sequence = 1;
    for tick in 0.. {
        let at_s = f64::from(tick) / 10.0;
        if at_s > until_s.min(END_S) {
            break;
        }
        record(at_s, Record::Truth(Box::new(truth(tick, at_s))));
        for (robot, done) in done.iter_mut().enumerate() {
            record(at_s, Record::State(Box::new(state(robot, at_s))));
            record(at_s, Record::Grant { robot: name(robot), grant: v1::Grant::default() });
            let done_now = cells_done(robot, at_s);
            if done_now > *done {
                sequence += 1;
                let runs: Vec<_> =
                    route(robot)[*done..done_now].iter().map(|&cell| run(cell, robot)).collect();
                record(at_s, delta(sequence, &runs, None));
                *done = done_now;
            }
        }
        if tick % 10 == 0 {
            record(at_s, Record::Publication(Publication::Status(Box::new(status(at_s)))));
        }
        if tick == 30 {
            record(at_s, event("r2", "LOST", "no state for 0.5 s → 3 cells to r1 (+2 s)"));
        }
    }
    if until_s > END_S {
        record(END_S, Record::Publication(Publication::Result(result())));
    }
}

fn name(robot: usize) -> String {
    format!("r{}", robot + 1)
}

fn header(robot: usize, at_s: f64) -> v1::Header {
    v1::Header {
        header_id: (at_s * 10.0) as u64 + 1,
        timestamp_ns: (at_s * 1e9) as u64,
        serial_number: name(robot),
        boot_id: 7 + robot as u64,
    }
}

fn factsheet(robot: usize) -> v1::Factsheet {
    v1::Factsheet {
        header: Some(header(robot, 0.0)),
        series_name: "story".to_owned(),
        body_radius_m: 0.07,
        tool_width_m: 0.4,
        speed_max_m_per_s: SPEED_M_PER_S,
        ..Default::default()
    }
}

fn order(robot: usize) -> Record {
    let node = |(at, cell): (usize, &Cell)| {
        let center = lattice().center(*cell);
        v1::Node { sequence_id: at as u64 + 1, x_m: center.x, y_m: center.y, tool_active: true }
    };
    let nodes = route(robot).iter().enumerate().map(node).collect();
    Record::Order {
        robot: name(robot),
        order: v1::Order { order_id: 1, nodes, complete: true, ..Default::default() },
    }
}

fn state(robot: usize, at_s: f64) -> v1::State {
    let done = cells_done(robot, at_s);
    let vertex = |(at, cell): (usize, &Cell)| {
        let center = lattice().center(*cell);
        v1::SweepVertex {
            sequence: at as u64 + 1,
            x_m: center.x,
            y_m: center.y,
            tool_active: true,
            trusted: true,
            deviation_m: 0.01,
        }
    };
    let sweep = route(robot).iter().enumerate().take(done).skip(done.saturating_sub(3)).map(vertex).collect();
    let scan = v1::RangeScan {
        range_max_m: 3.0,
        angle_min_rad: -1.5,
        angle_increment_rad: 3.0 / 47.0,
        ranges_m: (0..48).map(|beam| 1.0 + 0.01 * beam as f32).collect(),
    };
    v1::State {
        header: Some(header(robot, at_s)),
        order_id: 1,
        pose: Some(pose_at(robot, at_s)),
        speed_m_per_s: SPEED_M_PER_S,
        driving: true,
        state_of_charge_percent: 90.0 - at_s,
        sweep,
        scan: Some(scan),
        ..Default::default()
    }
}

fn truth(tick: u32, at_s: f64) -> v1::GroundTruth {
    let body = |robot| v1::BodyTruth {
        serial_number: name(robot),
        pose: Some(pose_at(robot, at_s)),
        speed_m_per_s: SPEED_M_PER_S,
        tool_active: true,
        state_of_charge_percent: 90.0 - at_s,
        on_floor: true,
        charging: false,
    };
    v1::GroundTruth {
        sequence: u64::from(tick) + 1,
        timestamp_ns: (at_s * 1e9) as u64,
        bodies: (0..2).map(body).collect(),
        obstacles: Vec::new(),
    }
}

fn geometry() -> v1::LatticeGeometry {
    v1::LatticeGeometry { origin_x_m: 0.0, origin_y_m: 0.0, cell_m: CELL_M, columns: 12, rows: 6 }
}

fn first_runs() -> Vec<v1::CellRun> {
    let full = |row, status| v1::CellRun { row, length: 12, status, ..Default::default() };
    let excluded = v1::CellStatus::CellExcluded as i32;
    let mut runs = vec![full(0, excluded), full(5, excluded)];
    for row in 1..5 {
        runs.push(v1::CellRun { row, length: 1, status: excluded, ..Default::default() });
        runs.push(v1::CellRun { row, column: 11, length: 1, status: excluded, ..Default::default() });
        runs.push(v1::CellRun {
            row,
            column: 1,
            length: 10,
            status: v1::CellStatus::CellAssigned as i32,
            serial_number: name((row as usize - 1) / 2),
            ..Default::default()
        });
    }
    runs
}

fn run(cell: Cell, robot: usize) -> v1::CellRun {
    v1::CellRun {
        row: cell.y as u32,
        column: cell.x as u32,
        length: 1,
        status: v1::CellStatus::CellCovered as i32,
        serial_number: name(robot),
        ..Default::default()
    }
}

fn delta(sequence: u64, runs: &[v1::CellRun], lattice: Option<v1::LatticeGeometry>) -> Record {
    Record::Publication(Publication::Coverage(v1::CoverageDelta {
        sequence,
        runs: runs.to_vec(),
        lattice,
        ..Default::default()
    }))
}

fn progress(at_s: f64) -> v1::CoverageProgress {
    let covered: usize = (0..2).map(|robot| cells_done(robot, at_s)).sum();
    v1::CoverageProgress {
        covered_percent: covered as f64 / 40.0 * 100.0,
        covered_m2: covered as f64 * CELL_M * CELL_M,
        coverable_m2: 40.0 * CELL_M * CELL_M,
        cells_covered: covered as u32,
        cells_assigned: 40 - covered as u32,
        cells_excluded: 32,
        cells_total: 72,
        ..Default::default()
    }
}

fn status(at_s: f64) -> v1::FleetStatus {
    let robot = |robot| v1::RobotStatus {
        serial_number: name(robot),
        role: v1::RobotRole::RoleCovering as i32,
        pose: Some(pose_at(robot, at_s)),
        state_of_charge_percent: 90.0 - at_s,
        body_radius_m: 0.07,
        ..Default::default()
    };
    let zones = if at_s < 5.0 {
        Vec::new()
    } else {
        vec![v1::Zone {
            zone_id: 1,
            zone_type: v1::ZoneType::ZoneBlocked as i32,
            cells: vec![v1::Point { x_m: 2.625, y_m: 1.125 }],
            cause: "r1".to_owned(),
            ..Default::default()
        }]
    };
    v1::FleetStatus {
        mission_id: "story".to_owned(),
        mission_state: v1::MissionState::Active as i32,
        plan_revision: 1,
        progress: Some(progress(at_s)),
        robots: (0..2).map(robot).collect(),
        zones,
        term: 1,
        ..Default::default()
    }
}

fn event(robot: &str, event: &str, text: &str) -> Record {
    Record::Publication(Publication::Event(v1::Event {
        event_id: 1,
        level: v1::EventLevel::EventWarning as i32,
        serial_number: robot.to_owned(),
        event: event.to_owned(),
        text: text.to_owned(),
        ..Default::default()
    }))
}

fn result() -> v1::MissionResult {
    v1::MissionResult {
        mission_id: "story".to_owned(),
        mission_state: v1::MissionState::Completed as i32,
        progress: Some(progress(END_S)),
        duration_s: END_S,
        ..Default::default()
    }
}
