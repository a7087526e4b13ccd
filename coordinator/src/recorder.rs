//! The log: every message of the wire, as MCAP, and beside it what a viewer draws.
//!
//! ```text
//!   Record ──▶ Recorder ──┬─ as it was sent ──────▶ /robots/r1/state, /fleet/decisions, /sim/truth, …
//!                         ├─ LedgerView ──────────▶ /coverage/grid, /coverage/occupancy
//!                         ├─ RobotView ───────────▶ /tf, /robots/r1/pose, /robots/r1/path, …
//!                         └─ Scene ───────────────▶ /fleet/scene
//! ```
//!
//! The recorder has no clock and no thread: its driver calls [`Recorder::flush`] every 200 ms, a rehearsal calls
//! it with virtual time. The same records at the same times give the same bytes. A chunk is written whole by each
//! flush, so a file that was cut off by `kill -9` reads well up to the last flush.
//!
//! Time in the log is mission time after a fixed day ([`protocol::LOG_EPOCH_NS`]): viewers show dates, and two runs of one seed
//! can be compared byte for byte.

mod grid_picture;
mod ledger_view;
mod log_file;
mod palette;
mod robot_view;
mod run_info;
mod scene;
mod schemas;
mod viewer;

pub use log_file::RecordError;
pub use run_info::{MapFile, RunInfo};

use crate::Publication;
use foxglove::messages::{FrameTransforms, Grid, Log, log::Level};
use grid_picture::{GridFrame, coloured, occupancy, occupancy_schema};
use ledger_view::LedgerView;
use log_file::{LogFile, TopicId};
use protocol::{Timestamp, v1};
use robot_view::RobotView;
use scene::Scene;
use schemas::ours;
use std::collections::BTreeMap;
use std::io::Write;
use terrain::GridMap;

/// Larger maps are attached, not drawn.
const MAP_SQUARES_MAX: u64 = 4 << 20;

/// Robots with topics of their own; more than a fleet has, fewer than would fill the file with topics.
const ROBOTS_MAX: usize = 1024;
const UNKNOWN_ROBOT: &str = "unknown";

/// One thing to be logged.
#[derive(Debug, Clone)]
pub enum Record {
    /// From a robot.
    Factsheet(Box<v1::Factsheet>),
    /// From a robot.
    Connection(v1::Connection),
    /// From a robot.
    State(Box<v1::State>),
    /// To a robot.
    Order {
        /// The robot.
        robot: String,
        /// What was sent.
        order: v1::Order,
    },
    /// To a robot.
    Grant {
        /// The robot.
        robot: String,
        /// What was sent.
        grant: v1::Grant,
    },
    /// To a robot.
    InstantActions {
        /// The robot.
        robot: String,
        /// What was sent.
        actions: v1::InstantActions,
    },
    /// To those who watch.
    Publication(Publication),
    /// From a person.
    Operator(v1::OperatorCommand),
    /// From the sim.
    Truth(Box<v1::GroundTruth>),
    /// From the sim.
    Contact(v1::Contact),
    /// From the sim.
    Fault(v1::FaultInjected),
    /// From the driver.
    Transport(v1::TransportStats),
}

/// Writes the log of one run.
pub struct Recorder<W: Write> {
    file: LogFile<W>,
    topics: FleetTopics,
    robots: BTreeMap<String, RobotLog>,
    ledger: LedgerView,
    scene: Scene,
    zones: Vec<v1::Zone>,
    result: Option<v1::MissionResult>,
}

/// The topics that there is one of.
struct FleetTopics {
    tf: TopicId,
    log: TopicId,
    status: TopicId,
    events: TopicId,
    decisions: TopicId,
    reservations: TopicId,
    zones: TopicId,
    result: TopicId,
    faults: TopicId,
    operator: TopicId,
    delta: TopicId,
    progress: TopicId,
    truth: TopicId,
    contacts: TopicId,
    transport: TopicId,
}

/// What there is one of for each robot.
struct RobotLog {
    view: RobotView,
    described: Option<v1::Factsheet>,
    factsheet: TopicId,
    connection: TopicId,
    state: TopicId,
    order: TopicId,
    grant: TopicId,
    instant_actions: TopicId,
}

impl<W: Write> Recorder<W> {
    /// Starts a log: what was run stands first, so that the log can be judged without any other file.
    ///
    /// # Errors
    ///
    /// [`RecordError`] when nothing can be written.
    pub fn new(writer: W, run: &RunInfo) -> Result<Self, RecordError> {
        let mut file = LogFile::new(writer)?;
        run.write_to(&mut file)?;
        let topics = FleetTopics::new(&mut file)?;
        draw_frames(&mut file, topics.tf)?;
        draw_map(&mut file, &run.mission.map)?;
        let ledger = LedgerView::new(&mut file, &run.mission.robots)?;
        let scene = Scene::new(&mut file, run.mission.cell_m)?;
        let robots = BTreeMap::new();
        let mut recorder = Self { file, topics, robots, ledger, scene, zones: Vec::new(), result: None };
        for robot in &run.mission.robots {
            recorder.know(robot)?;
        }
        Ok(recorder)
    }

