//! A scenario: one story in one TOML file: the floor, the robots, and what goes wrong.
//!
//! ```text
//!   [mission]  what is to be covered      [sim]      how the world behaves
//!   [robot]    what every robot is        [network]  the link (rehearsals only)
//!   [fleet]    how many, or [[robots]]    [[fault]]  what goes wrong, and when
//!   [[stations]]  [coordinator]
//! ```
//!
//! Units stand in the keys, unknown keys are refused, every error names file, line and key. The reference is
//! `docs/scenario.md`; `scenarios/default.toml` holds every key with its default.

mod check;
mod error;
mod fleet;
mod link;
mod machine;
mod mission;
mod physics;
mod station;

pub use check::SWEEP_TOLERANCE_M;
pub use error::ScenarioError;
pub use fleet::{FleetTable, RobotEntry};
pub use link::NetworkTable;
pub use machine::{BatteryTable, ChargingTable, RobotTable};
pub use mission::MissionTable;
pub use physics::{CarryOff, SimTable};
pub use station::StationEntry;

use crate::faults::FaultEntry;
use coordinator::{Config, Mission, Station, Timing};
use error::{Refused, line_at, line_of};
use protocol::v1;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use terrain::{Floor, GridMap, MapFile, Point};

/// What a scenario file says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScenarioFile {
    /// What is to be covered, and how.
    pub mission: MissionTable,
    /// What every robot is and can do.
    #[serde(default)]
    pub robot: RobotTable,
    /// Robots that are only counted; instead of `[[robots]]`.
    #[serde(default)]
    pub fleet: Option<FleetTable>,
    /// Robots one by one; instead of `[fleet]`.
    #[serde(default)]
    pub robots: Vec<RobotEntry>,
    /// Where robots charge.
    #[serde(default)]
    pub stations: Vec<StationEntry>,
    /// When the coordinator decides what.
    #[serde(default)]
    pub coordinator: Timing,
    /// How the world behaves.
    #[serde(default)]
    pub sim: SimTable,
    /// The link between robots and coordinator, in rehearsals.
    #[serde(default)]
    pub network: NetworkTable,
    /// What goes wrong, and when.
    #[serde(default, rename = "fault")]
    pub faults: Vec<FaultEntry>,
}

impl ScenarioFile {
    /// Side of a cell, metres.
    pub fn cell_m(&self) -> f64 {
        self.mission.cell_m.unwrap_or_else(|| check::default_cell_m(self.robot.tool_width_m))
    }
}

/// A scenario that was read and checked, with its map.
#[derive(Debug, Clone)]
pub struct Scenario {
    /// What the file says; `robots` is filled in when the file only counts them.
    pub file: ScenarioFile,
    /// The file itself, for the log.
    pub text: String,
    /// Where it was read.
    pub path: PathBuf,
    /// Where its map was read.
    pub map_path: PathBuf,
    /// The map.
    pub map: Arc<GridMap>,
    /// The lattice with what the fleet's robots can do on it.
    pub floor: Arc<Floor>,
}

