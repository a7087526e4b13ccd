//! How everything stands, as a table for a person and as JSON for a program.

use crate::event_line::printable;
use crate::palette::{self, paint};
use protocol::v1;
use schemars::JsonSchema;
use serde::Serialize;

const BAR_WIDTH: usize = 30;

/// What `oxplow status --json` prints.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct StatusReport {
    /// Always `oxplow-status/1`.
    pub format: &'static str,
    /// The mission.
    pub mission_id: String,
    /// Its state: CREATED, PLANNED, ACTIVE, PAUSED, …
    pub mission_state: String,
    /// Mission time, seconds.
    pub at_s: f64,
    /// Number of the plan that is driven.
    pub plan_revision: u64,
    /// Number of the coordinator's start.
    pub term: u64,
    /// How far the coverage is.
    pub progress: ProgressReport,
    /// The robots.
    pub robots: Vec<RobotReport>,
    /// The chargers.
    pub stations: Vec<StationReport>,
    /// Ground that nobody may enter now.
    pub zones: Vec<ZoneReport>,
}

/// How far the coverage is.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ProgressReport {
    /// By area, of what can be covered.
    pub covered_percent: f64,
    /// Square metres.
    pub covered_m2: f64,
    /// Square metres.
    pub coverable_m2: f64,
    /// Area swept more than once, as a share.
    pub overlap_ratio: f64,
    /// Estimate of the time left, seconds.
    pub remaining_s: f64,
    /// Cells in each state of the ledger.
    pub cells: CellCounts,
}

/// Cells in each state of the ledger.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[allow(missing_docs, reason = "named by the states of the ledger")]
pub struct CellCounts {
    pub unassigned: u32,
    pub assigned: u32,
    pub covered: u32,
    pub unreachable: u32,
    pub excluded: u32,
    pub lost: u32,
    pub total: u32,
}

/// One robot.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RobotReport {
    /// Its id.
    pub id: String,
    /// What it is doing: idle, transit, covering, waiting, …
    pub role: String,
    /// Where it is: x and y in metres, heading in radians.
    pub pose: Option<[f64; 3]>,
    /// Charge of its battery, percent.
    pub state_of_charge_percent: f64,
    /// Cells it has to cover.
    pub cells_assigned: u32,
    /// Cells it covered.
    pub cells_covered: u32,
    /// Distance driven with the tool on, metres.
    pub swept_distance_m: f64,
    /// Estimate of the time left for its route, seconds.
    pub remaining_s: f64,
    /// Robot or zone it waits for.
    pub waits_for: Option<String>,
    /// What is wrong with it.
    pub errors: Vec<String>,
}

/// One charger.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct StationReport {
    /// Its id.
    pub id: String,
    /// The robot at it.
    pub occupied_by: Option<String>,
    /// The robots that wait for it.
    pub queue: Vec<String>,
    /// Whether it does not work.
    pub out_of_order: bool,
}

/// Ground that nobody may enter now.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ZoneReport {
    /// Its number.
    pub id: u64,
    /// blocked or quarantine.
    pub kind: String,
    /// Number of cells.
    pub cells: usize,
    /// Robot or report it came from.
    pub cause: String,
    /// Since when, seconds of mission time.
    pub since_s: f64,
}

impl StatusReport {
    /// The status as it is printed.
    pub fn new(status: &v1::FleetStatus) -> Self {
        Self {
            format: "oxplow-status/1",
            mission_id: status.mission_id.clone(),
            mission_state: status.mission_state().as_str_name().to_owned(),
            at_s: status.timestamp_ns as f64 / 1e9,
            plan_revision: status.plan_revision,
            term: status.term,
            progress: ProgressReport::new(&status.progress.unwrap_or_default()),
            robots: status.robots.iter().map(RobotReport::new).collect(),
            stations: status.stations.iter().map(StationReport::new).collect(),
            zones: status.zones.iter().map(ZoneReport::new).collect(),
        }
    }

    /// As JSON.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("a status has nothing that JSON cannot say")
    }
}

impl ProgressReport {
    fn new(progress: &v1::CoverageProgress) -> Self {
        Self {
            covered_percent: progress.covered_percent,
            covered_m2: progress.covered_m2,
            coverable_m2: progress.coverable_m2,
            overlap_ratio: progress.overlap_ratio,
            remaining_s: progress.remaining_s,
            cells: CellCounts {
                unassigned: progress.cells_unassigned,
                assigned: progress.cells_assigned,
                covered: progress.cells_covered,
                unreachable: progress.cells_unreachable,
                excluded: progress.cells_excluded,
                lost: progress.cells_lost,
                total: progress.cells_total,
            },
        }
    }
}