    /// Logs one thing that happened at `now` (never earlier than the one before).
    ///
    /// # Errors
    ///
    /// [`RecordError`] when it cannot be written; nothing can be from then on.
    pub fn record(&mut self, now: Timestamp, record: &Record) -> Result<(), RecordError> {
        self.file.set_now(now);
        match record {
            Record::Factsheet(factsheet) => self.factsheet(factsheet),
            Record::Connection(connection) => {
                let topic = self.know(id_of(connection.header.as_ref()))?.connection;
                self.file.write(topic, connection)
            }
            Record::State(state) => self.state(state),
            Record::Order { robot, order } => self.order(robot, order),
            Record::Grant { robot, grant } => {
                let topic = self.know(robot)?.grant;
                self.file.write(topic, grant)
            }
            Record::InstantActions { robot, actions } => {
                let topic = self.know(robot)?.instant_actions;
                self.file.write(topic, actions)
            }
            Record::Publication(publication) => self.publication(publication),
            Record::Operator(command) => self.file.write(self.topics.operator, command),
            Record::Truth(truth) => self.file.write(self.topics.truth, truth.as_ref()),
            Record::Contact(contact) => self.file.write(self.topics.contacts, contact),
            Record::Fault(fault) => self.file.write(self.topics.faults, fault),
            Record::Transport(stats) => self.file.write(self.topics.transport, stats),
        }
    }

    fn factsheet(&mut self, factsheet: &v1::Factsheet) -> Result<(), RecordError> {
        let id = id_of(factsheet.header.as_ref());
        let robot = self.know(id)?;
        let topic = robot.factsheet;
        let description = v1::Factsheet { header: None, pid: 0, ..factsheet.clone() };
        if robot.described.as_ref() != Some(&description) {
            let facts = run_info::factsheet_facts(&description);
            robot.described = Some(description);
            self.file.write_metadata(&format!("fleet.factsheet.{id}"), facts)?;
        }
        self.file.write(topic, factsheet)
    }

    fn state(&mut self, state: &v1::State) -> Result<(), RecordError> {
        let id = id_of(state.header.as_ref());
        let topic = self.know(id)?.state;
        self.file.write(topic, state)?;
        match self.robots.get_mut(id) {
            Some(robot) => robot.view.draw_state(&mut self.file, self.topics.tf, state),
            None => Ok(()),
        }
    }

    fn order(&mut self, id: &str, order: &v1::Order) -> Result<(), RecordError> {
        let topic = self.know(id)?.order;
        self.file.write(topic, order)?;
        self.robots.get(id).map_or(Ok(()), |robot| robot.view.draw_order(&mut self.file, order))
    }

    fn publication(&mut self, publication: &Publication) -> Result<(), RecordError> {
        match publication {
            Publication::Status(status) => self.status(status),
            Publication::Coverage(delta) => {
                self.file.write(self.topics.delta, delta)?;
                self.ledger.take(delta);
                self.ledger.draw_if_due(&mut self.file)
            }
            Publication::Decision(decision) => self.file.write(self.topics.decisions, decision),
            Publication::Event(event) => self.event(event),
            Publication::Reservations(held) => self.file.write(self.topics.reservations, held),
            Publication::Result(result) => {
                self.result = Some(result.clone());
                self.file.write(self.topics.result, result)
            }
        }
    }

    fn status(&mut self, status: &v1::FleetStatus) -> Result<(), RecordError> {
        self.file.write(self.topics.status, status)?;
        if let Some(progress) = &status.progress {
            self.file.write(self.topics.progress, progress)?;
        }
        if self.zones != status.zones {
            self.zones.clone_from(&status.zones);
            let zones = v1::Zones { timestamp_ns: status.timestamp_ns, zones: status.zones.clone() };
            self.file.write(self.topics.zones, &zones)?;
        }
        self.ledger.draw_if_due(&mut self.file)?;
        let ledger = &mut self.ledger;
        let colour = |robot: &str| palette::robot(ledger.number_of(robot).into());
        self.scene.draw_if_due(&mut self.file, status, colour)
    }

    fn event(&mut self, event: &v1::Event) -> Result<(), RecordError> {
        self.file.write(self.topics.events, event)?;
        let level = match event.level() {
            v1::EventLevel::EventError => Level::Error,
            v1::EventLevel::EventWarning => Level::Warning,
            _ => Level::Info,
        };
        let name = if event.serial_number.is_empty() { "fleet" } else { &event.serial_number };
        let line = Log {
            timestamp: Some(self.file.stamp()),
            level: level as i32,
            message: format!("{}  {}", event.event, event.text),
            name: name.to_owned(),
            ..Log::default()
        };
        self.file.write(self.topics.log, &line)
    }

