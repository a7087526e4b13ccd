//! When to plan anew, for which cause, with which instance; and what becomes of the plan.
//!
//! Causes are gathered for a moment, then one instance is made of all that is still to be covered and all
//! robots that can cover, each from the end of its base. While the planner works no ground is released, so the
//! plan fits when it comes. An answer to an older request is dropped.
//!
//! A planner whose routes leave the lattice may leave a little unswept. What it leaves comes back as open cells, is visited
//! along the lattice, and so gets done. Once its lines are under way they are repaired, without planning afresh; when that
//! does not hold and it cannot plan what is left, the planner [`FALLBACK`] does.

use crate::{
    Coordinator, Output, PlanRequest,
    ledger::{RobotIndex, Status},
    robot::{Errand, Phase},
    route::{Ending, Waypoint},
};
use planner::{Mode, PlanError, PlanOptions, Start, VerifiedPlan, planners::keeps_to_lattice};
use protocol::{
    Timestamp,
    v1::{self, EventLevel, MissionState, ReplanCause},
};
use std::{collections::BTreeMap, sync::Arc, time::Duration};
use terrain::{Cell, MotionModel, Point, Segment};

/// Causes are gathered this long before the planner is asked.
const GATHER: Duration = Duration::from_millis(50);
/// At least this long between two plans.
const PLANS_APART: Duration = Duration::from_millis(400);
/// At least this long between two plans that only untie robots.
const DEADLOCK_PLANS_APART: Duration = Duration::from_secs(5);
/// Plans what the mission's planner cannot, and visits the specks that it leaves.
const FALLBACK: &str = "tmstc-star";
/// When less than this share of the cells to visit is missing, only specks are left.
const SPECKS_SHARE: f64 = 0.4;
/// After so many refusals in a row the mission fails.
const REFUSALS_MAX: u32 = 5;

/// By this share a plan that only shares out anew what is under way has to be better.
const SHARED_OUT_BETTER_BY: f64 = 0.02;

/// Why the fleet is planned anew.
#[derive(Debug, Clone)]
pub(crate) struct Cause {
    pub(crate) kind: ReplanCause,
    pub(crate) robot: Option<RobotIndex>,
    pub(crate) text: String,
}

impl Cause {
    pub(crate) fn of(kind: ReplanCause, robot: RobotIndex, text: &str) -> Self {
        Self { kind, robot: Some(robot), text: text.to_owned() }
    }

    pub(crate) fn fleet(kind: ReplanCause, text: &str) -> Self {
        Self { kind, robot: None, text: text.to_owned() }
    }
}

/// What one planner is asked to do.
#[derive(Debug)]
struct Task {
    planner: String,
    visit: Vec<bool>,
    blocked: Vec<bool>,
    starts: Vec<Start>,
}

/// What is driven already, per robot, and what has lost its robot: as cells, or as lines.
#[derive(Debug, Default)]
struct UnderWay {
    incumbent: Vec<Vec<Cell>>,
    orphans: Vec<Vec<Cell>>,
    incumbent_lines: Vec<Vec<Point>>,
    orphan_lines: Vec<Vec<Point>>,
}

/// A request the planner has not answered yet.
#[derive(Debug)]
struct InFlight {
    revision: u64,
    robots: Vec<RobotIndex>,
    orders: Vec<u64>,
    /// Who charges, and begins its route afterwards.
    charges: Vec<bool>,
    visit: Vec<bool>,
    causes: Vec<Cause>,
    owners: BTreeMap<usize, Option<RobotIndex>>,
    remaining_s: Vec<f64>,
    planner: String,
}

/// What is wanted of the planner, and what it was asked.
#[derive(Debug, Default)]
pub(crate) struct Replanning {
    causes: Vec<Cause>,
    due: Option<Timestamp>,
    in_flight: Option<InFlight>,
    revision: u64,
    asked_at: Timestamp,
    deadlock_at: Timestamp,
    refusals: u32,
    /// The mission's planner refused just now: the next plan is the fallback's.
    falls_back: bool,
    decisions: u64,
    /// Robots that stand in each other's way: the next plan takes the places where they stand for closed to all
    /// others.
    pub(crate) untie: Vec<RobotIndex>,
    /// Plans that came and were driven.
    pub(crate) plans: u32,
    pub(crate) first_makespan_s: f64,
}

impl Replanning {
    pub(crate) fn revision(&self) -> u64 {
        self.revision
    }

