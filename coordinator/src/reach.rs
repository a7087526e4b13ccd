//! Ground that no robot gets to: found before the start and named, not found out by robots in vain.
//!
//! ```text
//!   #########      The body fits into the pocket, and not through the way there. No robot gets in, from wherever robots
//!   #  .  ###      have joined, over moves or passages: what only a tool in there would sweep is out of reach. When a
//!   ##   ####      robot joins in there, it no longer is.
//!   . . . . .
//! ```
//!
//! Its cells are UNREACHABLE from the start on, `TOO_NARROW`, and named as parts in an event before the first plan and
//! in the result. They are no gaps of the mission as long as they are crumbs, [`CRUMBS_MAX_SHARE`] of the floor in all:
//! there is nothing that the fleet left undone. When they are more, say a room behind a door that is too narrow, somebody
//! takes for covered what is not: then they are gaps, and the mission ends `COMPLETED_WITH_GAPS`.

use crate::{Coordinator, WALL_MARGIN_M, ledger::RobotIndex};
use protocol::{
    Timestamp,
    v1::{EventLevel, Gap, UnreachableReason},
};
use terrain::Cell;

/// Ground out of reach that is no more than this share of what can be covered is no gap.
const CRUMBS_MAX_SHARE: f64 = 0.01;
/// So many parts are named in an event, the largest first.
const PARTS_NAMED: usize = 5;

impl Coordinator {
    /// Leaves out what no robot gets to, and says so.
    pub(crate) fn name_what_is_out_of_reach(&mut self, now: Timestamp) {
        for robot in 0..self.robots.len() {
            self.joined_in.extend(self.cells_joined_in(robot));
        }
        if self.joined_in.is_empty() {
            return;
        }
        let reached = self.passages.reached(&self.floor, self.joined_in.iter().copied(), |_| true);
        let from_there = self.floor.required_from(&reached);
        let beyond = (0..from_there.len()).map(|index| self.floor.required(index) & !from_there[index]);
        self.ledger.set_out_of_reach(beyond.collect());
        let parts = self.parts_out_of_reach();
        if !parts.is_empty() {
            let text = self.describe_out_of_reach(parts);
            self.announcer.event(now, EventLevel::EventWarning, "", "OUT OF REACH", &text);
        }
    }

    /// A robot has joined during the mission, maybe where nobody got to before.
    pub(crate) fn look_who_gets_where(&mut self, now: Timestamp, robot: RobotIndex) {
        let lattice = self.floor.lattice();
        let reached = self.passages.reached(&self.floor, self.joined_in.iter().copied(), |_| true);
        let is_new = |cell: &Cell| lattice.index(*cell).is_some_and(|index| !reached[index]);
        if self.cells_joined_in(robot).iter().any(is_new) {
            self.name_what_is_out_of_reach(now);
        }
    }

    /// The cells beside the place where a robot joins.
    fn cells_joined_in(&self, robot: RobotIndex) -> Vec<Cell> {
        let Some(place) = self.robots[robot].position() else { return Vec::new() };
        let nearest = self.floor.nearest_drivable(&self.config.mission.map, place);
        self.cell_beside(place, |_| true).into_iter().chain(nearest).collect()
    }

    /// Whether all that is out of reach is too little to be missed.
    fn only_crumbs_are_out_of_reach(&self) -> bool {
        let progress = self.ledger.progress();
        progress.out_of_reach_m2 <= CRUMBS_MAX_SHARE * progress.coverable_m2
    }

    /// Cells that were given up and are missed, with the reason.
    pub(crate) fn missed_cells(&self) -> Vec<(usize, UnreachableReason)> {
        let no_gaps = self.only_crumbs_are_out_of_reach();
        let given_up = self.ledger.given_up().into_iter();
        given_up.filter(|&(index, _)| !(no_gaps && self.ledger.is_out_of_reach(index))).collect()
    }

    /// What no robot gets to, in one piece each; the largest first.
    pub(crate) fn parts_out_of_reach(&self) -> Vec<Gap> {
        let given_up = self.ledger.given_up().into_iter();
        let cells = given_up.filter(|&(index, _)| self.ledger.is_out_of_reach(index));
        let mut parts = self.parts(cells.collect());
        parts.sort_by(|a, b| b.area_m2.total_cmp(&a.area_m2));
        parts
    }

    fn describe_out_of_reach(&self, parts: Vec<Gap>) -> String {
        let area_m2 = self.ledger.progress().out_of_reach_m2;
        let count = parts.len();
        let mut named: Vec<String> = parts.into_iter().take(PARTS_NAMED).map(|part| part.text).collect();
        if count > PARTS_NAMED {
            named.push(format!("{} more", count - PARTS_NAMED));
        }
        let room_m = 2.0 * (self.config.mission.body_radius_m + WALL_MARGIN_M);
        format!(
            "{area_m2:.2} m² in {count} parts that no robot gets to through ways {room_m:.2} m wide: {}",
            named.join("; ")
        )
    }
}
