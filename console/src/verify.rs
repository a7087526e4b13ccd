//! The judge: what truly happened, recomputed from a log, against what the coordinator claimed.
//!
//! ```text
//!   /sim/truth ──────────▶ true sweep, contacts, batteries ─┐
//!   /robots/*/state ─────▶ reported sweep, reported charge ─┼──▶ Verdict
//!   /coverage/delta, /fleet/result ─▶ claims ───────────────┘
//! ```
//!
//! Nothing of what the coordinator computed is used but its claims; the floor is laid out again from the map at
//! the head of the log. A cell that is claimed COVERED must truly have been swept, 99 of 100 parts of what the
//! tool can reach there, and must have been reported so, too. Truth that is further apart than half a second
//! proves nothing about what lies between.

mod batteries;
mod claims;
mod contacts;
mod recorded_run;
mod reported_sweep;
mod true_sweep;
mod truth;
mod verdict;

pub(crate) use recorded_run::{RecordedRun, RunHead};
pub use verdict::{BatteryFigures, ContactFigures, CoverageFigures, GapFigures, Verdict, Violation};

use crate::Ledger;
use crate::log_reader::{Ending, Entry, LogError, read_log};
use batteries::Batteries;
use contacts::{ContactKind, Contacts};
use prost::Message;
use protocol::{LOG_EPOCH_NS, v1};
use reported_sweep::ReportedSweep;
use std::collections::{BTreeMap, VecDeque};
use std::io::Read;
use std::path::Path;
use terrain::{Point, SweptRaster};
use truth::TruthBefore;

/// A claim may stand in the log before the truth that it rests on, by this much; in a log that was cut off, claims
/// younger than this are not judged.
const TRUTH_DELAY_S: f64 = 0.5;

/// Judges the log in a file.
///
/// # Errors
///
/// [`LogError`] when it cannot be read as a log of ours. Whatever it says, reading it does not panic.
pub fn verify_log(path: &Path) -> Result<Verdict, LogError> {
    verify_from(std::io::BufReader::new(std::fs::File::open(path)?))
}

/// Judges the bytes of a log.
///
/// # Errors
///
/// As [`verify_log`].
pub fn verify_bytes(log: &[u8]) -> Result<Verdict, LogError> {
    verify_from(log)
}

fn verify_from(source: impl Read) -> Result<Verdict, LogError> {
    let mut head = RunHead::default();
    let mut judge = None;
    let ending = read_log::<LogError>(source, |entry| {
        match entry {
            Entry::Metadata { name, facts } => head.take_metadata(name, &facts),
            Entry::Attachment { name, data } => head.take_attachment(name, data),
            Entry::Message { topic, schema, log_time_ns, data } => {
                if judge.is_none() {
                    judge = Some(Judge::new(head.lay_out()?));
                }
                let judge = judge.as_mut().expect("it was put there");
                judge.now_s = log_time_ns.saturating_sub(LOG_EPOCH_NS) as f64 / 1e9;
                judge.take_claims_before(judge.now_s - TRUTH_DELAY_S)?;
                judge.message(topic, schema, data)?;
            }
        }
        Ok(())
    })?;
    let mut judge = judge.ok_or_else(|| LogError::Foreign("it holds no message".to_owned()))?;
    if ending == Ending::Whole {
        judge.take_claims_before(f64::INFINITY)?;
    }
    Ok(judge.conclude(ending == Ending::Whole))
}

/// What the judge has seen so far.
struct Judge {
    run: RecordedRun,
    now_s: f64,
    truly_swept: SweptRaster,
    reported_swept: SweptRaster,
    reports: ReportedSweep,
    ledger: Ledger,
    fresh_claims: VecDeque<(f64, v1::CoverageDelta)>,
    before: TruthBefore,
    contacts: Contacts,
    batteries: Batteries,
    robots: BTreeMap<String, RobotSizes>,
    speeds_max: BTreeMap<String, f64>,
    starts: BTreeMap<String, Point>,
    result: Option<v1::MissionResult>,
    figures: ContactFigures,
    contacts_told_by_sim: u64,
    states: u64,
    record_dropped: u64,
    violations: Vec<Violation>,
}

#[derive(Clone, Copy)]
struct RobotSizes {
    body_radius_m: f64,
    tool_radius_m: f64,
}

impl Judge {
    fn new(run: RecordedRun) -> Self {
        let lattice = *run.floor.lattice();
        Self {
            run,
            now_s: 0.0,
            truly_swept: SweptRaster::new(lattice),
            reported_swept: SweptRaster::new(lattice),
            reports: ReportedSweep::default(),
            ledger: Ledger::default(),
            fresh_claims: VecDeque::new(),
            before: TruthBefore::default(),
            contacts: Contacts::default(),
            batteries: Batteries::default(),
            robots: BTreeMap::new(),
            speeds_max: BTreeMap::new(),
            starts: BTreeMap::new(),
            result: None,
            figures: ContactFigures::default(),
            contacts_told_by_sim: 0,
            states: 0,
            record_dropped: 0,
            violations: Vec::new(),
        }
    }