    /// When the planner is to be asked.
    pub(crate) fn due(&self) -> Option<Timestamp> {
        if self.in_flight.is_some() { None } else { self.due }
    }

    /// Whether a plan is wanted or on its way.
    pub(crate) fn is_busy(&self) -> bool {
        self.due.is_some() || self.in_flight.is_some()
    }

    /// Whether a robot's base must stay as the planner knows it.
    pub(crate) fn is_frozen(&self, robot: RobotIndex) -> bool {
        self.in_flight.as_ref().is_some_and(|flight| flight.robots.contains(&robot))
    }

    pub(crate) fn may_replan_for_deadlock(&mut self, now: Timestamp) -> bool {
        let may = now.since(self.deadlock_at) >= DEADLOCK_PLANS_APART;
        if may {
            self.deadlock_at = now;
        }
        may
    }
}

impl Coordinator {
    /// Notes that the fleet must be planned anew.
    pub(crate) fn need_plan(&mut self, now: Timestamp, cause: Cause) {
        if self.ended() || self.mission_began.is_none() && cause.kind != ReplanCause::CauseStart {
            return;
        }
        self.replanning.causes.push(cause);
        let earliest = (now + GATHER).max(self.replanning.asked_at + PLANS_APART);
        self.replanning.due.get_or_insert(earliest);
    }

    /// Asks the planner when it is time.
    pub(crate) fn send_plan_request(&mut self, now: Timestamp, out: &mut Vec<Output>) {
        let may_plan = !self.ended() && self.state != MissionState::Paused;
        if !may_plan || self.replanning.due().is_none_or(|due| now < due) {
            return;
        }
        self.replanning.due = None;
        let causes = std::mem::take(&mut self.replanning.causes);
        let untie = std::mem::take(&mut self.replanning.untie);
        let team = self.team(&self.blocked_for_plans(&untie, 0.5 * self.floor.lattice().cell_m));
        self.release_what_is_not_driven(&team);
        let Some((request, flight)) = self.instance(causes, &untie, team) else {
            self.announce_without_plan(now);
            return;
        };
        self.replanning.asked_at = now;
        self.replanning.revision = request.revision;
        self.replanning.in_flight = Some(flight);
        self.state = MissionState::Replanning;
        Self::ask_planner(out, request);
    }

    /// Cells and routes that belong to robots which do not cover, now or once they are charged, belong to nobody.
    fn release_what_is_not_driven(&mut self, team: &[RobotIndex]) {
        for index in 0..self.robots.len() {
            if !self.robots[index].can_cover() && !team.contains(&index) {
                self.ledger.unassign(index);
                self.give_rest_away(index);
            }
        }
    }

    /// The mission as it stands, as something to plan; `None` when nobody can do anything now.
    fn instance(
        &mut self,
        causes: Vec<Cause>,
        untie: &[RobotIndex],
        robots: Vec<RobotIndex>,
    ) -> Option<(PlanRequest, InFlight)> {
        let motion = self.slowest_motion(&robots)?;
        let task = self
            .task_off_lattice(untie, &robots, &motion)
            .or_else(|| self.task_on_lattice(untie, &robots, &motion))?;
        let owners = self.owners(&task.visit);
        let off_lattice = !keeps_to_lattice(&task.planner);
        let UnderWay { incumbent, orphans, incumbent_lines, orphan_lines } =
            self.under_way(&robots, &task.starts, off_lattice, untie.is_empty());
        let swept = if off_lattice { self.swept_or_granted(&robots) } else { Vec::new() };
        let revision = self.replanning.revision + 1;
        let flight = InFlight {
            revision,
            orders: robots.iter().map(|&robot| self.robots[robot].route.order_id()).collect(),
            charges: robots.iter().map(|&robot| !self.robots[robot].can_cover()).collect(),
            remaining_s: robots.iter().map(|&robot| self.robots[robot].remaining_s).collect(),
            visit: task.visit.clone(),
            owners,
            robots,
            causes,
            planner: task.planner.clone(),
        };
        let stations: Vec<Cell> = self.station_cells();
        let options = PlanOptions {
            planner: task.planner,
            seed: self.config.seed,
            warm: incumbent_lines.iter().chain(&orphan_lines).any(|line| line.len() > 1),
            ..PlanOptions::default()
        };
        let Task { visit, blocked, starts, .. } = task;
        let floor = Arc::clone(&self.floor);
        let mode = Mode::Cover;
        Some((
            PlanRequest {
                revision,
                floor,
                visit,
                blocked,
                starts,
                motion,
                mode,
                stations,
                incumbent,
                orphans,
                incumbent_lines,
                orphan_lines,
                swept,
                options,
            },
            flight,
        ))
    }

