//! Space is granted, never assumed: which ground each robot may drive on, and who makes way for whom.
//!
//! A robot *holds* the line from its last passed node to the end of its base. Another robot is granted an edge
//! only when it stays `separation` away from all held lines and out of all zones, so two robots never overlap,
//! whatever their timing. Each extension looks at the held lines of the other robots that are near (a box test
//! each: robots × nodes released a second; 64 robots: 64 × 64 × 10 box tests a second).
//!
//! Robots that wait for each other in a ring are found by following who waits for whom, and broken by one of
//! them moving aside; a robot that stands in the way without work moves aside, too; one that cannot move
//! (charging, stuck, lost) is driven around.

use crate::{
    Coordinator, Output,
    ledger::RobotIndex,
    replan::Cause,
    robot::{Blocker, Errand, Hold, Phase, Robot, Wait},
    route::{Ending, Waypoint},
    way,
};
use protocol::{
    Timestamp,
    v1::{self, EventLevel, MissionState, ReplanCause},
};
use std::time::Duration;
use terrain::{Cell, Point, Segment};

/// What two bodies keep between them beyond touching, metres: tracking and pose error of both.
const GAP_M: f64 = 0.08;
/// How many nodes of another robot's route one keeps clear of when moving aside.
const NODES_TO_CLEAR: usize = 60;
/// How long a robot waits before anybody does something about it.
const PATIENCE: Duration = Duration::from_millis(1500);
/// A robot that moves aside so often within this time does not solve anything.
const YIELDS_MAX: usize = 4;
const YIELDS_WITHIN: Duration = Duration::from_secs(40);
/// How long a robot that moved aside waits at most.
const HOLD_MAX: Duration = Duration::from_secs(30);

impl Robot {
    /// What was granted is not granted any more, but may still be driven until its lease runs out or the agent
    /// acknowledges another order.
    pub(crate) fn retire_base(&mut self) {
        self.retiring = self.held.clone();
        self.retiring_until = self.lease_until;
    }
}

impl Coordinator {
    /// The least distance between the middle lines of two robots' ground, metres.
    pub(crate) fn separation_m(&self) -> f64 {
        2.0 * self.config.mission.body_radius_m + GAP_M
    }

    /// Releases as much of a robot's horizon as it needs and nobody else holds.
    pub(crate) fn extend_base(&mut self, now: Timestamp, index: RobotIndex) {
        if !self.may_extend(now, index) {
            return;
        }
        let mut ahead_m = self.robots[index].base_ahead_m();
        let mut blocker = None;
        while ahead_m < self.config.timing.base_length_m
            && !self.is_held_back(now, index)
            && self.comes_to_break(index).is_none()
            && self.lasts_for_next(index)
        {
            let Some((edge, to)) = self.robots[index].route.next_edge() else { break };
            blocker = self.what_blocks(index, edge, &to);
            if blocker.is_some() {
                break;
            }
            ahead_m += edge.length();
            let robot = &mut self.robots[index];
            robot.route.release_next();
            robot.held.push(edge);
        }
        let robot = &mut self.robots[index];
        robot.wait = blocker.map(|on| Wait {
            on,
            since: robot.wait.filter(|wait| wait.on == on).map_or(now, |wait| wait.since),
        });
    }

    fn may_extend(&self, _now: Timestamp, index: RobotIndex) -> bool {
        let robot = &self.robots[index];
        self.is_running()
            && !self.replanning.is_frozen(index)
            && !robot.stuck
            && robot.has_acknowledged()
            && robot.obstacle_since.is_none()
    }

    /// Whether the robot moved aside and is to wait there.
    fn is_held_back(&mut self, now: Timestamp, index: RobotIndex) -> bool {
        let Some(hold) = self.robots[index].hold else { return false };
        let other = &self.robots[hold.for_robot];
        let passed = other.phase != Phase::Ready
            || other.route.order_id() != hold.their_order
            || other.route.passed() >= hold.until_passed;
        if passed || now >= hold.until {
            self.robots[index].hold = None;
            return false;
        }
        self.robots[index].route.released() >= hold.at
    }

