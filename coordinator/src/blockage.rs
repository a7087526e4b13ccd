//! Obstacles that the map does not know: waited for, then deferred, then seen free again.
//!
//! A robot that has stood before something for `wait_threshold_s` makes the place a zone and goes on around it along its
//! own route: no other robot hears of it, and a passer-by costs no plan. What the zone hides is deferred: it is taken up
//! with the next plan after it was seen free, at the latest when a robot has nothing else to do. Only where a robot
//! finds no way around is the fleet planned anew at once.

use crate::{
    Coordinator,
    ledger::{RobotIndex, Status},
    replan::Cause,
    robot::{Errand, Phase},
    route::Waypoint,
    zones,
};
use protocol::{
    Timestamp,
    v1::{self, ErrorType, EventLevel, ReplanCause, ZoneType},
};
use terrain::{Point, Segment};

/// Hits of a scan as near as this to a wall of the map are the wall, metres.
const WALL_SLACK_M: f64 = 0.1;
/// What was seen free is taken up after so long when no robot is idle, seconds.
const GATHER_S: f64 = 60.0;
/// Other hits as near as this to a blockage belong to it, metres.
const SAME_OBSTACLE_M: f64 = 0.8;

/// Cells seen free, gathered until a robot has driven past all of a zone.
#[derive(Debug, Default)]
pub(crate) struct Sightings {
    cells: usize,
    by: RobotIndex,
    first: Timestamp,
    last: Timestamp,
}

impl Sightings {
    fn note(&mut self, now: Timestamp, by: RobotIndex, cells: usize) {
        if self.cells == 0 {
            self.first = now;
        }
        self.cells += cells;
        self.by = by;
        self.last = now;
    }

    /// Whether something was seen that is not taken up yet.
    pub(crate) fn is_pending(&self) -> bool {
        self.cells > 0
    }

    /// What was seen, once it is complete; at once when a robot has nothing else to do.
    fn take(&mut self, now: Timestamp, idle: bool) -> Option<(RobotIndex, usize)> {
        let complete = now.secs_since(self.first) > GATHER_S;
        let pause = now.secs_since(self.last) > 1.0;
        (self.cells > 0 && (complete || idle && pause)).then(|| (self.by, std::mem::take(&mut self.cells)))
    }
}

impl Coordinator {
    /// Lets a robot's scan free zones.
    pub(crate) fn take_scan(&mut self, now: Timestamp, index: RobotIndex) {
        if self.zones.iter().next().is_none() {
            return;
        }
        let Some(state) = self.robots[index].state.as_ref() else { return };
        let (Some(scan), Some(pose)) = (&state.scan, &state.pose) else { return };
        if !self.zones.any_within(&self.floor, Point::new(pose.x_m, pose.y_m), scan.range_max_m) {
            return;
        }
        let hits = beam_ends(pose, scan);
        let hit_known =
            |(end, &range): (Point, &f32)| f64::from(range) < scan.range_max_m && self.is_known(index, end);
        let known: Vec<bool> = hits.zip(&scan.ranges_m).map(hit_known).collect();
        let freed = self.zones.clear_by_scan(now, &self.floor, pose, scan, &known);
        if freed.is_empty() {
            return;
        }
        self.sightings.note(now, index, freed.len());
        self.zones_changed();
    }

    /// When nothing more has been seen free for a moment, what was is taken up.
    pub(crate) fn check_sightings(&mut self, now: Timestamp) {
        let idle = self.coverers().iter().any(|&robot| self.robots[robot].route.is_done());
        let Some((index, cells)) = self.sightings.take(now, idle) else { return };
        let text = format!("{cells} cells seen free");
        self.idle_checks.new_ground();
        let left = self.ledger.open_cells().any(|cell| match self.ledger.status(cell) {
            Status::Assigned(owner) => self.robots[owner].route.is_done(),
            _ => true,
        });
        if left {
            self.need_plan(now, Cause::of(ReplanCause::CauseZoneCleared, index, &text));
        } else {
            let id = self.robots[index].id.clone();
            self.announcer.event(now, EventLevel::EventInfo, &id, "ZONE CLEARED", &text);
        }
    }

    /// To be called when zones came or went.
    pub(crate) fn zones_changed(&mut self) {
        self.measure_station_moves();
    }

    /// Looks for robots that stand before an obstacle, and makes a zone when the wait was long enough.
    pub(crate) fn check_obstacles(&mut self, now: Timestamp) {
        for index in 0..self.robots.len() {
            let hits = self.reported_hits(index);
            let robot = &mut self.robots[index];
            if hits.is_empty() || robot.phase != Phase::Ready {
                robot.obstacle_since = None;
                continue;
            }
            let since = *robot.obstacle_since.get_or_insert(now);
            if now.secs_since(since) >= self.config.timing.wait_threshold_s && self.is_running() {
                self.block(now, index, &hits);
            }
        }
    }

    fn reported_hits(&self, index: RobotIndex) -> Vec<Point> {
        let Some(state) = self.robots[index].state.as_ref() else { return Vec::new() };
        state
            .errors
            .iter()
            .filter(|error| error.error_type() == ErrorType::NodeUnreachable)
            .flat_map(|error| error.points.iter().map(|point| Point::new(point.x_m, point.y_m)))
            .collect()
    }