    /// What is to be visited along the lattice; `None` when there is nothing.
    fn task_on_lattice(
        &self,
        untie: &[RobotIndex],
        robots: &[RobotIndex],
        motion: &MotionModel,
    ) -> Option<Task> {
        let blocked = self.blocked_for_plans(untie, 0.0);
        let start =
            |&robot: &RobotIndex| self.back_at(robot, &blocked).unwrap_or_else(|| self.start(robot, motion));
        let starts: Vec<Start> = robots.iter().map(start).collect();
        let visit = self.cells_to_visit(&blocked, robots, &starts);
        let mine = &self.config.mission.planner;
        let planner = if keeps_to_lattice(mine) { mine.clone() } else { FALLBACK.to_owned() };
        visit.contains(&true).then_some(Task { planner, visit, blocked, starts })
    }

    /// What is to be swept by a planner that leaves the lattice; `None` when the mission's does not, when it was
    /// refused just now, or when only specks are left.
    fn task_off_lattice(
        &self,
        untie: &[RobotIndex],
        robots: &[RobotIndex],
        motion: &MotionModel,
    ) -> Option<Task> {
        let planner = self.config.mission.planner.clone();
        if keeps_to_lattice(&planner) || self.replanning.falls_back {
            return None;
        }
        let blocked = self.blocked_for_plans(untie, 0.5 * self.floor.lattice().cell_m);
        let start = |&robot: &RobotIndex| {
            self.back_at(robot, &blocked).unwrap_or_else(|| self.start_off_lattice(robot, motion))
        };
        let starts: Vec<Start> = robots.iter().map(start).collect();
        let visit = self.cells_to_visit(&blocked, robots, &starts);
        (!self.only_specks_are_left(&visit)).then_some(Task { planner, visit, blocked, starts })
    }

    fn only_specks_are_left(&self, visit: &[bool]) -> bool {
        let (mut wanted, mut missing) = (0, 0);
        for index in (0..visit.len()).filter(|&index| visit[index]) {
            wanted += self.floor.required(index).count_ones();
            missing += self.ledger.missing(index).count_ones();
        }
        f64::from(missing) <= SPECKS_SHARE * f64::from(wanted)
    }

    /// Where a robot's next route begins that may leave the lattice: at the end of its base itself, where there is room
    /// to get to the cell's centre, or in the cell.
    pub(crate) fn start_off_lattice(&self, index: RobotIndex, motion: &MotionModel) -> Start {
        let start = self.start(index, motion);
        let end = self.robots[index].route.base_end().map(|node| node.point);
        let has_room = |end: &Point| {
            let to_centre = Segment::new(*end, self.floor.lattice().center(start.cell));
            self.floor.lattice().cell_at(*end) == Some(start.cell) && self.floor.segment_is_free(to_centre)
        };
        Start { point: end.filter(has_room), ..start }
    }

    /// What is driven already, and the routes without a robot: as cells for a planner that keeps to the lattice where all
    /// of them do, as lines for one that leaves it. Nothing when nothing is, or when it is not `wanted`.
    fn under_way(
        &mut self,
        robots: &[RobotIndex],
        starts: &[Start],
        off_lattice: bool,
        wanted: bool,
    ) -> UnderWay {
        let orphans = std::mem::take(&mut self.orphans);
        let orphan_lines = std::mem::take(&mut self.orphan_lines);
        if !wanted {
            return UnderWay::default();
        }
        if off_lattice {
            let line = |(&robot, start): (&RobotIndex, &Start)| {
                let begin = start.point.unwrap_or_else(|| self.floor.lattice().center(start.cell));
                let ahead = self.places_ahead(robot).into_iter().skip(1).map(|place| place.point);
                std::iter::once(begin).chain(ahead).collect()
            };
            let incumbent_lines = robots.iter().zip(starts).map(line).collect();
            return UnderWay { incumbent_lines, orphan_lines, ..UnderWay::default() };
        }
        let ahead = |&robot: &RobotIndex| -> Vec<Option<Cell>> {
            self.places_ahead(robot).into_iter().skip(1).map(|place| place.cell).collect()
        };
        let ahead: Vec<Vec<Option<Cell>>> = robots.iter().map(ahead).collect();
        let leaves_lattice = ahead.iter().flatten().any(Option::is_none);
        let incumbent: Vec<Vec<Cell>> =
            ahead.into_iter().map(|cells| cells.into_iter().flatten().collect()).collect();
        if leaves_lattice || orphans.is_empty() && incumbent.iter().all(Vec::is_empty) {
            return UnderWay::default();
        }
        UnderWay { incumbent, orphans, ..UnderWay::default() }
    }

