//! What the judge says: figures, and every rule that was broken.

use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

/// The whole verdict. As JSON it is what `oxplow verify --json` prints.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Verdict {
    /// Always `oxplow-verdict/1`.
    pub format: &'static str,
    /// The mission.
    pub mission_id: String,
    /// Whether the log has its end; else it was judged as far as it goes.
    pub log_is_whole: bool,
    /// The last word of the mission, if it was spoken.
    pub mission_state: Option<String>,
    /// Mission time of the last message, seconds.
    pub duration_s: f64,
    /// Whether no rule was broken and no claim is false.
    pub agrees: bool,
    /// Whether ground that could be reached is not covered.
    pub gaps_left: bool,
    /// Areas.
    pub coverage: CoverageFigures,
    /// Contacts.
    pub contacts: ContactFigures,
    /// Batteries.
    pub battery: BatteryFigures,
    /// Number of truths that were read.
    pub truths: u64,
    /// Number of truths that are missing between them.
    pub truths_lost: u64,
    /// Time between truths too far apart to be joined, seconds.
    pub unseen_s: f64,
    /// Number of reports that were read.
    pub states: u64,
    /// Records that the log's own writer dropped.
    pub records_dropped: u64,
    /// Ground that is not covered, by reason.
    pub gaps: Vec<GapFigures>,
    /// Every rule that was broken.
    pub violations: Vec<Violation>,
}

/// Areas.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct CoverageFigures {
    /// What the tools can reach with the tolerance that the run allowed for pose errors, square metres.
    pub coverable_m2: f64,
    /// What only the rim of a tool that follows its path exactly could reach besides; it is not demanded.
    pub rim_m2: f64,
    /// What they swept of it by their true poses, square metres.
    pub truly_swept_m2: f64,
    /// The same in percent.
    pub truly_swept_percent: f64,
    /// What they swept of it by their reports, pose error subtracted, square metres.
    pub reported_swept_m2: f64,
    /// Cells that are claimed COVERED.
    pub claimed_cells: u64,
    /// Area that the mission's result claims, square metres.
    pub claimed_m2: Option<f64>,
    /// Cells that are claimed and were not swept.
    pub falsely_claimed_cells: u64,
    /// What was not swept of them, square metres.
    pub falsely_claimed_m2: f64,
    /// Cells that are claimed and were not reported.
    pub unproven_cells: u64,
    /// What was not reported of them, square metres.
    pub unproven_m2: f64,
}

/// Contacts, each counted once however long it lasts.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
pub struct ContactFigures {
    /// Two robots touched.
    pub between_robots: u64,
    /// A robot entered a wall of the map.
    pub walls_entered: u64,
    /// A robot entered an obstacle.
    pub obstacles_entered: u64,
    /// A robot drove into a person.
    pub people_driven_into: u64,
    /// Contacts that the simulation saw itself.
    pub told_by_sim: u64,
    /// The smallest distance between two bodies, metres.
    pub smallest_gap_m: Option<f64>,
}

/// Batteries.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
pub struct BatteryFigures {
    /// The lowest true charge of each robot, percent.
    pub lowest_percent: BTreeMap<String, f64>,
    /// The largest error of a reported charge, percentage points.
    pub report_error_percent: f64,
}

/// Ground that is not covered.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct GapFigures {
    /// What the ledger says about it.
    pub reason: String,
    /// Number of cells.
    pub cells: u64,
    /// Their area, with what is not floor, square metres.
    pub at_most_m2: f64,
}

/// A rule that was broken.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Violation {
    /// Which: coverage, evidence, contact, obstacle, person, battery, ledger, result.
    pub rule: &'static str,
    /// When, seconds of mission time; absent for what is wrong at the end.
    pub at_s: Option<f64>,
    /// What happened.
    pub text: String,
}

impl Verdict {
    /// Exit code of `oxplow verify`: 0 agrees and no gap, 3 agrees and gaps are left, 1 does not agree.
    pub fn exit_code(&self) -> u8 {
        match (self.agrees, self.gaps_left) {
            (false, _) => 1,
            (true, true) => 3,
            (true, false) => 0,
        }
    }

    /// The same verdict as JSON.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("a verdict has nothing that JSON cannot say")
    }

    fn last_word(&self) -> String {
        let state = self.mission_state.as_deref().unwrap_or("not ended");
        let cut =
            if self.log_is_whole { "" } else { "; the log was cut off and is judged as far as it goes" };
        format!("{} after {:.1} s{cut}", state, self.duration_s)
    }

    fn figures(&self) -> Vec<(&'static str, String)> {
        let (coverage, contacts) = (&self.coverage, &self.contacts);
        let claimed = coverage.claimed_m2.map_or_else(|| "-".to_owned(), |m2| format!("{m2:.2} m²"));
        let gap = contacts.smallest_gap_m.map_or_else(|| "-".to_owned(), |gap_m| format!("{gap_m:.3} m"));
        let lowest = self.battery.lowest_percent.iter().min_by(|a, b| a.1.total_cmp(b.1));
        let lowest =
            lowest.map_or_else(|| "-".to_owned(), |(robot, percent)| format!("{percent:.1} % ({robot})"));
        vec![
            ("mission", format!("{}: {}", self.mission_id, self.last_word())),
            (
                "coverable",
                format!("{:.2} m² (and {:.2} m² by the rim)", coverage.coverable_m2, coverage.rim_m2),
            ),
            (
                "truly swept",
                format!("{:.2} m² ({:.2} %)", coverage.truly_swept_m2, coverage.truly_swept_percent),
            ),
            ("reported swept", format!("{:.2} m²", coverage.reported_swept_m2)),
            ("claimed covered", format!("{claimed} in {} cells", coverage.claimed_cells)),
            (
                "falsely claimed",
                format!("{:.3} m² in {} cells", coverage.falsely_claimed_m2, coverage.falsely_claimed_cells),
            ),
            (
                "claimed without report",
                format!("{:.3} m² in {} cells", coverage.unproven_m2, coverage.unproven_cells),
            ),
            ("contacts between robots", contacts.between_robots.to_string()),
            ("smallest distance", gap),
            (
                "walls, obstacles entered",
                format!("{}, {}", contacts.walls_entered, contacts.obstacles_entered),
            ),
            ("people driven into", contacts.people_driven_into.to_string()),
            ("lowest battery", lowest),
            ("charge misreported by", format!("{:.2} points", self.battery.report_error_percent)),
            ("truths, lost", format!("{}, {}", self.truths, self.truths_lost)),
        ]
    }
}

/// The table of figures, what was broken, and the last line: what it comes to.
impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, figure) in self.figures() {
            writeln!(f, "{name:<26}{figure}")?;
        }
        for gap in &self.gaps {
            writeln!(
                f,
                "{:<26}{} cells, at most {:.2} m²: {}",
                "open", gap.cells, gap.at_most_m2, gap.reason
            )?;
        }
        for violation in &self.violations {
            let at = violation.at_s.map_or_else(String::new, |at_s| format!(" at {at_s:.1} s"));
            writeln!(f, "VIOLATION  {}{at}: {}", violation.rule, violation.text)?;
        }
        match self.exit_code() {
            0 => write!(f, "AGREES: what is claimed was done"),
            3 => write!(f, "AGREES: what is claimed was done; ground is left open"),
            _ => write!(f, "DISAGREES: {} violations", self.violations.len()),
        }
    }
}