    fn block(&mut self, now: Timestamp, index: RobotIndex, reported: &[Point]) {
        let hits = self.with_the_rest_of_the_obstacle(index, reported);
        let base: Vec<Point> = self.robots[index].route.base().map(|node| node.point).collect();
        let mut edges: Vec<Segment> = base.windows(2).map(|pair| Segment::new(pair[0], pair[1])).collect();
        edges.extend(self.robots[index].route.next_edge().map(|(edge, _)| edge));
        let mut cells = zones::cells_blocked_by(&self.floor, &hits, &edges);
        self.spare_stands(&mut cells, index);
        let id = self.robots[index].id.clone();
        let waited_s = self.robots[index].obstacle_since.map_or(0.0, |since| now.secs_since(since));
        let added = self.zones.add(ZoneType::ZoneBlocked, cells, &id, now, now);
        self.zones_changed();
        self.robots[index].obstacle_since = Some(now);
        let near = reported.first().map_or_else(String::new, |p| format!(" at ({:.1}, {:.1}) m", p.x, p.y));
        let text = match added {
            Some(zone) => format!("obstacle{near} for {waited_s:.1} s, now zone {zone}"),
            None => format!("obstacle{near} still there"),
        };
        if added.is_some() && self.goes_on_around(now, index) {
            let text = format!("{text} → goes on around it");
            self.announcer.event(now, EventLevel::EventWarning, &id, "BLOCKED", &text);
            return;
        }
        self.restart_route(now, index);
        self.resume_errand(now, index);
        self.need_plan(now, Cause::of(ReplanCause::CauseBlockage, index, &text));
    }

    /// Goes on along its own route, from the first place that is open and can be reached; what lies before is deferred.
    fn goes_on_around(&mut self, now: Timestamp, index: RobotIndex) -> bool {
        if self.robots[index].errand != Errand::Cover || self.replanning.is_busy() {
            return false;
        }
        let rest: Vec<Waypoint> = self.robots[index].route.ahead().skip(1).copied().collect();
        let ending = self.robots[index].route.ending().clone();
        self.begin_order_where_it_stands(index);
        let revision = self.replanning.revision();
        self.robots[index].route.stitch(revision, rest, ending);
        self.detour(now, index)
    }

    /// The cell a robot stands in is no part of a zone: it is there and nothing else is.
    fn spare_stands(&self, cells: &mut std::collections::BTreeSet<usize>, index: RobotIndex) {
        let Some(position) = self.robots[index].position() else { return };
        let lattice = self.floor.lattice();
        let passed = self.robots[index].route.base().next().and_then(|node| node.cell);
        let stand = lattice.cell_at(position);
        for cell in passed.into_iter().chain(stand) {
            let near = (lattice.center(cell) - position).norm() < 0.3 * lattice.cell_m;
            if near {
                lattice.index(cell).map(|cell| cells.remove(&cell));
            }
        }
    }

    /// The reported hits, and those of the robot's scan that belong to the same obstacle.
    fn with_the_rest_of_the_obstacle(&self, index: RobotIndex, reported: &[Point]) -> Vec<Point> {
        let mut hits = reported.to_vec();
        let Some(state) = self.robots[index].state.as_ref() else { return hits };
        let (Some(scan), Some(pose)) = (&state.scan, &state.pose) else { return hits };
        let foreign = scan_points(pose, scan).filter(|&hit| !self.is_known(index, hit));
        hits.extend(foreign.filter(|hit| reported.iter().any(|near| (near - hit).norm() < SAME_OBSTACLE_M)));
        hits
    }

    /// Whether a hit is a wall of the map or another robot.
    fn is_known(&self, index: RobotIndex, hit: Point) -> bool {
        let wall = !self.config.mission.map.disc_is_free(hit, WALL_SLACK_M);
        let body_m = self.config.mission.body_radius_m + 0.15;
        wall || self.robots.iter().enumerate().any(|(other, robot)| {
            other != index
                && robot.phase == Phase::Ready
                && robot.position().is_some_and(|position| (position - hit).norm() < body_m)
        })
    }
}

/// The points a scan hit, metres in the map frame.
fn scan_points<'a>(pose: &'a v1::Pose, scan: &'a v1::RangeScan) -> impl Iterator<Item = Point> + 'a {
    let hit = |&(_, &range): &(Point, &f32)| f64::from(range) < scan.range_max_m - 1e-3;
    beam_ends(pose, scan).zip(&scan.ranges_m).filter(hit).map(|(end, _)| end)
}

/// Where the beams of a scan end, metres in the map frame.
fn beam_ends<'a>(pose: &'a v1::Pose, scan: &'a v1::RangeScan) -> impl Iterator<Item = Point> + 'a {
    scan.ranges_m.iter().enumerate().map(|(beam, &range)| {
        let bearing = pose.theta_rad + scan.angle_min_rad + scan.angle_increment_rad * beam as f64;
        let range = f64::from(range);
        Point::new(pose.x_m + range * bearing.cos(), pose.y_m + range * bearing.sin())
    })
}
