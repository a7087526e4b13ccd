//! The last word of a mission: how it ended, what was covered, and each gap with its place and reason.

use crate::Coordinator;
use protocol::{
    Timestamp,
    v1::{self, UnreachableReason},
};
use std::collections::BTreeMap;

impl Coordinator {
    /// The last word of the mission.
    pub(crate) fn result(&self, now: Timestamp, cause: &str) -> v1::MissionResult {
        v1::MissionResult {
            timestamp_ns: now.as_nanos(),
            mission_id: self.config.mission.id.clone(),
            mission_state: self.state.into(),
            progress: Some(self.ledger.progress()),
            gaps: self.parts(self.missed_cells()),
            out_of_reach: self.parts_out_of_reach(),
            duration_s: self.mission_began.map_or(0.0, |began| now.secs_since(began)),
            replans: self.replanning.plans.saturating_sub(1),
            robots_lost: self.robots_lost,
            cause: cause.to_owned(),
            planned_makespan_s: self.replanning.first_makespan_s,
        }
    }

    /// Given-up cells gathered by reason and place: neighbours belong to one part.
    pub(crate) fn parts(&self, cells: Vec<(usize, UnreachableReason)>) -> Vec<v1::Gap> {
        let lattice = self.floor.lattice();
        let mut left: BTreeMap<usize, UnreachableReason> = cells.into_iter().collect();
        let mut parts = Vec::new();
        while let Some((&first, &reason)) = left.iter().next() {
            left.remove(&first);
            let (mut stack, mut cells) = (vec![first], Vec::new());
            while let Some(index) = stack.pop() {
                cells.push(index);
                for direction in terrain::Direction::ALL {
                    let near = lattice.index(lattice.cell(index).step(direction));
                    if let Some(near) = near.filter(|near| left.get(near) == Some(&reason)) {
                        left.remove(&near);
                        stack.push(near);
                    }
                }
            }
            parts.push(self.part(&cells, reason));
        }
        parts
    }

    fn part(&self, cells: &[usize], reason: UnreachableReason) -> v1::Gap {
        let lattice = self.floor.lattice();
        let sum = cells
            .iter()
            .fold(terrain::Vector::zeros(), |sum, &cell| sum + lattice.center(lattice.cell(cell)).coords);
        let centre = sum / cells.len() as f64;
        let samples: u64 = cells.iter().map(|&cell| u64::from(self.ledger.unswept(cell).count_ones())).sum();
        let area_m2 = terrain::SweptRaster::area_m2(lattice, samples);
        v1::Gap {
            reason: reason.into(),
            cells: cells.len() as u32,
            area_m2,
            centre: Some(v1::Point { x_m: centre.x, y_m: centre.y }),
            text: format!(
                "{} cells ({area_m2:.2} m²) around ({:.1}, {:.1}) m: {}",
                cells.len(),
                centre.x,
                centre.y,
                reason.as_str_name()
            ),
        }
    }
}