    fn message(&mut self, topic: &str, schema: &str, data: &[u8]) -> Result<(), LogError> {
        match schema {
            "oxplow.v1.GroundTruth" => self.truth(decode(topic, data)?),
            "oxplow.v1.State" => self.state(&decode(topic, data)?),
            "oxplow.v1.Factsheet" => self.factsheet(&decode(topic, data)?),
            "oxplow.v1.CoverageDelta" => self.fresh_claims.push_back((self.now_s, decode(topic, data)?)),
            "oxplow.v1.MissionResult" => self.result = Some(decode(topic, data)?),
            "oxplow.v1.Contact" => self.contact_told(&decode(topic, data)?),
            "oxplow.v1.TransportStats" => {
                self.record_dropped = decode::<v1::TransportStats>(topic, data)?.record_dropped;
            }
            _ => {}
        }
        Ok(())
    }

    fn take_claims_before(&mut self, time_s: f64) -> Result<(), LogError> {
        while self.fresh_claims.front().is_some_and(|&(at_s, _)| at_s < time_s) {
            if let Some((_, delta)) = self.fresh_claims.pop_front() {
                self.ledger.take(&delta)?;
            }
        }
        Ok(())
    }

    fn sizes(&self, robot: &str) -> RobotSizes {
        self.robots.get(robot).copied().unwrap_or(RobotSizes {
            body_radius_m: self.run.body_radius_m,
            tool_radius_m: self.run.tool_width_m / 2.0,
        })
    }

    fn factsheet(&mut self, factsheet: &v1::Factsheet) {
        let Some(header) = &factsheet.header else { return };
        let sensible = |metres: f64| (metres > 0.0 && metres < 100.0).then_some(metres);
        let (Some(body_radius_m), Some(tool_width_m)) =
            (sensible(factsheet.body_radius_m), sensible(factsheet.tool_width_m))
        else {
            return;
        };
        let sizes = RobotSizes { body_radius_m, tool_radius_m: tool_width_m / 2.0 };
        self.robots.insert(header.serial_number.clone(), sizes);
        if let Some(speed) = sensible(factsheet.speed_max_m_per_s) {
            self.speeds_max.insert(header.serial_number.clone(), speed);
        }
    }

    fn truth(&mut self, truth: v1::GroundTruth) {
        let Some(joined) = self.before.admit(&truth) else { return };
        let before = std::mem::take(&mut self.before);
        let steps = before.steps(&truth, joined, &self.speeds_max);
        for step in &steps {
            let tool_radius_m = self.sizes(step.robot).tool_radius_m;
            true_sweep::sweep_step(&mut self.truly_swept, step, tool_radius_m);
            if !self.starts.contains_key(step.robot) {
                self.starts.insert(step.robot.to_owned(), step.to);
            }
            if let Some(text) = self.batteries.take_truth(self.now_s, step.now) {
                self.violate("battery", text);
            }
        }
        self.look_for_contacts(&steps, &truth.obstacles);
        self.before = TruthBefore { truth, ..before };
    }

    fn look_for_contacts(&mut self, steps: &[truth::Step<'_>], obstacles: &[v1::ObstacleTruth]) {
        let mut contacts = std::mem::take(&mut self.contacts);
        let radius_m = |robot: &str| self.sizes(robot).body_radius_m;
        let begun = contacts.begin(steps, obstacles, &self.run.map, radius_m);
        self.contacts = contacts;
        for contact in begun {
            let (count, rule) = match contact.kind {
                ContactKind::Robot => (&mut self.figures.between_robots, "contact"),
                ContactKind::Wall => (&mut self.figures.walls_entered, "obstacle"),
                ContactKind::Obstacle => (&mut self.figures.obstacles_entered, "obstacle"),
                ContactKind::Person => (&mut self.figures.people_driven_into, "person"),
            };
            *count += 1;
            let contacts::Contact { robot, other, place, .. } = contact;
            self.violate(rule, format!("{robot} touches {other} at ({:.2}, {:.2})", place.x, place.y));
        }
    }

    fn contact_told(&mut self, contact: &v1::Contact) {
        if !contact.person_walked_into {
            self.contacts_told_by_sim += 1;
        }
    }

    fn state(&mut self, state: &v1::State) {
        self.states += 1;
        let Some(header) = &state.header else { return };
        let tool_radius_m = self.sizes(&header.serial_number).tool_radius_m;
        self.reports.take(&mut self.reported_swept, state, tool_radius_m);
        if let Some(text) = self.batteries.take_state(self.now_s, state) {
            self.violate("battery", text);
        }
    }

    fn violate(&mut self, rule: &'static str, text: String) {
        self.violations.push(Violation { rule, at_s: Some(self.now_s), text });
    }
}

fn decode<M: Message + Default>(topic: &str, data: &[u8]) -> Result<M, LogError> {
    M::decode(data).map_err(|error| LogError::Damaged(format!("a message on {topic}: {error}")))
}