impl RobotReport {
    fn new(robot: &v1::RobotStatus) -> Self {
        let role = robot.role().as_str_name().trim_start_matches("ROLE_").to_lowercase();
        Self {
            id: robot.serial_number.clone(),
            role: role.replace('_', " "),
            pose: robot.pose.map(|pose| [pose.x_m, pose.y_m, pose.theta_rad]),
            state_of_charge_percent: robot.state_of_charge_percent,
            cells_assigned: robot.cells_assigned,
            cells_covered: robot.cells_covered,
            swept_distance_m: robot.swept_distance_m,
            remaining_s: robot.remaining_s,
            waits_for: some_text(&robot.waits_for),
            errors: robot.errors.clone(),
        }
    }

    fn row(&self) -> [String; 8] {
        [
            self.id.clone(),
            self.role.clone(),
            format!("{:.0} %", self.state_of_charge_percent),
            format!("{}/{}", self.cells_covered, self.cells_covered + self.cells_assigned),
            format!("{:.0} m", self.swept_distance_m),
            clock(self.remaining_s),
            self.waits_for.clone().unwrap_or_default(),
            self.errors.join(", "),
        ]
    }
}

impl StationReport {
    fn new(station: &v1::StationStatus) -> Self {
        Self {
            id: station.station_id.clone(),
            occupied_by: some_text(&station.occupied_by),
            queue: station.queue.clone(),
            out_of_order: station.out_of_order,
        }
    }

    fn line(&self) -> String {
        let mut line = format!("{}: {}", self.id, self.occupied_by.as_deref().unwrap_or("free"));
        if self.out_of_order {
            line = format!("{}: out of order", self.id);
        }
        if !self.queue.is_empty() {
            line = format!("{line}, waiting {}", self.queue.join(" "));
        }
        line
    }
}

impl ZoneReport {
    fn new(zone: &v1::Zone) -> Self {
        let kind = match zone.zone_type() {
            v1::ZoneType::ZoneQuarantine => "quarantine",
            _ => "blocked",
        };
        Self {
            id: zone.zone_id,
            kind: kind.to_owned(),
            cells: zone.cells.len(),
            cause: zone.cause.clone(),
            since_s: zone.since_ns as f64 / 1e9,
        }
    }

    fn line(&self) -> String {
        format!("{}: {} cells since {}, from {}", self.kind, self.cells, clock(self.since_s), self.cause)
    }
}

/// What `oxplow status` prints.
pub fn status_text(status: &v1::FleetStatus, colour: bool) -> String {
    let report = StatusReport::new(status);
    let mut lines = vec![
        format!(
            "{}  {}  at {}  plan {}",
            paint(&printable(&report.mission_id), palette::BOLD, colour),
            paint(&report.mission_state, state_tone(status.mission_state()), colour),
            clock(report.at_s),
            report.plan_revision,
        ),
        progress_line(&report.progress, colour),
        String::new(),
    ];
    lines.extend(robot_table(&report.robots, colour));
    lines.extend(section("stations", report.stations.iter().map(StationReport::line)));
    lines.extend(section("zones", report.zones.iter().map(ZoneReport::line)));
    lines.join("\n")
}

fn progress_line(progress: &ProgressReport, colour: bool) -> String {
    let share = (progress.covered_percent / 100.0).clamp(0.0, 1.0);
    let full = (share * BAR_WIDTH as f64).floor() as usize;
    let bar = format!("{}{}", "█".repeat(full), "░".repeat(BAR_WIDTH - full));
    format!(
        "{} {:.1} %  {:.1} of {:.1} m²  {} left",
        paint(&bar, palette::GREEN, colour),
        progress.covered_percent,
        progress.covered_m2,
        progress.coverable_m2,
        clock(progress.remaining_s),
    )
}

fn robot_table(robots: &[RobotReport], colour: bool) -> Vec<String> {
    let head = ["robot", "role", "charge", "cells", "swept", "left", "waits for", "errors"];
    let rows: Vec<[String; 8]> =
        robots.iter().map(|robot| robot.row().map(|cell| printable(&cell))).collect();
    let width = |column: usize| {
        let cells = rows.iter().map(|row| row[column].chars().count());
        cells.chain([head[column].len()]).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..head.len()).map(width).collect();
    let line = |row: &[String]| {
        let cells = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}"));
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    let head = paint(&line(&head.map(str::to_owned)), palette::DIM, colour);
    let body = rows.iter().zip(robots).map(|(row, robot)| paint(&line(row), role_tone(&robot.role), colour));
    std::iter::once(head).chain(body).collect()
}

