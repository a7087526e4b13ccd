//! The floor at the end of a run, as SVG: who covered what, what is left and why, where everybody drove.
//!
//! ```text
//!   ┌────────────────────────────┐
//!   │ title, percent             │
//!   │ ┌────────────────┐  r1 ██  │
//!   │ │ walls, cells,  │  r2 ██  │
//!   │ │ zones, trails, │  gap ██ │
//!   │ │ stations       │         │
//!   │ └────────────────┘         │
//!   └────────────────────────────┘
//! ```

mod svg;
mod trail;

use crate::ledger::Claim;
use crate::log_reader::{Entry, LogError, read_log};
use crate::verify::{RecordedRun, RunHead};
use crate::{Ledger, palette};
use prost::Message;
use protocol::v1;
use std::collections::BTreeMap;
use std::path::Path;
use svg::{Canvas, escape};
use terrain::{Cell, GridMap, Lattice, Point};
use trail::Trail;

/// Everything that is drawn.
#[derive(Debug)]
pub struct Picture {
    map: GridMap,
    body_radius_m: f64,
    title: String,
    ledger: Ledger,
    status: v1::FleetStatus,
    percent: Option<f64>,
    trails: BTreeMap<String, Trail>,
}

impl Picture {
    /// An empty floor.
    pub fn new(map: GridMap, body_radius_m: f64, title: &str) -> Self {
        Self {
            map,
            body_radius_m,
            title: title.to_owned(),
            ledger: Ledger::default(),
            status: v1::FleetStatus::default(),
            percent: None,
            trails: BTreeMap::new(),
        }
    }

    /// Takes in what changed in the ledger.
    ///
    /// # Errors
    ///
    /// [`LogError::Damaged`] when it speaks of cells that do not exist.
    pub fn take_delta(&mut self, delta: &v1::CoverageDelta) -> Result<(), LogError> {
        self.ledger.take(delta)
    }

    /// Takes in how everything stands; the last one is drawn.
    pub fn take_status(&mut self, status: &v1::FleetStatus) {
        self.percent = status.progress.map(|progress| progress.covered_percent).or(self.percent);
        for robot in &status.robots {
            self.ledger.number_of(&robot.serial_number);
        }
        self.status.clone_from(status);
    }

    /// Takes in where a robot says it is.
    pub fn take_pose(&mut self, robot: &str, pose: &v1::Pose) {
        let here = Point::new(pose.x_m, pose.y_m);
        if !(here.x.is_finite() && here.y.is_finite()) {
            return;
        }
        match self.trails.get_mut(robot) {
            Some(trail) => trail.add(here),
            None => drop(self.trails.insert(robot.to_owned(), Trail::new(here))),
        }
    }

    /// Takes in the last word.
    pub fn take_result(&mut self, result: &v1::MissionResult) {
        self.percent = result.progress.map(|progress| progress.covered_percent).or(self.percent);
        self.title = format!("{}  {}", result.mission_id, result.mission_state().as_str_name());
    }

    /// The picture.
    pub fn to_svg(&mut self) -> String {
        for robot in self.trails.keys() {
            self.ledger.number_of(robot);
        }
        let mut canvas = Canvas::new(self.map.origin(), self.map.corner());
        self.draw_cells(&mut canvas);
        self.draw_walls(&mut canvas);
        self.draw_zones(&mut canvas);
        self.draw_trails(&mut canvas);
        self.draw_stations(&mut canvas);
        self.draw_robots(&mut canvas);
        let percent = self.percent.map_or_else(String::new, |percent| format!("{percent:.1} % covered"));
        canvas.finish(&self.title, &percent, &self.legend())
    }

    fn draw_cells(&self, canvas: &mut Canvas) {
        let Some(lattice) = self.ledger.lattice() else { return };
        let mut paints: BTreeMap<Paint, Vec<Run>> = BTreeMap::new();
        for run in runs(self.ledger.cells().map(|(cell, claim)| (cell, Paint::of(claim)))) {
            paints.entry(run.0).or_default().push(run.1);
        }
        for (paint, runs) in &paints {
            let Some((fill, opacity, title)) = self.look(*paint) else { continue };
            let boxes = runs.iter().map(|run| run.corners(lattice));
            canvas.boxes(boxes, &fill, opacity, &title);
        }
    }