    fn what_blocks(&self, index: RobotIndex, edge: Segment, to: &Waypoint) -> Option<Blocker> {
        self.zone_in_the_way(edge, to)
            .map(Blocker::Zone)
            .or_else(|| self.conflict(index, edge).map(Blocker::Robot))
    }

    /// The zone that an edge would enter. Between centres of cells the cells tell; beside them, the ground on which a
    /// lost robot may stand, too.
    fn zone_in_the_way(&self, edge: Segment, to: &Waypoint) -> Option<u64> {
        self.zones.iter().next()?;
        let lattice = self.floor.lattice();
        let held = |cell: Cell| lattice.index(cell).filter(|&at| self.zones.holds(at));
        let zone_of = |cell: Cell| held(cell).and_then(|at| self.zones.at(at)).map(|zone| zone.id);
        if let Some(cell) = to.cell.filter(|_| self.cell_centred_at(edge.from).is_some()) {
            return zone_of(cell);
        }
        let stands_in = lattice.cell_at(edge.from);
        let entered = lattice.cells_along(edge).into_iter().filter(|&cell| Some(cell) != stands_in);
        let mut zones = entered.filter_map(zone_of);
        zones.next().or_else(|| self.zones.ground_near(edge, self.separation_m()))
    }

    /// The robot whose ground an edge would come too near to. Where both are too near already (they were put so),
    /// moving apart is allowed.
    pub(crate) fn conflict(&self, index: RobotIndex, edge: Segment) -> Option<RobotIndex> {
        let separation = self.separation_m();
        let start = Segment::new(edge.from, edge.from);
        (0..self.robots.len()).filter(|&other| other != index).find(|&other| {
            self.robots[other].held.iter().any(|held| {
                boxes_near(&edge, held, separation) && {
                    let gap = edge.distance(held);
                    gap < separation && gap < start.distance(held) - 1e-6
                }
            })
        })
    }

    /// Answers a robot's state: what it may drive, until when, and what of its evidence is in the ledger.
    pub(crate) fn grant(&mut self, now: Timestamp, index: RobotIndex, out: &mut Vec<Output>) {
        let lease_until = self.lease_end(now);
        let lease_ms =
            if self.state == MissionState::Paused { 0 } else { (self.config.timing.lease_s * 1000.0) as u32 };
        let term = self.config.term;
        let robot = &mut self.robots[index];
        let request_ns = robot.state.as_ref().map_or(0, |state| state.request_ns);
        let header_id = robot.next_header();
        if lease_ms > 0 {
            robot.lease_until = lease_until;
        }
        out.push(Output::Grant {
            robot: robot.id.clone(),
            grant: v1::Grant {
                header_id,
                term,
                epoch: robot.epoch,
                boot_id: robot.boot_id,
                order_id: robot.route.order_id(),
                order_update_id: robot.route.update_id(),
                released_sequence_id: robot.route.released(),
                request_ns,
                lease_ms,
                sweep_acknowledged: robot.sweep_sequence,
            },
        });
    }

    /// Looks who waits for whom, and resolves what does not resolve itself.
    pub(crate) fn resolve_waits(&mut self, now: Timestamp) {
        if !self.is_running() || self.replanning.is_busy() {
            return;
        }
        for index in 0..self.robots.len() {
            if let Some(on) = self.waits_long(now, index)
                && self.resolve(now, index, on)
            {
                return; // one at a time: the others look again with what has changed
            }
        }
    }

    fn waits_long(&self, now: Timestamp, index: RobotIndex) -> Option<Blocker> {
        let robot = &self.robots[index];
        let wait = robot.wait?;
        let long = now.since(wait.since) >= PATIENCE && robot.stands_at_base_end();
        (long && robot.phase == Phase::Ready && !robot.stuck).then_some(wait.on)
    }