fn section(title: &str, lines: impl Iterator<Item = String>) -> Vec<String> {
    let lines: Vec<String> = lines.map(|line| format!("  {}", printable(&line))).collect();
    if lines.is_empty() {
        return lines;
    }
    [vec![String::new(), title.to_owned()], lines].concat()
}

fn state_tone(state: v1::MissionState) -> &'static str {
    match state {
        v1::MissionState::Completed => palette::GREEN,
        v1::MissionState::CompletedWithGaps | v1::MissionState::Paused => palette::YELLOW,
        v1::MissionState::Failed | v1::MissionState::Cancelled => palette::RED,
        _ => palette::CYAN,
    }
}

fn role_tone(role: &str) -> &'static str {
    match role {
        "lost" | "error" => palette::RED,
        "suspect" | "blocked" => palette::YELLOW,
        "offline" => palette::DIM,
        _ => "0",
    }
}

fn some_text(text: &str) -> Option<String> {
    (!text.is_empty()).then(|| text.to_owned())
}

/// Minutes and seconds: `03:12`.
fn clock(seconds: f64) -> String {
    let seconds = seconds.max(0.0).round() as u64;
    format!("{:02}:{:02}", seconds / 60, seconds % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn status() -> v1::FleetStatus {
        let robot = |id: &str, role: v1::RobotRole, waits_for: &str| v1::RobotStatus {
            serial_number: id.to_owned(),
            role: role as i32,
            state_of_charge_percent: 81.4,
            cells_assigned: 30,
            cells_covered: 12,
            swept_distance_m: 48.2,
            remaining_s: 75.0,
            waits_for: waits_for.to_owned(),
            ..Default::default()
        };
        v1::FleetStatus {
            timestamp_ns: 192_000_000_000,
            mission_id: "office".to_owned(),
            mission_state: v1::MissionState::Active as i32,
            plan_revision: 2,
            progress: Some(v1::CoverageProgress {
                covered_percent: 62.5,
                covered_m2: 12.3,
                coverable_m2: 19.7,
                remaining_s: 200.0,
                ..Default::default()
            }),
            robots: vec![
                robot("r1", v1::RobotRole::RoleCovering, ""),
                robot("r2", v1::RobotRole::RoleQueuedForDock, "dock1"),
            ],
            zones: vec![v1::Zone {
                zone_type: v1::ZoneType::ZoneQuarantine as i32,
                cells: vec![v1::Point::default(); 9],
                cause: "r3".to_owned(),
                since_ns: 61_000_000_000,
                ..Default::default()
            }],
            stations: vec![v1::StationStatus {
                station_id: "dock1".to_owned(),
                occupied_by: "r4".to_owned(),
                queue: vec!["r2".to_owned()],
                ..Default::default()
            }],
            ..Default::default()
        }
    }

    #[test]
    fn a_status_reads_as_a_table() {
        let expected = "\
office  ACTIVE  at 03:12  plan 2
██████████████████░░░░░░░░░░░░ 62.5 %  12.3 of 19.7 m²  03:20 left

robot  role             charge  cells  swept  left   waits for  errors
r1     covering         81 %    12/42  48 m   01:15
r2     queued for dock  81 %    12/42  48 m   01:15  dock1

stations
  dock1: r4, waiting r2

zones
  quarantine: 9 cells since 01:01, from r3";
        assert_eq!(status_text(&status(), false), expected);
    }

    #[test]
    fn json_names_units_and_states() {
        let json: serde_json::Value = serde_json::from_str(&StatusReport::new(&status()).to_json()).unwrap();
        assert_eq!(json["format"], "oxplow-status/1");
        assert_eq!(json["robots"][1]["role"], "queued for dock");
        assert_eq!(json["robots"][1]["waits_for"], "dock1");
        assert_eq!(json["progress"]["covered_percent"], 62.5);
        assert_eq!(json["zones"][0]["kind"], "quarantine");
    }

    #[test]
    fn an_empty_status_is_still_a_text() {
        assert!(status_text(&v1::FleetStatus::default(), true).contains("0.0 %"));
    }
}
