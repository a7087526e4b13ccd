//! The judgement: every claim against what was swept.

use super::verdict::{BatteryFigures, CoverageFigures, GapFigures, Verdict, Violation};
use super::{ContactFigures, Judge};
use protocol::v1;
use std::collections::BTreeMap;
use terrain::{Cell, Passages, Segment, SweptRaster};

/// The share of what the tool can reach in a cell that must have been swept where the cell is claimed.
const SHARE_MIN: f64 = 0.99;
/// Claimed area may differ from ours by rounding.
const AREA_SHARE_SLACK: f64 = 0.001;

/// What comes out when claims are held against what was swept.
#[derive(Default)]
struct Comparison {
    falsely_claimed: Vec<Cell>,
    falsely_claimed_samples: u64,
    unproven: Vec<Cell>,
    unproven_samples: u64,
    gaps: Vec<(Cell, String)>,
    truly_swept_samples: u64,
    reported_samples: u64,
    coverable_samples: u64,
}

impl Judge {
    /// The verdict about everything that was read.
    pub(super) fn conclude(mut self, whole: bool) -> Verdict {
        let comparison = self.compare();
        self.judge_lattice();
        self.judge_cells(&comparison);
        self.judge_result(&comparison);
        self.judge_evidence();
        let state = self.result.as_ref().map(v1::MissionResult::mission_state);
        Verdict {
            format: "oxplow-verdict/1",
            mission_id: self.run.mission_id.clone(),
            log_is_whole: whole,
            mission_state: state.map(|state| state.as_str_name().to_owned()),
            duration_s: self.now_s,
            agrees: self.violations.is_empty(),
            gaps_left: !comparison.gaps.is_empty(),
            coverage: self.coverage_figures(&comparison),
            contacts: ContactFigures {
                told_by_sim: self.contacts_told_by_sim,
                smallest_gap_m: Some(self.contacts.smallest_gap_m).filter(|gap_m| gap_m.is_finite()),
                ..self.figures
            },
            battery: self.battery_figures(),
            truths: self.before.samples,
            truths_lost: self.before.lost,
            unseen_s: self.before.unseen_s,
            states: self.states,
            records_dropped: self.record_dropped,
            gaps: gap_figures(&comparison.gaps, self.run.floor.lattice().cell_m),
            violations: self.violations,
        }
    }

    /// Whether the claims lie on our lattice; if not, none of them can be held against anything.
    fn claims_fit(&self) -> bool {
        self.ledger.lattice() == Some(self.run.floor.lattice())
    }

    fn judge_lattice(&mut self) {
        if self.ledger.lattice().is_some() && !self.claims_fit() {
            let text = "the ledger lies on another lattice than the map and cell size at the head of the log";
            self.violate_at_end("ledger", text.to_owned());
        }
        let missing = self.ledger.missing_deltas();
        if missing > 0 {
            self.violate_at_end("ledger", format!("{missing} deltas of the ledger are missing"));
        }
    }

    fn compare(&self) -> Comparison {
        let floor = &self.run.floor;
        let reachable = self.reachable();
        let claims = if self.claims_fit() { self.ledger.claims() } else { &[] };
        let mut comparison = Comparison::default();
        for (index, cell) in floor.lattice().cells().enumerate() {
            let required = floor.required(index);
            let truly = required & self.truly_swept.samples(index);
            let reported = required & self.reported_swept.samples(index);
            comparison.coverable_samples += u64::from(required.count_ones());
            comparison.truly_swept_samples += u64::from(truly.count_ones());
            comparison.reported_samples += u64::from(reported.count_ones());
            let claim = claims.get(index).copied().unwrap_or_default();
            if claim.status == v1::CellStatus::CellCovered {
                if falls_short(truly, required) {
                    comparison.falsely_claimed.push(cell);
                    comparison.falsely_claimed_samples += u64::from((required & !truly).count_ones());
                }
                if falls_short(reported, required) {
                    comparison.unproven.push(cell);
                    comparison.unproven_samples += u64::from((required & !reported).count_ones());
                }
            } else if is_gap(required, reachable.samples(index), truly & reported) {
                comparison.gaps.push((cell, reason_of(claim)));
            }
        }
        comparison
    }