    /// Does something about a robot that waits; returns whether anything changed.
    fn resolve(&mut self, now: Timestamp, index: RobotIndex, on: Blocker) -> bool {
        let blocker = match on {
            Blocker::Zone(_) => return self.detour(now, index) || self.give_way_to_replan(now, index),
            Blocker::Robot(blocker) => blocker,
        };
        match self.chain_from(now, index, blocker) {
            Chain::Moving => false,
            Chain::Ring(ring) => self.break_ring(now, &ring),
            Chain::EndsAt(last, before) => {
                if self.can_move_aside(last) {
                    self.move_aside(now, last, before)
                        || self.detour(now, index)
                        || self.give_way_to_replan(now, index)
                } else {
                    self.detour(now, index) || self.give_way_to_replan(now, index)
                }
            }
        }
    }

    fn can_move_aside(&self, index: RobotIndex) -> bool {
        let robot = &self.robots[index];
        robot.phase == Phase::Ready && !robot.stuck && !matches!(robot.errand, Errand::Charging(_))
    }

    /// Follows who waits for whom, from `index` on.
    fn chain_from(&self, now: Timestamp, index: RobotIndex, blocker: RobotIndex) -> Chain {
        let mut seen = vec![index];
        let mut at = blocker;
        loop {
            if let Some(start) = seen.iter().position(|&robot| robot == at) {
                return Chain::Ring(seen.split_off(start));
            }
            let robot = &self.robots[at];
            let before = *seen.last().expect("it began with one");
            seen.push(at);
            match robot.wait.map(|wait| wait.on) {
                Some(Blocker::Robot(next)) if robot.stands_at_base_end() && robot.phase == Phase::Ready => {
                    at = next;
                }
                _ if self.still_moves(now, at) => return Chain::Moving,
                _ => return Chain::EndsAt(at, before),
            }
        }
    }

    /// Whether a robot gets out of the way by itself.
    fn still_moves(&self, now: Timestamp, index: RobotIndex) -> bool {
        let robot = &self.robots[index];
        if robot.phase != Phase::Ready || robot.stuck || matches!(robot.errand, Errand::Charging(_)) {
            return false;
        }
        let goes_aside = robot.hold.is_none_or(|hold| robot.route.passed() < hold.at);
        let has_way = !robot.route.is_done() && robot.wait.is_none() && goes_aside;
        has_way && (robot.obstacle_since.is_none() || now.secs_since(robot.moved_at) < 1.0)
    }

    fn break_ring(&mut self, now: Timestamp, ring: &[RobotIndex]) -> bool {
        for (at, &index) in ring.iter().enumerate() {
            let follower = ring[(at + ring.len() - 1) % ring.len()];
            if self.can_move_aside(index) && self.move_aside(now, index, follower) {
                return true;
            }
        }
        ring.iter().any(|&index| self.detour(now, index)) || self.give_way_to_replan(now, ring[0])
    }