    fn know(&mut self, robot: &str) -> Result<&mut RobotLog, RecordError> {
        let room = self.robots.len() < ROBOTS_MAX || self.robots.contains_key(robot);
        let robot = if room { robot } else { UNKNOWN_ROBOT };
        if !self.robots.contains_key(robot) {
            let log = RobotLog::new(&mut self.file, robot)?;
            self.robots.insert(robot.to_owned(), log);
        }
        Ok(self.robots.get_mut(robot).expect("it was put there"))
    }

    /// Makes everything logged so far readable, whatever happens next.
    ///
    /// # Errors
    ///
    /// [`RecordError`] when it cannot be written.
    pub fn flush(&mut self) -> Result<(), RecordError> {
        self.file.flush()
    }

    /// Ends the log in good order and gives the writer back.
    ///
    /// # Errors
    ///
    /// [`RecordError`] when it cannot be written.
    pub fn finish(mut self) -> Result<W, RecordError> {
        self.ledger.draw_last(&mut self.file)?;
        if let Some(result) = &self.result {
            self.file.write_metadata("fleet.result", run_info::result_facts(result))?;
        }
        self.file.finish()
    }
}

impl FleetTopics {
    fn new<W: Write>(file: &mut LogFile<W>) -> Result<Self, RecordError> {
        let mut topic = |name, message| file.add_topic(name, &ours(message));
        Ok(Self {
            status: topic("/fleet/status", "FleetStatus")?,
            events: topic("/fleet/events", "Event")?,
            decisions: topic("/fleet/decisions", "Decision")?,
            reservations: topic("/fleet/reservations", "Reservations")?,
            zones: topic("/fleet/zones", "Zones")?,
            result: topic("/fleet/result", "MissionResult")?,
            faults: topic("/fleet/faults", "FaultInjected")?,
            operator: topic("/fleet/operator", "OperatorCommand")?,
            delta: topic("/coverage/delta", "CoverageDelta")?,
            progress: topic("/coverage/progress", "CoverageProgress")?,
            truth: topic("/sim/truth", "GroundTruth")?,
            contacts: topic("/sim/contacts", "Contact")?,
            transport: topic("/transport/stats", "TransportStats")?,
            tf: file.add_drawn_topic::<FrameTransforms>("/tf")?,
            log: file.add_drawn_topic::<Log>("/log")?,
        })
    }
}

impl RobotLog {
    fn new<W: Write>(file: &mut LogFile<W>, robot: &str) -> Result<Self, RecordError> {
        let mut topic =
            |noun: &str, message| file.add_topic(&format!("/robots/{robot}/{noun}"), &ours(message));
        Ok(Self {
            factsheet: topic("factsheet", "Factsheet")?,
            connection: topic("connection", "Connection")?,
            state: topic("state", "State")?,
            order: topic("order", "Order")?,
            grant: topic("grant", "Grant")?,
            instant_actions: topic("instantActions", "InstantActions")?,
            view: RobotView::new(file, robot)?,
            described: None,
        })
    }
}

/// Who a message is from; whoever gives no good id is logged under `unknown`.
fn id_of(header: Option<&v1::Header>) -> &str {
    let id = header.map(|header| header.serial_number.as_str());
    id.filter(|id| protocol::valid_id(id)).unwrap_or(UNKNOWN_ROBOT)
}

/// The fixed frame comes before everything: a viewer hides what it cannot place.
fn draw_frames<W: Write>(file: &mut LogFile<W>, tf: TopicId) -> Result<(), RecordError> {
    let floor = viewer::transform(file.stamp(), viewer::MAP_FRAME, "floor", &v1::Pose::default());
    file.write(tf, &FrameTransforms { transforms: vec![floor] })
}

fn draw_map<W: Write>(file: &mut LogFile<W>, map: &GridMap) -> Result<(), RecordError> {
    let grid_topic = file.add_drawn_topic::<Grid>("/map")?;
    let occupancy_topic = file.add_topic("/map/occupancy", &occupancy_schema())?;
    let (columns, rows) = (map.columns(), map.rows());
    if u64::from(columns) * u64::from(rows) > MAP_SQUARES_MAX {
        return Ok(());
    }
    let frame = GridFrame { origin: map.origin(), square_m: map.resolution_m(), columns, rows };
    let squares =
        || (0..i64::from(rows)).flat_map(move |y| (0..i64::from(columns)).map(move |x| map.is_free(x, y)));
    let colours = squares().map(|free| if free { palette::FLOOR } else { palette::WALL });
    file.write(grid_topic, &coloured(file.stamp(), frame, colours))?;
    let blocked = squares().map(|free| if free { 0 } else { 100 });
    file.write_bytes(occupancy_topic, &occupancy(file.stamp(), frame, blocked))
}
