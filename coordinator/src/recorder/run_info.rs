//! What stands at the head of a log: all that is needed to judge it, or to run it again.

use super::RecordError;
use super::log_file::LogFile;
use crate::Mission;
use crate::coordinator::{COVERAGE_TOLERANCE_M, WALL_MARGIN_M};
use protocol::v1;
use std::collections::BTreeMap;
use std::io::Write;
use terrain::GridMap;

/// What is run.
#[derive(Debug, Clone)]
pub struct RunInfo {
    /// The mission.
    pub mission: Mission,
    /// Text of the scenario file.
    pub scenario_toml: String,
    /// The map's file as it was read, if there was one.
    pub map_file: Option<MapFile>,
    /// Seed for everything that is drawn.
    pub seed: u64,
    /// Further facts for `fleet.run`: host, commit, wall clock, … (a rehearsal adds none that differ between runs).
    pub notes: BTreeMap<String, String>,
}

/// A file that goes into the log whole.
#[derive(Debug, Clone)]
pub struct MapFile {
    /// Its name without folders.
    pub name: String,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

impl RunInfo {
    pub(super) fn write_to<W: Write>(&self, file: &mut LogFile<W>) -> Result<(), RecordError> {
        file.write_metadata("fleet.run", self.facts())?;
        file.attach("scenario.toml", "text/plain", self.scenario_toml.as_bytes())?;
        file.attach("floor.pgm", "image/x-portable-graymap", &pgm(&self.mission.map))?;
        file.attach("layout.json", "application/json", include_bytes!("layout.json"))?;
        if let Some(map) = &self.map_file {
            file.attach(&map.name, "application/octet-stream", &map.bytes)?;
        }
        Ok(())
    }

    fn facts(&self) -> BTreeMap<String, String> {
        let mission = &self.mission;
        let mut facts = self.notes.clone();
        let mut fact = |key: &str, value: String| facts.insert(key.to_owned(), value);
        fact("mission_id", mission.id.clone());
        fact("product_version", env!("CARGO_PKG_VERSION").to_owned());
        fact("seed", self.seed.to_string());
        fact("planner", mission.planner.clone());
        fact("robots", mission.robots.join(" "));
        fact("cell_m", mission.cell_m.to_string());
        fact("body_radius_m", mission.body_radius_m.to_string());
        fact("tool_width_m", mission.tool_width_m.to_string());
        fact("coverage_tolerance_m", COVERAGE_TOLERANCE_M.to_string());
        fact("wall_margin_m", WALL_MARGIN_M.to_string());
        fact("map_origin_x_m", mission.map.origin().x.to_string());
        fact("map_origin_y_m", mission.map.origin().y.to_string());
        fact("map_resolution_m", mission.map.resolution_m().to_string());
        if let Some(map) = &self.map_file {
            fact("map_file", map.name.clone());
        }
        facts
    }
}

/// The map as it was understood, one grey value a square: 254 free, 0 blocked. First row on top.
fn pgm(map: &GridMap) -> Vec<u8> {
    let mut picture = format!("P5\n{} {}\n255\n", map.columns(), map.rows()).into_bytes();
    for y in (0..i64::from(map.rows())).rev() {
        picture.extend((0..i64::from(map.columns())).map(|x| if map.is_free(x, y) { 254 } else { 0 }));
    }
    picture
}

/// `fleet.result`, as readers without our schemas see it.
pub(super) fn result_facts(result: &v1::MissionResult) -> BTreeMap<String, String> {
    let progress = result.progress.unwrap_or_default();
    [
        ("mission_id", result.mission_id.clone()),
        ("mission_state", result.mission_state().as_str_name().to_owned()),
        ("covered_percent", progress.covered_percent.to_string()),
        ("covered_m2", progress.covered_m2.to_string()),
        ("coverable_m2", progress.coverable_m2.to_string()),
        ("overlap_ratio", progress.overlap_ratio.to_string()),
        ("gaps", result.gaps.len().to_string()),
        ("gaps_m2", result.gaps.iter().map(|gap| gap.area_m2).sum::<f64>().to_string()),
        ("out_of_reach", result.out_of_reach.len().to_string()),
        ("out_of_reach_m2", progress.out_of_reach_m2.to_string()),
        ("duration_s", result.duration_s.to_string()),
        ("planned_makespan_s", result.planned_makespan_s.to_string()),
        ("replans", result.replans.to_string()),
        ("robots_lost", result.robots_lost.to_string()),
        ("cause", result.cause.clone()),
    ]
    .map(|(key, value)| (key.to_owned(), value))
    .into()
}

/// `fleet.factsheet.<id>`, flat.
pub(super) fn factsheet_facts(factsheet: &v1::Factsheet) -> BTreeMap<String, String> {
    let energy = factsheet.energy_model.unwrap_or_default();
    let charging = factsheet.battery_charging.unwrap_or_default();
    let numbers = [
        ("body_radius_m", factsheet.body_radius_m),
        ("tool_width_m", factsheet.tool_width_m),
        ("speed_max_m_per_s", factsheet.speed_max_m_per_s),
        ("acceleration_max_m_per_s2", factsheet.acceleration_max_m_per_s2),
        ("angular_speed_max_rad_per_s", factsheet.angular_speed_max_rad_per_s),
        ("angular_acceleration_max_rad_per_s2", factsheet.angular_acceleration_max_rad_per_s2),
        ("range_finder_m", factsheet.range_finder_m),
        ("capacity_wh", energy.capacity_wh),
        ("idle_w", energy.idle_w),
        ("drive_w_per_m_per_s", energy.drive_w_per_m_per_s),
        ("turn_w_per_rad_per_s", energy.turn_w_per_rad_per_s),
        ("tool_w", energy.tool_w),
        ("critical_low_charging_level_percent", charging.critical_low_charging_level),
        ("minimum_desired_charging_level_percent", charging.minimum_desired_charging_level),
        ("sufficient_charging_level_percent", charging.sufficient_charging_level),
        ("maximum_desired_charging_level_percent", charging.maximum_desired_charging_level),
    ];
    let mut facts: BTreeMap<String, String> =
        numbers.iter().map(|&(key, value)| (key.to_owned(), value.to_string())).collect();
    facts.insert("series_name".to_owned(), factsheet.series_name.clone());
    facts.insert("state_interval_ms".to_owned(), factsheet.state_interval_ms.to_string());
    facts
}