    /// Sends a robot off the route of another one, and back to its own when that has passed.
    fn move_aside(&mut self, now: Timestamp, index: RobotIndex, for_robot: RobotIndex) -> bool {
        self.robots[index].yielded.retain(|&at| now.since(at) < YIELDS_WITHIN);
        if self.robots[index].yielded.len() >= YIELDS_MAX {
            return false;
        }
        let Some(from) = self.start_cell(index) else { return false };
        let route_ahead = self.next_places(for_robot);
        let separation = self.separation_m();
        let lattice = *self.floor.lattice();
        let clear = |cell: Cell| {
            let center = lattice.center(cell);
            cell != from && route_ahead.iter().all(|edge| edge.distance_to_point(center) >= separation)
        };
        let others: Vec<Segment> = self.held_by_others(index);
        let open = |cell: Cell| {
            let center = lattice.center(cell);
            self.is_open_ground(cell)
                && others.iter().all(|held| held.distance_to_point(center) >= separation)
        };
        let Some(aside) = way::nearest(self.roads(), from, clear, open) else { return false };
        let end = self.robots[index].route.base_end().copied();
        let beside = end.filter(|end| end.cell.is_none());
        let back: Vec<Cell> = aside.iter().rev().copied().collect();
        let rest: Vec<Waypoint> = self.robots[index].route.horizon().copied().collect();
        let ending = self.robots[index].route.ending().clone();
        let mut places = self.places_from_base(index, &aside);
        let spot = self.robots[index].route.released() + places.len() as u64;
        if !rest.is_empty() {
            places.extend(self.places(&back));
            places.extend(beside);
            places.extend(rest);
        }
        let revision = self.replanning.revision();
        self.robots[index].route.stitch(revision, places, ending);
        let until_passed = self.passes_by(for_robot, &self.robots[index].held);
        let their_order = self.robots[for_robot].route.order_id();
        let robot = &mut self.robots[index];
        robot.yielded.push(now);
        robot.wait = None;
        robot.order_sent = Timestamp::ZERO;
        robot.hold = Some(Hold { at: spot, for_robot, their_order, until_passed, until: now + HOLD_MAX });
        let text = format!("moves aside for {}", self.robots[for_robot].id);
        let id = self.robots[index].id.clone();
        self.announcer.event(now, EventLevel::EventInfo, &id, "YIELDS", &text);
        true
    }

    /// The edges a robot wants to drive next, from where it stands.
    fn next_places(&self, index: RobotIndex) -> Vec<Segment> {
        let places: Vec<Point> =
            self.robots[index].route.ahead().take(NODES_TO_CLEAR).map(|node| node.point).collect();
        places.windows(2).map(|pair| Segment::new(pair[0], pair[1])).collect()
    }

    /// Number of the node by which a robot, on its next stretch, has driven past some ground.
    fn passes_by(&self, index: RobotIndex, ground: &[Segment]) -> u64 {
        let separation = self.separation_m();
        let is_near = |edge: &Segment| ground.iter().any(|held| edge.distance(held) < separation);
        let last = self.next_places(index).iter().rposition(is_near);
        self.robots[index].route.passed() + last.map_or(0, |edge| edge as u64 + 2)
    }

    pub(crate) fn held_by_others(&self, index: RobotIndex) -> Vec<Segment> {
        (0..self.robots.len())
            .filter(|&other| other != index)
            .flat_map(|other| self.robots[other].held.iter().copied())
            .collect()
    }

    /// A way around ground that will not come free soon: to the first place of the route that is not held.
    pub(crate) fn detour(&mut self, now: Timestamp, index: RobotIndex) -> bool {
        let Some(from) = self.start_cell(index) else { return false };
        let separation = self.separation_m();
        let lattice = *self.floor.lattice();
        let others = self.held_by_others(index);
        let open = |cell: Cell| {
            let center = lattice.center(cell);
            self.is_open_ground(cell)
                && others.iter().all(|held| held.distance_to_point(center) >= separation)
        };
        let horizon: Vec<Waypoint> = self.robots[index].route.horizon().copied().collect();
        let Some((target, goal)) = self.where_to_join(from, &horizon, &others, open) else { return false };
        let Some(around) = way::nearest(self.roads(), from, |cell| cell == goal, open) else { return false };
        let mut places = self.places_from_base(index, &around);
        if places.is_empty() {
            return false;
        }
        let joined = usize::from(horizon[target].cell == Some(goal));
        places.extend(horizon[target + joined..].iter().copied());
        let ending = self.robots[index].route.ending().clone();
        let revision = self.replanning.revision();
        let robot = &mut self.robots[index];
        robot.route.stitch(revision, places, ending);
        robot.wait = None;
        robot.order_sent = Timestamp::ZERO;
        let id = robot.id.clone();
        let text = format!("{:.1} m around what is in the way", (around.len() - 1) as f64 * lattice.cell_m);
        self.announcer.event(now, EventLevel::EventInfo, &id, "DETOUR", &text);
        true
    }