    /// A robot's line from the end of its base on.
    pub(crate) fn line_ahead(&self, robot: RobotIndex) -> Vec<Point> {
        let route = &self.robots[robot].route;
        route.base_end().into_iter().chain(route.horizon()).map(|node| node.point).collect()
    }

    /// Row-major: samples that are swept, or will be on the ground that is granted.
    pub(crate) fn swept_or_granted(&self, robots: &[RobotIndex]) -> Vec<u64> {
        let mut swept = self.ledger.swept();
        for (index, samples) in self.swept_by(robots.iter().flat_map(|&robot| self.base_edges(robot))) {
            swept[index] |= samples;
        }
        swept
    }

    /// A robot gives its route away: the planner may cut it up and hand it to others.
    pub(crate) fn orphan_route(&mut self, robot: RobotIndex) {
        let ahead: Vec<Waypoint> = self.robots[robot].route.ahead().copied().collect();
        self.orphan(&ahead);
    }

    /// These places have lost their robot.
    pub(crate) fn orphan(&mut self, places: &[Waypoint]) {
        let cells: Vec<Cell> = places.iter().filter_map(|place| place.cell).collect();
        let line: Vec<Point> = places.iter().map(|place| place.point).collect();
        if !cells.is_empty() {
            self.orphans.push(cells);
        }
        if line.len() > 1 {
            self.orphan_lines.push(line);
        }
    }

    /// Zones, and ground held by robots that will not move by themselves; cells count whose centre is by `wider_m`
    /// farther away, too.
    pub(crate) fn blocked_for_plans(&self, untie: &[RobotIndex], wider_m: f64) -> Vec<bool> {
        let mut blocked: Vec<bool> =
            (0..self.floor.lattice().len()).map(|index| self.zones.holds(index)).collect();
        for (index, robot) in self.robots.iter().enumerate() {
            let immobile = untie.contains(&index)
                || matches!(robot.phase, Phase::Suspect | Phase::Lost)
                || robot.phase == Phase::Ready
                    && (robot.stuck || matches!(robot.errand, Errand::Charging(_) | Errand::Queue(_)));
            if immobile {
                for index in self.cells_within(&robot.held, self.separation_m() + wider_m) {
                    blocked[index] = true;
                }
            }
        }
        if wider_m > 0.0 {
            let ground: Vec<_> = self.zones.iter().flat_map(|zone| zone.ground.iter().copied()).collect();
            for index in self.cells_within(&ground, self.separation_m() + wider_m) {
                blocked[index] = true;
            }
        }
        blocked
    }

    pub(crate) fn slowest_motion(&self, robots: &[RobotIndex]) -> Option<MotionModel> {
        robots.iter().filter_map(|&robot| self.robots[robot].motion()).reduce(|a, b| MotionModel {
            speed_m_per_s: a.speed_m_per_s.min(b.speed_m_per_s),
            acceleration_m_per_s2: a.acceleration_m_per_s2.min(b.acceleration_m_per_s2),
            angular_speed_rad_per_s: a.angular_speed_rad_per_s.min(b.angular_speed_rad_per_s),
            angular_acceleration_rad_per_s2: a
                .angular_acceleration_rad_per_s2
                .min(b.angular_acceleration_rad_per_s2),
            brakes: true,
        })
    }

    fn start(&self, index: RobotIndex, motion: &MotionModel) -> Start {
        let base: Vec<Point> = self.robots[index].route.base().map(|node| node.point).collect();
        let heading = base.windows(2).last().map(|pair| {
            let step = pair[1] - pair[0];
            step.y.atan2(step.x)
        });
        let standing = self.robots[index].state.as_ref().and_then(|state| state.pose.as_ref());
        Start {
            cell: self.start_cell(index).expect("only robots with a start cell take part"),
            point: None,
            heading_rad: heading.or_else(|| standing.map(|pose| pose.theta_rad)),
            available_in_s: motion.path_s(&base, None),
            charge_s: None,
        }
    }