    /// What the tool could reach from where the robots stood first, by moves and passages; from anywhere, when nobody
    /// knows that.
    fn reachable(&self) -> SweptRaster {
        let floor = &self.run.floor;
        let starts = self.starts.values().filter_map(|&start| floor.nearest_drivable(&self.run.map, start));
        let starts: Vec<Cell> = starts.collect();
        let stands = if starts.is_empty() {
            (0..floor.lattice().len()).map(|index| floor.is_drivable(index)).collect()
        } else {
            Passages::new(floor).reached(floor, starts, |_| true)
        };
        let mut reached = SweptRaster::new(*floor.lattice());
        for index in (0..stands.len()).filter(|&index| stands[index]) {
            let center = floor.lattice().center(floor.lattice().cell(index));
            reached.sweep(Segment::new(center, center), floor.tool_width_m() / 2.0, |_| {});
        }
        reached
    }

    fn judge_cells(&mut self, comparison: &Comparison) {
        if !comparison.falsely_claimed.is_empty() {
            let area_m2 = self.area_m2(comparison.falsely_claimed_samples);
            let text = format!(
                "{area_m2:.3} m² in {} cells are claimed and were never swept: {}",
                comparison.falsely_claimed.len(),
                some_of(&comparison.falsely_claimed)
            );
            self.violate_at_end("coverage", text);
        }
        if !comparison.unproven.is_empty() && self.record_dropped == 0 {
            let area_m2 = self.area_m2(comparison.unproven_samples);
            let text = format!(
                "{area_m2:.3} m² in {} cells are claimed without a report of their sweep: {}",
                comparison.unproven.len(),
                some_of(&comparison.unproven)
            );
            self.violate_at_end("evidence", text);
        }
    }

    fn judge_result(&mut self, comparison: &Comparison) {
        let Some(result) = self.result.clone() else { return };
        if result.mission_state() == v1::MissionState::Completed && !comparison.gaps.is_empty() {
            let cells: Vec<Cell> = comparison.gaps.iter().map(|&(cell, _)| cell).collect();
            let text = format!(
                "the mission is called COMPLETED with {} open cells: {}",
                cells.len(),
                some_of(&cells)
            );
            self.violate_at_end("result", text);
        }
        let progress = result.progress.unwrap_or_default();
        let swept_m2 = self.area_m2(comparison.truly_swept_samples);
        if progress.covered_m2 > swept_m2 * (1.0 + AREA_SHARE_SLACK) + self.area_m2(1) {
            let text = format!("{:.2} m² claimed as covered, {swept_m2:.2} m² swept", progress.covered_m2);
            self.violate_at_end("result", text);
        }
        self.judge_counts(&progress);
    }

    fn judge_counts(&mut self, progress: &v1::CoverageProgress) {
        use v1::CellStatus::{
            CellAssigned, CellCovered, CellExcluded, CellLost, CellUnassigned, CellUnreachable,
        };
        if self.ledger.lattice().is_none() {
            return;
        }
        let told = [
            (CellUnassigned, progress.cells_unassigned),
            (CellAssigned, progress.cells_assigned),
            (CellCovered, progress.cells_covered),
            (CellUnreachable, progress.cells_unreachable),
            (CellExcluded, progress.cells_excluded),
            (CellLost, progress.cells_lost),
        ];
        for (status, told) in told {
            let found = self.ledger.count(status);
            if found != told as usize {
                let status = status.as_str_name();
                self.violate_at_end(
                    "ledger",
                    format!("the result tells {told} cells {status}, the ledger {found}"),
                );
            }
        }
    }