    /// The first place of a horizon that is not held, and the open cell from which to get there. Beside the lattice the
    /// way from the cell to the place, and on from there, must be free as well.
    fn where_to_join(
        &self,
        from: Cell,
        horizon: &[Waypoint],
        others: &[Segment],
        open: impl Fn(Cell) -> bool,
    ) -> Option<(usize, Cell)> {
        let separation = self.separation_m();
        let free = |from: Point, to: &Waypoint| {
            let edge = Segment::new(from, to.point);
            others.iter().all(|held| held.distance(&edge) >= separation)
                && self.zone_in_the_way(edge, to).is_none()
        };
        horizon.iter().enumerate().find_map(|(at, node)| {
            if let Some(cell) = node.cell {
                return open(cell).then_some((at, cell));
            }
            let goes_on = horizon.get(at + 1).is_none_or(|next| free(node.point, next));
            let cell = self.cell_beside(node.point, |_| true).filter(|&cell| open(cell))?;
            // Not back to the place before which it stands.
            let leads_on = at > 0 || cell != from;
            (leads_on && goes_on && free(self.floor.lattice().center(cell), node)).then_some((at, cell))
        })
    }

    /// Nothing local helps: the fleet is planned anew from where everybody stands.
    fn give_way_to_replan(&mut self, now: Timestamp, index: RobotIndex) -> bool {
        if !self.replanning.may_replan_for_deadlock(now) {
            return false;
        }
        self.replanning.untie = (0..self.robots.len())
            .filter(|&robot| robot == index || self.robots[robot].stands_at_base_end())
            .collect();
        self.need_plan(now, Cause::of(ReplanCause::CauseDeadlock, index, "no way past each other"));
        true
    }

    /// A cell as a place of a route: the tool is on where something is missing, in it or beside it where nobody can stand.
    pub(crate) fn place(&self, cell: Cell) -> Waypoint {
        let lattice = self.floor.lattice();
        let point = lattice.center(cell);
        let own = lattice.index(cell);
        let is_task = |index: usize| Some(index) == own || !self.floor.is_drivable(index);
        let tool_active = own.is_some_and(|index| self.ledger.is_open(index))
            || self
                .cells_swept(Segment::new(point, point))
                .into_iter()
                .any(|(index, samples)| is_task(index) && samples & self.ledger.missing(index) != 0);
        Waypoint { point, cell: Some(cell), tool_active }
    }

    /// Sends a robot along a way that begins in its start cell, then on to an ending.
    pub(crate) fn send_along(
        &mut self,
        index: RobotIndex,
        way: &[Cell],
        tail: Option<Point>,
        ending: Ending,
    ) {
        let mut places = self.places_from_base(index, way);
        places.extend(tail.map(|point| Waypoint { point, cell: None, tool_active: false }));
        let revision = self.replanning.revision();
        let robot = &mut self.robots[index];
        robot.route.stitch(revision, places, ending);
        robot.break_off = None;
        robot.wait = None;
        robot.hold = None;
        robot.order_sent = Timestamp::ZERO;
    }
}

/// What stands at the end of a chain of robots that wait for each other.
enum Chain {
    /// Somebody who moves on by himself.
    Moving,
    /// A ring.
    Ring(Vec<RobotIndex>),
    /// A robot that does not move by itself, and the one that waits for it.
    EndsAt(RobotIndex, RobotIndex),
}

fn boxes_near(a: &Segment, b: &Segment, distance: f64) -> bool {
    let apart = |a0: f64, a1: f64, b0: f64, b1: f64| {
        a0.min(a1) > b0.max(b1) + distance || b0.min(b1) > a0.max(a1) + distance
    };
    !apart(a.from.x, a.to.x, b.from.x, b.to.x) && !apart(a.from.y, a.to.y, b.from.y, b.to.y)
}
