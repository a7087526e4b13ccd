//! Ground that must not be entered for now: blockages that were seen, and places where a robot was lost.
//!
//! A zone loses its cells one by one, as range scans of robots see through them; it never expires by itself.
//!
//! ```text
//!            ·  ·  ·  beams
//!      R ─ ─ ─ ─ ─ ( o ) ─ ─   a cell is seen free when every beam that meets the disc of a body
//!            ·  ·  ·           at its centre comes out behind it, and no body could hide between beams
//! ```
//!
//! The disc reaches as far beyond the body as half a move to the next cell needs, so that ground seen free can be left
//! on all sides; only walls of the map and robots may stand in that rim. Else an obstacle that stays would be found again and again.

use protocol::{
    Timestamp,
    v1::{self, UnreachableReason, ZoneType},
};
use std::{collections::BTreeSet, time::Duration};
use terrain::{Floor, Point, Segment, angle_between};

/// Beams may be this far apart at the cell for a body not to hide between them, metres.
const BEAM_SPACING_MAX_M: f64 = 0.2;
/// After the second strike a cell cannot be seen free for three times this long; twice as long each time, seconds.
const LOCK_S: f64 = 10.0;
const STRIKES_MAX: u8 = 8;
/// What a hit may be nearer than the body's disc without meaning anything, metres (range noise).
const HIT_SLACK_M: f64 = 0.03;

/// One zone. Cells by their row-major number.
#[derive(Debug, Clone)]
pub(crate) struct Zone {
    pub(crate) id: u64,
    pub(crate) kind: ZoneType,
    pub(crate) cells: BTreeSet<usize>,
    /// Of a quarantine: the lines on which a lost robot may stand, as far as its cells are not seen free. Whoever drives
    /// beside the cells' centres keeps away from these.
    pub(crate) ground: Vec<Segment>,
    /// Robot that reported it, or that was lost there.
    pub(crate) cause: String,
    pub(crate) since: Timestamp,
    /// Before this moment a robot that is silent might still drive there.
    pub(crate) locked_until: Timestamp,
    /// How often a robot went to look whether it is free.
    pub(crate) looks: u32,
    pub(crate) next_look: Timestamp,
}

/// All zones, and a count of zones by cell.
#[derive(Debug, Default)]
pub(crate) struct Zones {
    list: Vec<Zone>,
    blocked: Vec<u16>,
    /// How often each cell was found blocked: a cell that is seen free and found blocked again and again (an
    /// obstacle at its edge) is trusted less and less.
    strikes: Vec<u8>,
    next_id: u64,
}

impl Zones {
    pub(crate) fn new(cells: usize) -> Self {
        Self { list: Vec::new(), blocked: vec![0; cells], strikes: vec![0; cells], next_id: 1 }
    }

    /// Whether a cell lies in some zone.
    pub(crate) fn holds(&self, index: usize) -> bool {
        self.blocked[index] > 0
    }