    fn look(&self, paint: Paint) -> Option<(String, f64, String)> {
        let name = |robot: Option<u16>| {
            let number = robot.map_or(0, usize::from);
            (palette::robot(number), self.ledger.robots().get(number).cloned().unwrap_or_default())
        };
        match paint {
            Paint::Nothing => None,
            Paint::NotYet => Some((palette::NOT_YET.to_owned(), 1.0, "not yet assigned".to_owned())),
            Paint::Covered(robot) => {
                let (colour, id) = name(robot);
                Some((colour, 0.6, format!("covered by {id}")))
            }
            Paint::Assigned(robot) => {
                let (colour, id) = name(robot);
                Some((colour, 0.18, format!("assigned to {id}")))
            }
            Paint::Gap(status, reason) => {
                let (status, reason) = (cell_status(status), unreachable_reason(reason));
                Some((palette::GAP.to_owned(), 0.9, format!("{status}: {reason}")))
            }
        }
    }

    fn draw_walls(&self, canvas: &mut Canvas) {
        let map = &self.map;
        let lattice = Lattice {
            origin: map.origin(),
            cell_m: map.resolution_m(),
            columns: map.columns(),
            rows: map.rows(),
        };
        let squares = lattice.cells().map(|cell| (cell, !map.is_free(cell.x.into(), cell.y.into())));
        let walls = runs(squares).filter(|(blocked, _)| *blocked);
        canvas.boxes(walls.map(|(_, run)| run.corners(&lattice)), palette::WALL, 1.0, "");
    }

    fn draw_zones(&self, canvas: &mut Canvas) {
        let half = self.ledger.lattice().map_or(0.1, |lattice| lattice.cell_m / 2.0);
        for zone in &self.status.zones {
            let kind = zone.zone_type().as_str_name().trim_start_matches("ZONE_").to_lowercase();
            let boxes = zone.cells.iter().map(|cell| {
                let centre = Point::new(cell.x_m, cell.y_m);
                let reach = terrain::Vector::new(half, half);
                (centre - reach, centre + reach)
            });
            canvas.boxes(boxes, palette::ZONE, 0.55, &format!("{kind}, from {}", zone.cause));
        }
    }

    fn draw_trails(&self, canvas: &mut Canvas) {
        for (robot, trail) in &self.trails {
            let colour = palette::robot_dark(self.number_of(robot));
            canvas.line(trail.points(), &colour, 0.15 * self.body_radius_m);
        }
    }

    fn draw_stations(&self, canvas: &mut Canvas) {
        for station in &self.status.stations {
            let place = station.position.unwrap_or_default();
            let place = Point::new(place.x_m, place.y_m);
            canvas.disc(place, 0.6 * self.body_radius_m, palette::STATION, &station.station_id);
        }
    }

    fn draw_robots(&self, canvas: &mut Canvas) {
        for robot in &self.status.robots {
            let Some(pose) = robot.pose else { continue };
            let place = Point::new(pose.x_m, pose.y_m);
            let id = &robot.serial_number;
            canvas.disc(place, self.body_radius_m, &palette::robot(self.number_of(id)), id);
            canvas.label(place, id);
        }
    }

    fn number_of(&self, robot: &str) -> usize {
        self.ledger.robots().iter().position(|known| known == robot).unwrap_or(0)
    }

    fn legend(&self) -> Vec<(String, String)> {
        let mut counts = vec![0_usize; self.ledger.robots().len()];
        for claim in self.ledger.claims().iter().filter(|claim| claim.status == v1::CellStatus::CellCovered) {
            if let Some(robot) = claim.robot {
                counts[usize::from(robot)] += 1;
            }
        }
        let robots = self.ledger.robots().iter().zip(counts).enumerate();
        let mut rows: Vec<(String, String)> = robots
            .map(|(number, (id, cells))| (palette::robot(number), format!("{id}  {cells} cells")))
            .collect();
        for (fill, what) in [
            (palette::NOT_YET, "not yet"),
            (palette::GAP, "gap"),
            (palette::ZONE, "zone"),
            (palette::STATION, "station"),
        ] {
            rows.push((fill.to_owned(), what.to_owned()));
        }
        rows.into_iter().map(|(fill, text)| (fill, escape(&text))).collect()
    }
}