impl Scenario {
    /// Reads a scenario file and the map it names.
    ///
    /// # Errors
    ///
    /// [`ScenarioError`], naming file, line and key, and what to do.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, ScenarioError> {
        let path = path.as_ref();
        let text = read(path)?;
        Self::parse(&text, path)
    }

    /// Reads a scenario from its text; the map is looked for relative to `path`.
    ///
    /// # Errors
    ///
    /// [`ScenarioError`], naming file, line and key, and what to do.
    pub fn parse(text: &str, path: &Path) -> Result<Self, ScenarioError> {
        let refused = |Refused { key, what }: Refused| ScenarioError::Value {
            path: path.to_owned(),
            line: line_of(text, &key),
            key,
            what,
        };
        let file = parse_file(text, path)?;
        check::check_values(&file).map_err(refused)?;
        let map_path = path.parent().unwrap_or(Path::new(".")).join(&file.mission.map);
        let map = load_map(&map_path, &file)?;
        let mut scenario = Self::on_map(file, map).map_err(refused)?;
        (scenario.text, scenario.path, scenario.map_path) = (text.to_owned(), path.to_owned(), map_path);
        Ok(scenario)
    }

    /// A scenario from its parts, for tests and random stories.
    pub(crate) fn on_map(mut file: ScenarioFile, map: GridMap) -> Result<Self, Refused> {
        let robot = &file.robot;
        let tool_width_m = robot.tool_width_m - 2.0 * SWEEP_TOLERANCE_M;
        let room_m = robot.body_radius_m + coordinator::WALL_MARGIN_M;
        let floor =
            Floor::new(&map, file.cell_m(), room_m, tool_width_m).map_err(|error| Refused::floor(&error))?;
        if !floor.tool_fits(&map, robot.tool_width_m) {
            let width_m = robot.tool_width_m;
            let what = format!("a tool of {width_m} m is wider than every passage; give a narrower one");
            return Err(Refused::new("robot.tool_width_m", what));
        }
        match (&file.fleet, file.robots.is_empty()) {
            (Some(_), false) => {
                return Err(Refused::new("fleet", "there are `[[robots]]`, too; keep one of the two"));
            }
            (None, true) => {
                return Err(Refused::new(
                    "robots",
                    "there is no robot; add `[fleet] count = N` or `[[robots]]`",
                ));
            }
            (Some(fleet), true) => file.robots = fleet::find_starts(fleet, &floor)?,
            (None, false) => {}
        }
        check::check_places(&file, &map, &floor)?;
        let scenario = Self {
            file,
            text: String::new(),
            path: PathBuf::new(),
            map_path: PathBuf::new(),
            map: Arc::new(map),
            floor: Arc::new(floor),
        };
        for (number, fault) in scenario.file.faults.iter().enumerate() {
            fault.check(&scenario).map_err(|what| Refused::new(format!("fault[{number}]"), what))?;
        }
        Ok(scenario)
    }

    /// What the coordinator is told at its start.
    pub fn coordinator_config(&self, term: u64) -> Config {
        let file = &self.file;
        let station = |entry: &StationEntry| Station {
            id: entry.id.clone(),
            position: Point::new(entry.x_m, entry.y_m),
        };
        Config {
            mission: Mission {
                id: file.mission.id.clone(),
                map: Arc::clone(&self.map),
                cell_m: file.cell_m(),
                body_radius_m: file.robot.body_radius_m,
                tool_width_m: file.robot.tool_width_m,
                stations: file.stations.iter().map(station).collect(),
                planner: file.mission.planner.clone(),
                return_to_start: file.mission.return_to_start,
                robots: file.robots.iter().map(|robot| robot.id.clone()).collect(),
            },
            timing: file.coordinator.clone(),
            term,
            seed: file.mission.seed,
        }
    }

    /// What every robot says of itself; header and process id are the agent's to fill in.
    pub fn factsheet(&self) -> v1::Factsheet {
        self.file.robot.factsheet()
    }
}

/// The JSON schema of scenario files.
pub fn scenario_schema() -> schemars::Schema {
    schemars::schema_for!(ScenarioFile)
}

fn parse_file(text: &str, path: &Path) -> Result<ScenarioFile, ScenarioError> {
    toml::from_str(text).map_err(|error| ScenarioError::Format {
        path: path.to_owned(),
        line: error.span().map_or(1, |span| line_at(text, span.start)),
        what: format!("{}; the keys are listed in docs/scenario.md", error.message()),
    })
}

/// Polygons are laid out in squares that are an eighth of a cell wide: as fine as the ledger's samples.
fn load_map(path: &Path, file: &ScenarioFile) -> Result<GridMap, ScenarioError> {
    let metres_per_character = file.mission.metres_per_character.unwrap_or(1.0);
    Ok(MapFile { metres_per_character, square_m: file.cell_m() / 8.0 }.load(path)?)
}

fn read(path: &Path) -> Result<String, ScenarioError> {
    std::fs::read_to_string(path).map_err(|source| ScenarioError::Read { path: path.to_owned(), source })
}