    /// The zone that holds a cell.
    pub(crate) fn at(&self, index: usize) -> Option<&Zone> {
        self.list.iter().find(|zone| zone.cells.contains(&index))
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &Zone> {
        self.list.iter()
    }

    pub(crate) fn get_mut(&mut self, id: u64) -> Option<&mut Zone> {
        self.list.iter_mut().find(|zone| zone.id == id)
    }

    /// Adds a zone; cells of it that are known already stay with the older zone. Returns its id, or `None` when
    /// nothing new is in it.
    pub(crate) fn add(
        &mut self,
        kind: ZoneType,
        cells: impl IntoIterator<Item = usize>,
        cause: &str,
        since: Timestamp,
        locked_until: Timestamp,
    ) -> Option<u64> {
        let cells: BTreeSet<usize> = cells.into_iter().filter(|&index| self.blocked[index] == 0).collect();
        if cells.is_empty() {
            return None;
        }
        let mut strikes = 0;
        for &index in &cells {
            self.blocked[index] += 1;
            self.strikes[index] = self.strikes[index].saturating_add(1).min(STRIKES_MAX);
            strikes = strikes.max(self.strikes[index]);
        }
        let distrust_s = LOCK_S * f64::from((1_u32 << (strikes - 1)) - 1);
        let id = self.next_id;
        self.next_id += 1;
        self.list.push(Zone {
            id,
            kind,
            cells,
            ground: Vec::new(),
            cause: cause.to_owned(),
            since,
            locked_until: locked_until.max(since + Duration::from_secs_f64(distrust_s)),
            looks: u32::from(strikes - 1),
            next_look: since + Duration::from_secs_f64(distrust_s),
        });
        Some(id)
    }

    /// Drops the zones that a robot left behind when it was lost; it is back.
    pub(crate) fn forget_quarantine_of(&mut self, robot: &str) {
        let theirs = |zone: &Zone| zone.kind == ZoneType::ZoneQuarantine && zone.cause == robot;
        let ids: Vec<u64> = self.list.iter().filter(|zone| theirs(zone)).map(|zone| zone.id).collect();
        for &id in &ids {
            self.remove(id);
        }
    }

    fn remove(&mut self, id: u64) {
        if let Some(at) = self.list.iter().position(|zone| zone.id == id) {
            for index in self.list.remove(at).cells {
                self.blocked[index] -= 1;
            }
        }
    }

    /// Says on which lines a lost robot may stand.
    pub(crate) fn set_ground(&mut self, id: u64, ground: Vec<Segment>) {
        if let Some(zone) = self.get_mut(id) {
            zone.ground = ground;
        }
    }

    /// The zone with ground nearer than `separation_m` to an edge, unless the edge leads away from it.
    pub(crate) fn ground_near(&self, edge: Segment, separation_m: f64) -> Option<u64> {
        let start = Segment::new(edge.from, edge.from);
        let near = |line: &Segment| {
            let gap_m = edge.distance(line);
            gap_m < separation_m && gap_m < start.distance(line) - 1e-6
        };
        self.list.iter().find(|zone| zone.ground.iter().any(near)).map(|zone| zone.id)
    }

    /// Whether a cell of a zone is nearer to a point than this, metres.
    pub(crate) fn any_within(&self, floor: &Floor, point: Point, reach_m: f64) -> bool {
        let lattice = floor.lattice();
        let near = |&index: &usize| (lattice.center(lattice.cell(index)) - point).norm() < reach_m;
        self.list.iter().any(|zone| zone.cells.iter().any(near))
    }

    /// Takes cells out of the zones that `scan`, taken at `from`, sees through. Returns the cells freed. `known` says of
    /// each beam whether it hit a wall of the map or another robot.
    pub(crate) fn clear_by_scan(
        &mut self,
        now: Timestamp,
        floor: &Floor,
        from: &v1::Pose,
        scan: &v1::RangeScan,
        known: &[bool],
    ) -> Vec<usize> {
        let eye = Point::new(from.x_m, from.y_m);
        let mut freed = Vec::new();
        for zone in self.list.iter_mut().filter(|zone| now >= zone.locked_until) {
            let sees = |index: &usize| {
                let center = floor.lattice().center(floor.lattice().cell(*index));
                is_seen_free(eye, from.theta_rad, scan, known, center, floor)
            };
            let seen: Vec<usize> = zone.cells.iter().copied().filter(|index| sees(index)).collect();
            for index in seen {
                zone.cells.remove(&index);
                self.blocked[index] -= 1;
                freed.push(index);
            }
            let lattice = floor.lattice();
            let centers: Vec<Point> =
                zone.cells.iter().map(|&index| lattice.center(lattice.cell(index))).collect();
            let reach_m = 2.0 * floor.body_radius_m() + lattice.cell_m;
            zone.ground.retain(|line| centers.iter().any(|&center| line.distance_to_point(center) < reach_m));
        }
        self.list.retain(|zone| !zone.cells.is_empty());
        freed
    }

    /// For those who watch.
    pub(crate) fn to_wire(&self, floor: &Floor) -> Vec<v1::Zone> {
        let point = |&index: &usize| {
            let center = floor.lattice().center(floor.lattice().cell(index));
            v1::Point { x_m: center.x, y_m: center.y }
        };
        self.list
            .iter()
            .map(|zone| v1::Zone {
                zone_id: zone.id,
                zone_type: zone.kind.into(),
                cells: zone.cells.iter().map(point).collect(),
                cause: zone.cause.clone(),
                since_ns: zone.since.as_nanos(),
                reason: UnreachableReason::Obstacle.into(),
            })
            .collect()
    }
}

/// Whether a scan shows that a body could stand at `center` and leave it on all sides.
fn is_seen_free(
    eye: Point,
    heading: f64,
    scan: &v1::RangeScan,
    known: &[bool],
    center: Point,
    floor: &Floor,
) -> bool {
    let body_m = floor.body_radius_m();
    let rim_m = body_m.hypot(floor.lattice().cell_m / 2.0) + HIT_SLACK_M;
    let to = center - eye;
    let distance = to.norm();
    if distance + body_m > scan.range_max_m || distance * scan.angle_increment_rad.abs() > BEAM_SPACING_MAX_M
    {
        return false;
    }
    if distance <= body_m {
        return true; // the robot itself stands there
    }
    let bearing = to.y.atan2(to.x);
    let mut crossing = 0;
    for (beam, &range) in scan.ranges_m.iter().enumerate() {
        let direction = heading + scan.angle_min_rad + scan.angle_increment_rad * beam as f64;
        let off = angle_between(bearing, direction);
        let miss = distance * off.sin();
        if off.cos() <= 0.0 || miss.abs() >= rim_m {
            continue;
        }
        let (range, along) = (f64::from(range), distance * off.cos());
        let ends_before = |radius_m: f64| {
            let half2 = radius_m * radius_m - miss * miss;
            half2 > 0.0 && range < (along + half2.sqrt()).min(scan.range_max_m) - HIT_SLACK_M
        };
        if ends_before(body_m) || ends_before(rim_m) && !known[beam] {
            return false;
        }
        crossing += u32::from(miss.abs() < body_m);
    }
    crossing >= 2
}

/// The drivable cells that an obstacle with these surface points makes unusable for a body, and those at whose
/// far side a planned edge would touch it.
pub(crate) fn cells_blocked_by(floor: &Floor, hits: &[Point], edges: &[Segment]) -> BTreeSet<usize> {
    let lattice = floor.lattice();
    let reach = floor.body_radius_m() + 0.05;
    let mut cells = BTreeSet::new();
    for &hit in hits {
        let low = Point::new(hit.x - reach, hit.y - reach);
        let high = Point::new(hit.x + reach, hit.y + reach);
        for cell in lattice.cells_in_box(low, high) {
            let near = (lattice.center(cell) - hit).norm() < reach;
            if near && floor.cell_is_drivable(cell) {
                cells.extend(lattice.index(cell));
            }
        }
        for edge in edges.iter().filter(|edge| edge.distance_to_point(hit) < reach) {
            let ahead = lattice.cell_at(edge.to).and_then(|cell| lattice.index(cell));
            cells.extend(ahead.filter(|&index| floor.is_drivable(index)));
        }
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrain::{Cell, GridMap};

    const UNKNOWN: [bool; 48] = [false; 48];

    fn floor() -> Floor {
        let map = GridMap::from_drawing(&"..........\n".repeat(6), 0.5).unwrap();
        Floor::new(&map, 0.5, 0.177, 0.75).unwrap()
    }

    fn scan(range: impl Fn(usize) -> f32) -> v1::RangeScan {
        v1::RangeScan {
            range_max_m: 3.0,
            angle_min_rad: -std::f64::consts::PI,
            angle_increment_rad: std::f64::consts::TAU / 48.0,
            ranges_m: (0..48).map(range).collect(),
        }
    }

    fn pose(x_m: f64, y_m: f64) -> v1::Pose {
        v1::Pose { x_m, y_m, theta_rad: 0.0 }
    }

    #[test]
    fn a_zone_is_freed_by_beams_that_pass_through_it() {
        let floor = floor();
        let index = floor.lattice().index(Cell::new(4, 2)).unwrap();
        let mut zones = Zones::new(floor.lattice().len());
        zones.add(ZoneType::ZoneBlocked, [index], "r1", Timestamp::ZERO, Timestamp::ZERO).unwrap();
        let blocked_ahead = scan(|beam| if (20..=28).contains(&beam) { 0.8 } else { 3.0 });
        assert!(
            zones
                .clear_by_scan(Timestamp::ZERO, &floor, &pose(1.25, 1.25), &blocked_ahead, &UNKNOWN)
                .is_empty()
        );
        assert!(zones.holds(index));
        assert_eq!(
            zones.clear_by_scan(Timestamp::ZERO, &floor, &pose(1.25, 1.25), &scan(|_| 3.0), &UNKNOWN),
            [index]
        );
        assert!(!zones.holds(index) && zones.iter().next().is_none());
    }

    #[test]
    fn a_scan_from_far_away_frees_nothing() {
        let floor = floor();
        let index = floor.lattice().index(Cell::new(8, 2)).unwrap();
        let mut zones = Zones::new(floor.lattice().len());
        zones.add(ZoneType::ZoneBlocked, [index], "r1", Timestamp::ZERO, Timestamp::ZERO).unwrap();
        assert!(
            zones
                .clear_by_scan(Timestamp::ZERO, &floor, &pose(1.75, 1.25), &scan(|_| 3.0), &UNKNOWN)
                .is_empty()
        );
    }

    #[test]
    fn a_locked_zone_stays_until_the_lease_has_run_out() {
        let floor = floor();
        let index = floor.lattice().index(Cell::new(4, 2)).unwrap();
        let mut zones = Zones::new(floor.lattice().len());
        let later = Timestamp::from_secs_f64(3.0);
        zones.add(ZoneType::ZoneQuarantine, [index], "r2", Timestamp::ZERO, later).unwrap();
        assert!(
            zones
                .clear_by_scan(Timestamp::ZERO, &floor, &pose(1.25, 1.25), &scan(|_| 3.0), &UNKNOWN)
                .is_empty()
        );
        assert_eq!(zones.clear_by_scan(later, &floor, &pose(1.25, 1.25), &scan(|_| 3.0), &UNKNOWN), [index]);
    }

    #[test]
    fn an_obstacle_between_two_cells_blocks_the_edge() {
        let floor = floor();
        let (from, to) = (floor.lattice().center(Cell::new(3, 2)), floor.lattice().center(Cell::new(4, 2)));
        let hit = Point::new(2.0, 1.25);
        let cells = cells_blocked_by(&floor, &[hit], &[Segment::new(from, to)]);
        assert!(cells.contains(&floor.lattice().index(Cell::new(4, 2)).unwrap()));
    }
}