    /// Row-major: cells that robots should pass so that all that is open gets swept, as far as they can get
    /// there and no base sweeps it already.
    fn cells_to_visit(&self, blocked: &[bool], robots: &[RobotIndex], starts: &[Start]) -> Vec<bool> {
        let reachable = self.reachable(blocked, starts);
        let granted = self.swept_by(robots.iter().flat_map(|&robot| self.base_edges(robot)));
        let mut visit = vec![false; blocked.len()];
        for index in self.ledger.open_cells() {
            let swept = granted.get(&index).copied().unwrap_or(0);
            if self.ledger.missing(index) & !swept == 0 {
                continue;
            }
            for stand in self.stands_for(index, &reachable) {
                visit[stand] |= self.is_in_range(stand);
            }
        }
        visit
    }

    /// Row-major: cells among `stands` that robots should pass so that all that is open gets swept, as far as it can be
    /// from there.
    pub(crate) fn stands_for_all(&self, stands: &[bool]) -> Vec<bool> {
        let mut visit = vec![false; stands.len()];
        for stand in self.ledger.open_cells().flat_map(|index| self.stands_for(index, stands)) {
            visit[stand] |= self.is_in_range(stand);
        }
        visit
    }

    /// The reachable cells to stand in so that what is missing of a cell gets swept, as far as it can be from there.
    fn stands_for(&self, index: usize, reachable: &[bool]) -> Vec<usize> {
        if self.floor.is_drivable(index) {
            return if reachable[index] { vec![index] } else { Vec::new() };
        }
        let mut missing = self.ledger.missing(index);
        let mut stands = Vec::new();
        while let Some((stand, swept)) = self.best_stand(index, missing, reachable) {
            missing &= !swept;
            stands.push(stand);
        }
        stands
    }

    /// The reachable cell from whose centre most of some samples of a cell gets swept, and which.
    fn best_stand(&self, index: usize, missing: u64, reachable: &[bool]) -> Option<(usize, u64)> {
        let lattice = self.floor.lattice();
        let cell = lattice.cell(index);
        let radius_m = self.floor.tool_width_m() / 2.0;
        let reach = (radius_m / lattice.cell_m).ceil() as i32;
        let mut best: Option<(usize, u64)> = None;
        for y in cell.y - reach..=cell.y + reach {
            for x in cell.x - reach..=cell.x + reach {
                let Some(at) = lattice.index(Cell::new(x, y)).filter(|&at| reachable[at]) else { continue };
                let center = lattice.center(lattice.cell(at));
                let swept = missing & terrain::samples_swept_from(lattice, cell, center, radius_m);
                if swept.count_ones() > best.map_or(0, |(_, most)| most.count_ones()) {
                    best = Some((at, swept));
                }
            }
        }
        best
    }

    fn reachable(&self, blocked: &[bool], starts: &[Start]) -> Vec<bool> {
        let lattice = self.floor.lattice();
        let mut reached = vec![false; lattice.len()];
        let mut stack: Vec<Cell> = Vec::new();
        for start in starts {
            let index = lattice.index(start.cell).expect("a start is on the lattice");
            if !reached[index] {
                reached[index] = true;
                stack.push(start.cell);
            }
        }
        while let Some(cell) = stack.pop() {
            for next in self.floor.neighbours(cell) {
                let index = lattice.index(next).expect("a neighbour is on the lattice");
                if !reached[index] && !blocked[index] {
                    reached[index] = true;
                    stack.push(next);
                }
            }
        }
        for start in starts {
            let index = lattice.index(start.cell).expect("a start is on the lattice");
            reached[index] = !blocked[index];
        }
        reached
    }

    fn owners(&self, visit: &[bool]) -> BTreeMap<usize, Option<RobotIndex>> {
        (0..visit.len())
            .filter(|&index| visit[index])
            .map(|index| match self.ledger.status(index) {
                Status::Assigned(robot) => (index, Some(robot)),
                _ => (index, None),
            })
            .collect()
    }