/// Draws the picture of a log, as far as it goes.
///
/// # Errors
///
/// [`LogError`] when it cannot be read as a log of ours.
pub fn picture_from_log(path: &Path) -> Result<String, LogError> {
    let mut head = RunHead::default();
    let mut picture = None;
    read_log::<LogError>(std::io::BufReader::new(std::fs::File::open(path)?), |entry| {
        match entry {
            Entry::Metadata { name, facts } => head.take_metadata(name, &facts),
            Entry::Attachment { name, data } => head.take_attachment(name, data),
            Entry::Message { topic, schema, data, .. } => {
                if picture.is_none() {
                    let RecordedRun { map, body_radius_m, mission_id, .. } = head.lay_out()?;
                    picture = Some(Picture::new(map, body_radius_m, &mission_id));
                }
                let picture = picture.as_mut().expect("it was put there");
                take_message(picture, topic, schema, data)?;
            }
        }
        Ok(())
    })?;
    let mut picture = picture.ok_or_else(|| LogError::Foreign("it holds no message".to_owned()))?;
    Ok(picture.to_svg())
}

fn take_message(picture: &mut Picture, topic: &str, schema: &str, data: &[u8]) -> Result<(), LogError> {
    let broken = |error: prost::DecodeError| LogError::Damaged(format!("a message on {topic}: {error}"));
    match schema {
        "oxplow.v1.CoverageDelta" => {
            picture.take_delta(&v1::CoverageDelta::decode(data).map_err(broken)?)?;
        }
        "oxplow.v1.FleetStatus" => picture.take_status(&v1::FleetStatus::decode(data).map_err(broken)?),
        "oxplow.v1.MissionResult" => picture.take_result(&v1::MissionResult::decode(data).map_err(broken)?),
        "oxplow.v1.State" => {
            let state = v1::State::decode(data).map_err(broken)?;
            if let (Some(header), Some(pose)) = (&state.header, &state.pose) {
                picture.take_pose(&header.serial_number, pose);
            }
        }
        _ => {}
    }
    Ok(())
}

/// How a cell is painted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Paint {
    Nothing,
    NotYet,
    Covered(Option<u16>),
    Assigned(Option<u16>),
    Gap(i32, i32),
}

impl Paint {
    fn of(claim: Claim) -> Self {
        match claim.status {
            v1::CellStatus::CellCovered => Self::Covered(claim.robot),
            v1::CellStatus::CellAssigned => Self::Assigned(claim.robot),
            v1::CellStatus::CellUnassigned => Self::NotYet,
            v1::CellStatus::CellUnreachable | v1::CellStatus::CellLost => {
                Self::Gap(claim.status as i32, claim.reason as i32)
            }
            v1::CellStatus::CellExcluded | v1::CellStatus::Unspecified => Self::Nothing,
        }
    }
}

fn cell_status(status: i32) -> &'static str {
    v1::CellStatus::try_from(status).unwrap_or_default().as_str_name().trim_start_matches("CELL_")
}

fn unreachable_reason(reason: i32) -> &'static str {
    v1::UnreachableReason::try_from(reason).unwrap_or_default().as_str_name()
}

/// Cells of one row that look alike.
struct Run {
    first: Cell,
    length: i32,
}

impl Run {
    fn corners(&self, lattice: &Lattice) -> (Point, Point) {
        let half = terrain::Vector::new(lattice.cell_m / 2.0, lattice.cell_m / 2.0);
        let last = Cell::new(self.first.x + self.length - 1, self.first.y);
        (lattice.center(self.first) - half, lattice.center(last) + half)
    }
}

/// Joins neighbours of a row that look alike; cells come row by row.
fn runs<L: PartialEq + Copy>(cells: impl Iterator<Item = (Cell, L)>) -> impl Iterator<Item = (L, Run)> {
    let mut cells = cells.peekable();
    std::iter::from_fn(move || {
        let (first, look) = cells.next()?;
        let mut length = 1;
        while cells
            .next_if(|&(next, other)| other == look && next.y == first.y && next.x == first.x + length)
            .is_some()
        {
            length += 1;
        }
        Some((look, Run { first, length }))
    })
}