    /// Without truth there is nothing to judge by.
    fn judge_evidence(&mut self) {
        let claimed = self.ledger.count(v1::CellStatus::CellCovered);
        if self.before.samples == 0 && claimed > 0 {
            self.violate_at_end("evidence", "the log holds no /sim/truth to judge by".to_owned());
        }
    }

    fn violate_at_end(&mut self, rule: &'static str, text: String) {
        self.violations.push(Violation { rule, at_s: None, text });
    }

    fn area_m2(&self, samples: u64) -> f64 {
        SweptRaster::area_m2(self.run.floor.lattice(), samples)
    }

    fn coverage_figures(&self, comparison: &Comparison) -> CoverageFigures {
        let covered = self.ledger.count(v1::CellStatus::CellCovered);
        let share = |samples: u64| 100.0 * samples as f64 / comparison.coverable_samples.max(1) as f64;
        CoverageFigures {
            coverable_m2: self.area_m2(comparison.coverable_samples),
            rim_m2: self.run.rim_m2,
            truly_swept_m2: self.area_m2(comparison.truly_swept_samples),
            truly_swept_percent: share(comparison.truly_swept_samples),
            reported_swept_m2: self.area_m2(comparison.reported_samples),
            claimed_cells: covered as u64,
            claimed_m2: self.result.as_ref().and_then(|result| Some(result.progress?.covered_m2)),
            falsely_claimed_cells: comparison.falsely_claimed.len() as u64,
            falsely_claimed_m2: self.area_m2(comparison.falsely_claimed_samples),
            unproven_cells: comparison.unproven.len() as u64,
            unproven_m2: self.area_m2(comparison.unproven_samples),
        }
    }

    fn battery_figures(&self) -> BatteryFigures {
        BatteryFigures {
            lowest_percent: self
                .batteries
                .lowest_percent()
                .map(|(robot, percent)| (robot.to_owned(), percent))
                .collect(),
            report_error_percent: self.batteries.report_error_percent,
        }
    }
}

/// Whether a cell that is not claimed should have been: not so where some of it is out of reach, and all the rest was swept.
fn is_gap(required: u64, reachable: u64, swept: u64) -> bool {
    let is_cut_off = required & !reachable != 0;
    let within = required & reachable;
    within != 0 && !(is_cut_off && within & !swept == 0)
}

fn falls_short(swept: u64, required: u64) -> bool {
    f64::from(swept.count_ones()) < SHARE_MIN * f64::from(required.count_ones())
}

fn reason_of(claim: crate::Claim) -> String {
    let status = claim.status.as_str_name().trim_start_matches("CELL_");
    match claim.reason {
        v1::UnreachableReason::Unspecified => status.to_owned(),
        reason => format!("{status}, {}", reason.as_str_name()),
    }
}

fn some_of(cells: &[Cell]) -> String {
    let mut text = cells.iter().take(5).map(ToString::to_string).collect::<Vec<_>>().join(" ");
    if cells.len() > 5 {
        text += " …";
    }
    text
}

fn gap_figures(gaps: &[(Cell, String)], cell_m: f64) -> Vec<GapFigures> {
    let mut counts = BTreeMap::new();
    for (_, reason) in gaps {
        *counts.entry(reason.clone()).or_insert(0_u64) += 1;
    }
    let figures = |(reason, cells)| GapFigures { reason, cells, at_most_m2: cells as f64 * cell_m * cell_m };
    counts.into_iter().map(figures).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unclaimed_cell_is_no_gap_when_only_what_is_out_of_reach_is_missing() {
        let (required, reachable) = (0b1111, 0b0111);
        assert!(!is_gap(required, reachable, 0b0111));
        assert!(is_gap(required, reachable, 0b0011), "some of what is within reach was not swept");
        assert!(
            is_gap(required, required, required),
            "all was within reach and swept: why is it not claimed?"
        );
        assert!(!is_gap(required, 0, 0), "nobody gets there");
    }
}