    /// The planner's answer.
    pub(crate) fn on_planned(
        &mut self,
        now: Timestamp,
        revision: u64,
        result: Result<VerifiedPlan, PlanError>,
        planning_s: f64,
        out: &mut Vec<Output>,
    ) {
        if self.replanning.in_flight.as_ref().is_none_or(|flight| flight.revision != revision) {
            return;
        }
        let flight = self.replanning.in_flight.take().expect("it was just looked at");
        if self.ended() {
            return;
        }
        self.state = MissionState::Active;
        match result {
            Ok(plan) if !self.is_worth_a_stop(&flight, &plan) => self.idle_checks.look_at(now),
            Ok(plan) => self.apply(now, &flight, &plan, planning_s, out),
            Err(error) if flight.planner != FALLBACK && !keeps_to_lattice(&flight.planner) => {
                self.fall_back(now, flight, &error);
            }
            Err(error) => self.plan_refused(now, &error),
        }
    }

    /// Each change of routes costs the fleet a stop: a plan that was asked for only to share out what is under way anyhow
    /// has to be better by a margin.
    fn is_worth_a_stop(&mut self, flight: &InFlight, plan: &VerifiedPlan) -> bool {
        if flight.causes.iter().any(|cause| cause.kind != ReplanCause::CauseFinishedEarly) {
            return true;
        }
        self.estimate_remaining();
        let before_s = flight.robots.iter().map(|&robot| self.robots[robot].remaining_s).fold(0.0, f64::max);
        plan.figures().makespan_s < (1.0 - SHARED_OUT_BETTER_BY) * before_s
    }

    /// The mission's planner cannot plan this: another one does, at once.
    fn fall_back(&mut self, now: Timestamp, flight: InFlight, error: &PlanError) {
        let text = format!("{error}; `{FALLBACK}` plans this");
        self.announcer.event(now, EventLevel::EventInfo, "", "FALLBACK", &text);
        self.replanning.falls_back = true;
        self.replanning.causes.extend(flight.causes);
        self.replanning.due = Some(now);
    }

    fn plan_refused(&mut self, now: Timestamp, error: &PlanError) {
        self.replanning.refusals += 1;
        let text = format!("the planner refused: {error}");
        self.announcer.event(now, EventLevel::EventError, "", "NO PLAN", &text);
        if self.replanning.refusals >= REFUSALS_MAX {
            self.fail(now, &text);
        } else {
            self.need_plan(now + Duration::from_secs(1), Cause::fleet(ReplanCause::CauseResidual, "again"));
        }
    }

    fn apply(
        &mut self,
        now: Timestamp,
        flight: &InFlight,
        plan: &VerifiedPlan,
        planning_s: f64,
        out: &mut Vec<Output>,
    ) {
        self.replanning.refusals = 0;
        self.replanning.falls_back = false;
        self.replanning.plans += 1;
        let before_s = self.robots.iter().map(|robot| robot.remaining_s).fold(0.0, f64::max);
        for (number, &robot) in flight.robots.iter().enumerate() {
            if flight.charges[number] || self.still_fits(robot, flight.orders[number]) {
                self.ledger.unassign(robot);
            }
        }
        let (mut given, mut later) = (Vec::new(), Vec::new());
        for (number, &robot) in flight.robots.iter().enumerate() {
            let points = &plan.routes()[number].points;
            if flight.charges[number] && self.goes_on_later(robot, points) {
                later.push(robot);
            } else if !flight.charges[number] && self.still_fits(robot, flight.orders[number]) {
                self.give_route(robot, flight, points);
                given.push(robot);
            } else {
                self.need_plan(now, Cause::of(ReplanCause::CauseResidual, robot, "changed while planning"));
            }
        }
        self.assign_by_footprint(&[&given[..], &later].concat());
        self.choose_break_offs(flight.revision, &given, out);
        let after_s = plan.figures().makespan_s;
        if self.replanning.first_makespan_s == 0.0 {
            self.replanning.first_makespan_s = after_s;
        }
        self.announce_plan(now, flight, plan.planner(), [before_s, after_s, planning_s], out);
    }

    fn still_fits(&self, robot: RobotIndex, order_id: u64) -> bool {
        self.robots[robot].can_cover() && self.robots[robot].route.order_id() == order_id
    }

