//! The end of a mission, for people and for scripts.

use protocol::v1;
use serde::{Deserialize, Serialize};

/// The end of a mission.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// COMPLETED, `COMPLETED_WITH_GAPS`, CANCELLED or FAILED.
    pub result: String,
    /// Why it failed or was cancelled.
    pub cause: String,
    /// Share of the coverable area that is covered, percent.
    pub covered_percent: f64,
    /// Covered area, square metres.
    pub covered_m2: f64,
    /// Area that can be covered, square metres.
    pub coverable_m2: f64,
    /// Free ground that the tool touches from no cell's centre, square metres.
    pub untouchable_m2: f64,
    /// Part of what can be covered that no robot gets to, square metres.
    pub out_of_reach_m2: f64,
    /// Mission time, seconds.
    pub duration_s: f64,
    /// Makespan of the first plan, seconds.
    pub planned_s: f64,
    /// Plans after the first.
    pub replans: u32,
    /// Robots that were lost, at one time or another.
    pub robots_lost: u32,
    /// What was given up, and why.
    pub gaps: Vec<String>,
    /// Parts that no robot gets to.
    pub out_of_reach: Vec<String>,
}

impl Report {
    /// From the coordinator's last word.
    pub fn new(result: &v1::MissionResult) -> Self {
        let progress = result.progress.unwrap_or_default();
        Self {
            result: result.mission_state().as_str_name().to_owned(),
            cause: result.cause.clone(),
            covered_percent: progress.covered_percent,
            covered_m2: progress.covered_m2,
            coverable_m2: progress.coverable_m2,
            untouchable_m2: progress.untouchable_m2,
            out_of_reach_m2: progress.out_of_reach_m2,
            duration_s: result.duration_s,
            planned_s: result.planned_makespan_s,
            replans: result.replans,
            robots_lost: result.robots_lost,
            gaps: result.gaps.iter().map(|gap| gap.text.clone()).collect(),
            out_of_reach: result.out_of_reach.iter().map(|part| part.text.clone()).collect(),
        }
    }

    /// One line of JSON.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("a report is plain data")
    }
}

impl std::fmt::Display for Report {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "result       {}", self.result)?;
        if !self.cause.is_empty() {
            writeln!(f, "cause        {}", self.cause)?;
        }
        writeln!(
            f,
            "covered      {:.2} % ({:.1} of {:.1} m²)",
            self.covered_percent, self.covered_m2, self.coverable_m2
        )?;
        writeln!(
            f,
            "untouchable  {:.1} m² of free ground that the tool touches from no cell",
            self.untouchable_m2
        )?;
        writeln!(f, "mission time {:.0} s (first plan: {:.0} s)", self.duration_s, self.planned_s)?;
        write!(f, "replans      {}, robots lost {}", self.replans, self.robots_lost)?;
        for gap in &self.gaps {
            write!(f, "\ngap          {gap}")?;
        }
        for part in &self.out_of_reach {
            write!(f, "\nout of reach {part}")?;
        }
        Ok(())
    }
}