    fn give_route(&mut self, robot: RobotIndex, flight: &InFlight, points: &[Point]) {
        let Some(end) = self.robots[robot].route.base_end().map(|node| node.point) else { return };
        let on_lattice = points.iter().skip(1).all(|&point| self.cell_centred_at(point).is_some());
        let mut way: Vec<Point> = Vec::new();
        if on_lattice {
            let lattice = self.floor.lattice();
            way.extend(self.stir(robot, flight).into_iter().map(|cell| lattice.center(cell)));
        }
        let begins_there = points.first().is_some_and(|&first| (first - end).norm() < 1e-6);
        way.extend(points.iter().skip(usize::from(begins_there)));
        let bends = self.start_cell(robot).map_or_else(Vec::new, |cell| self.bends_to(end, cell));
        let on_lattice = on_lattice && bends.is_empty();
        way.splice(0..0, bends);
        let places = if on_lattice { self.places_at(&way) } else { self.places_along(end, &way) };
        let robot = &mut self.robots[robot];
        robot.errand = Errand::Cover;
        robot.break_off = None;
        robot.resumes.clear();
        robot.route.stitch(flight.revision, places, Ending::Stay);
        robot.wait = None;
        robot.hold = None;
        robot.order_sent = Timestamp::ZERO;
    }

    /// Keeps the route that a robot begins when it is charged; false when it will not be any more.
    fn goes_on_later(&mut self, robot: RobotIndex, points: &[Point]) -> bool {
        if !self.will_resume(robot) && !self.robots[robot].can_cover() {
            return false;
        }
        let on_lattice = points.iter().all(|&point| self.cell_centred_at(point).is_some());
        self.robots[robot].resumes = match points {
            [] => Vec::new(),
            _ if on_lattice => self.places_at(points),
            [first, rest @ ..] => {
                let begin = Waypoint { point: *first, cell: None, tool_active: false };
                std::iter::once(begin).chain(self.places_along(*first, rest)).collect()
            }
        };
        true
    }

    /// Points of the lattice as places of a route.
    fn places_at(&self, points: &[Point]) -> Vec<Waypoint> {
        let lattice = self.floor.lattice();
        points.iter().filter_map(|&point| lattice.cell_at(point)).map(|cell| self.place(cell)).collect()
    }

    /// A robot that stands in a cell to be covered leaves evidence only by moving: to a neighbour and back.
    fn stir(&self, robot: RobotIndex, flight: &InFlight) -> Vec<Cell> {
        let lattice = self.floor.lattice();
        let (Some(start), Some(end)) = (self.start_cell(robot), self.robots[robot].route.base_end()) else {
            return Vec::new();
        };
        let stands_there = (lattice.center(start) - end.point).norm() < 0.5 * lattice.cell_m;
        let wanted = lattice.index(start).is_some_and(|index| flight.visit[index]);
        if !(stands_there && wanted) {
            return Vec::new();
        }
        let aside = self.floor.neighbours(start).find(|&next| self.is_open_ground(next));
        aside.map_or_else(Vec::new, |next| match end.cell {
            Some(_) => vec![next, start],
            None => vec![start, next, start],
        })
    }

    /// Says what the plan changes and why, in one line a cause.
    fn announce_plan(
        &mut self,
        now: Timestamp,
        flight: &InFlight,
        planner: &str,
        [before_s, after_s, planning_s]: [f64; 3],
        out: &mut Vec<Output>,
    ) {
        self.estimate_remaining();
        let transfers = self.transfers(flight);
        for (number, cause) in flight.causes.iter().enumerate() {
            let id = cause.robot.map_or_else(String::new, |robot| self.robots[robot].id.clone());
            let moved = describe(&transfers, cause.robot.map(|robot| self.robots[robot].id.as_str()));
            let text = if moved.is_empty() {
                format!("{} → plan {}, {after_s:.0} s to go", cause.text, flight.revision)
            } else {
                format!("{} → {moved}", cause.text)
            };
            let level = level_of(cause.kind);
            let event_id = self.announcer.event(now, level, &id, word_of(cause.kind), &text);
            self.replanning.decisions += 1;
            out.push(Output::Publish(crate::Publication::Decision(v1::Decision {
                decision_id: self.replanning.decisions,
                timestamp_ns: now.as_nanos(),
                cause: cause.kind.into(),
                serial_number: id,
                text,
                plan_revision: flight.revision,
                makespan_before_s: before_s,
                makespan_after_s: after_s,
                planning_s,
                planner: planner.to_owned(),
                transfers: if number == 0 { transfers.clone() } else { Vec::new() },
                event_id,
            })));
        }
    }

    fn transfers(&self, flight: &InFlight) -> Vec<v1::CellTransfer> {
        let mut counts: BTreeMap<(Option<RobotIndex>, RobotIndex), u32> = BTreeMap::new();
        for (&index, &before) in &flight.owners {
            if let Status::Assigned(after) = self.ledger.status(index)
                && before != Some(after)
            {
                *counts.entry((before, after)).or_default() += 1;
            }
        }
        let name =
            |robot: Option<RobotIndex>| robot.map_or_else(String::new, |robot| self.robots[robot].id.clone());
        counts
            .into_iter()
            .map(|((from, to), cells)| v1::CellTransfer {
                from: name(from),
                to: name(Some(to)),
                cells,
                added_s: self.added_s(flight, to),
            })
            .collect()
    }

    fn added_s(&self, flight: &InFlight, robot: RobotIndex) -> f64 {
        let before_s = flight
            .robots
            .iter()
            .position(|&other| other == robot)
            .map_or(0.0, |number| flight.remaining_s[number]);
        self.robots[robot].remaining_s - before_s
    }

    /// Works out anew how long each robot still drives on its route.
    pub(crate) fn estimate_remaining(&mut self) {
        for index in 0..self.robots.len() {
            let robot = &self.robots[index];
            let points = |places: &mut dyn Iterator<Item = &Waypoint>| -> Vec<Point> {
                places.map(|place| place.point).collect()
            };
            let remaining_s = match (robot.phase, robot.motion(), self.back_in_s(index)) {
                (Phase::Ready, Some(motion), Some(back_in_s)) if !robot.resumes.is_empty() => {
                    back_in_s + motion.path_s(&points(&mut robot.resumes.iter()), None)
                }
                (Phase::Ready, Some(motion), _) => motion.path_s(&points(&mut robot.route.ahead()), None),
                _ => 0.0,
            };
            self.robots[index].remaining_s = remaining_s;
        }
    }

    fn announce_without_plan(&mut self, now: Timestamp) {
        if self.state == MissionState::Replanning {
            self.state = MissionState::Active;
        }
        self.idle_checks.look_at(now);
    }
}

/// `41 cells to r1 (+38 s), r5 (+12 s)`: what was taken from a robot, or from nobody.
fn describe(transfers: &[v1::CellTransfer], from: Option<&str>) -> String {
    let from = from.unwrap_or_default();
    let theirs: Vec<&v1::CellTransfer> = transfers
        .iter()
        .filter(|transfer| transfer.from == from || transfer.from.is_empty() && transfer.to != from)
        .collect();
    let cells: u32 = theirs.iter().map(|transfer| transfer.cells).sum();
    if cells == 0 {
        return String::new();
    }
    let mut added: BTreeMap<&str, f64> = BTreeMap::new();
    for transfer in &theirs {
        added.insert(&transfer.to, transfer.added_s);
    }
    let list: Vec<String> = added.iter().map(|(to, added_s)| format!("{to} ({added_s:+.0} s)")).collect();
    format!("{cells} cells to {}", list.join(", "))
}

const fn word_of(kind: ReplanCause) -> &'static str {
    match kind {
        ReplanCause::Unspecified => "PLAN",
        ReplanCause::CauseStart => "START",
        ReplanCause::CauseRobotLost => "LOST",
        ReplanCause::CauseRobotHung => "HUNG",
        ReplanCause::CauseRobotStuck => "STUCK",
        ReplanCause::CauseRobotSlow => "SLOW",
        ReplanCause::CauseBlockage => "BLOCKED",
        ReplanCause::CauseLowBattery => "LOW BATTERY",
        ReplanCause::CauseRobotJoined => "JOINED",
        ReplanCause::CauseOperator => "OPERATOR",
        ReplanCause::CauseResidual => "RESIDUAL",
        ReplanCause::CauseZoneCleared => "ZONE CLEARED",
        ReplanCause::CauseCharged => "CHARGED",
        ReplanCause::CauseDeadlock => "DEADLOCK",
        ReplanCause::CauseFinishedEarly => "REBALANCED",
    }
}

const fn level_of(kind: ReplanCause) -> EventLevel {
    match kind {
        ReplanCause::CauseRobotLost
        | ReplanCause::CauseRobotHung
        | ReplanCause::CauseRobotStuck
        | ReplanCause::CauseRobotSlow
        | ReplanCause::CauseBlockage
        | ReplanCause::CauseDeadlock => EventLevel::EventWarning,
        _ => EventLevel::EventInfo,
    }
}
