//! The exact parts of a straight line on which the body's centre may be.
//!
//! A square of the map closes those places of a line that are nearer to it than the body's radius: a square with round
//! corners, which is convex, so the closed part is one interval. Cells that are blocked (or not drivable, where there is
//! no map) close the part of the line that lies in them, and without a map so do their sides by which they cannot be left.

use super::{ConfigurationSpace, TANGENT_M};
use terrain::{Cell, Direction, GridMap, Point, Segment, Vector};

/// Ends of open parts keep so far away from what closes them, metres.
const MARGIN_M: f64 = 2e-6;
/// The same where sides of cells close it: a slanting line comes near to a side long before it meets it.
const SIDE_MARGIN_M: f64 = 1e-4;

impl ConfigurationSpace<'_> {
    /// The open parts of a segment, as distances from its first end, in order.
    pub(crate) fn slice(&self, segment: Segment) -> Vec<(f64, f64)> {
        let length_m = segment.length();
        let mut closed: Vec<(f64, f64)> = Vec::new();
        if let (Some(map), Some(walls)) = (self.instance.floor.map(), &self.walls) {
            let radius_m = self.instance.floor.body_radius_m() - 0.5 * TANGENT_M;
            match axis(segment) {
                Some(axis) => walls.each_closed(axis, segment, radius_m, |begin_m, end_m| {
                    closed.push((begin_m - MARGIN_M, end_m + MARGIN_M));
                }),
                None => closed_by_squares(map, segment, radius_m, &mut closed),
            }
        }
        if self.any_blocked || self.instance.floor.map().is_none() {
            self.closed_by_cells(segment, &mut closed);
        }
        closed.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut open = Vec::new();
        let mut from_m = 0.0;
        for (begin_m, end_m) in
            closed.into_iter().take_while(|part| part.0 < length_m).chain([(length_m, length_m)])
        {
            if begin_m - from_m > 2.0 * MARGIN_M {
                open.push((from_m, begin_m));
            }
            from_m = f64::max(from_m, end_m);
        }
        // A margin along the line is none across it where the line all but runs along a side.
        if self.instance.floor.map().is_none() && length_m > 0.0 {
            let at = |way_m: f64| segment.from + (segment.to - segment.from) * (way_m / length_m);
            open.retain(|part| self.instance.floor.segment_is_free(Segment::new(at(part.0), at(part.1))));
        }
        open
    }

    fn closed_by_cells(&self, segment: Segment, closed: &mut Vec<(f64, f64)>) {
        let (floor, lattice) = (self.instance.floor, self.instance.floor.lattice());
        let length_m = segment.length();
        let margin_m = if floor.map().is_some() { MARGIN_M } else { SIDE_MARGIN_M };
        let mut before: Option<Cell> = None;
        for (from_m, to_m) in pieces(segment, lattice.origin, lattice.cell_m) {
            let at = |way_m: f64| segment.from + (segment.to - segment.from) * (way_m / length_m);
            // On a line of the lattice but for rounding it is on the side that verify takes it to be on.
            let cell = lattice.cells_along(Segment::new(at(from_m), at(to_m))).first().copied();
            // Without a map the sides of cells may be walls: those across are looked at below, these are beside the line.
            let inner = || Segment::new(at(from_m + margin_m), at(to_m - margin_m));
            let open = cell.is_some_and(|cell| self.cell_is_open(cell))
                && (floor.map().is_some()
                    || to_m - from_m > 2.0 * margin_m && floor.segment_is_free(inner()));
            if !open {
                closed.push((from_m - margin_m, to_m + margin_m));
            }
            if let (Some(before), Some(cell), true) = (before, cell, floor.map().is_none()) {
                let joined = before == cell
                    || Direction::between(before, cell).is_some_and(|way| floor.can_move(before, way));
                if !joined {
                    closed.push((from_m - margin_m, from_m + margin_m));
                }
            }
            before = cell;
        }
    }
}

/// 0 for a segment along x, 1 for one along y.
fn axis(segment: Segment) -> Option<usize> {
    (0..2).find(|axis| (segment.from[1 - axis] - segment.to[1 - axis]).abs() < 1e-12)
}

/// The pieces of a segment between the lines of a lattice, as distances from its first end.
fn pieces(segment: Segment, origin: Point, cell_m: f64) -> Vec<(f64, f64)> {
    let way = segment.to - segment.from;
    let length_m = way.norm();
    let mut ends_m = vec![0.0, length_m];
    for axis in (0..2).filter(|&axis| way[axis] != 0.0) {
        let line = |place: f64| (place - origin[axis]) / cell_m;
        let (one, other) = (line(segment.from[axis]), line(segment.to[axis]));
        let lines = one.min(other).ceil() as i64..=one.max(other).floor() as i64;
        ends_m.extend(lines.map(|number| (number as f64 - one) / (other - one) * length_m));
    }
    ends_m.retain(|end_m| (0.0..=length_m).contains(end_m));
    ends_m.sort_by(f64::total_cmp);
    ends_m.windows(2).filter(|pair| pair[1] - pair[0] > 1e-9).map(|pair| (pair[0], pair[1])).collect()
}

fn closed_by_squares(map: &GridMap, segment: Segment, radius_m: f64, closed: &mut Vec<(f64, f64)>) {
    let length_m = segment.length();
    if length_m == 0.0 {
        return;
    }
    let towards = (segment.to - segment.from) / length_m;
    // The box around a long slanting segment is large: look along pieces of it.
    let pieces = (length_m / (16.0 * map.resolution_m())).ceil().max(1.0);
    for piece in 0..pieces as u32 {
        let at = |number: u32| segment.from + towards * (length_m * f64::from(number) / pieces);
        for (x, y) in map.blocked_squares_near(Segment::new(at(piece), at(piece + 1)), radius_m) {
            let corner = map.origin() + Vector::new(x as f64, y as f64) * map.resolution_m();
            if let Some((begin_m, end_m)) =
                closed_by(corner, map.resolution_m(), segment.from, towards, radius_m)
            {
                closed.push((begin_m - MARGIN_M, end_m + MARGIN_M));
            }
        }
    }
}

/// Whether a segment comes nearer than `radius_m` to a square with the lower left `corner`.
pub(super) fn touches(corner: Point, side_m: f64, segment: Segment, radius_m: f64) -> bool {
    let length_m = segment.length();
    if length_m == 0.0 {
        return Segment::new(segment.from, segment.from).distance_to_point(nearest(
            corner,
            side_m,
            segment.from,
        )) < radius_m;
    }
    let towards = (segment.to - segment.from) / length_m;
    closed_by(corner, side_m, segment.from, towards, radius_m)
        .is_some_and(|(begin_m, end_m)| begin_m < length_m && end_m > 0.0)
}

fn nearest(corner: Point, side_m: f64, point: Point) -> Point {
    Point::new(point.x.clamp(corner.x, corner.x + side_m), point.y.clamp(corner.y, corner.y + side_m))
}

/// Where a line is nearer than `radius_m` to a square with the lower left `corner`.
fn closed_by(corner: Point, side_m: f64, from: Point, towards: Vector, radius_m: f64) -> Option<(f64, f64)> {
    let far = corner + Vector::new(side_m, side_m);
    let mut closed: Option<(f64, f64)> = None;
    let mut join = |part: Option<(f64, f64)>| {
        if let Some((begin_m, end_m)) = part {
            let (low, high) = closed.unwrap_or((begin_m, end_m));
            closed = Some((low.min(begin_m), high.max(end_m)));
        }
    };
    let wide = Vector::new(radius_m, 0.0);
    let high = Vector::new(0.0, radius_m);
    join(within_box(corner - wide, far + wide, from, towards));
    join(within_box(corner - high, far + high, from, towards));
    for center in [corner, Point::new(far.x, corner.y), far, Point::new(corner.x, far.y)] {
        join(within_disc(center, radius_m, from, towards));
    }
    closed
}

fn within_box(low: Point, high: Point, from: Point, towards: Vector) -> Option<(f64, f64)> {
    let (mut begin, mut end) = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in 0..2 {
        if towards[axis].abs() < 1e-12 {
            if from[axis] <= low[axis] || from[axis] >= high[axis] {
                return None;
            }
        } else {
            let (one, other) =
                ((low[axis] - from[axis]) / towards[axis], (high[axis] - from[axis]) / towards[axis]);
            begin = begin.max(one.min(other));
            end = end.min(one.max(other));
        }
    }
    (begin < end).then_some((begin, end))
}

fn within_disc(center: Point, radius_m: f64, from: Point, towards: Vector) -> Option<(f64, f64)> {
    let middle = (center - from).dot(&towards);
    let aside = (center - from).perp(&towards);
    let half = (radius_m * radius_m - aside * aside).max(0.0).sqrt();
    (half > 0.0).then_some((middle - half, middle + half))
}

#[cfg(test)]
mod tests {
    use crate::{Instance, Mode, Start, configuration_space::ConfigurationSpace};
    use terrain::{Floor, GridMap, MotionModel, Point, Segment};

    const MOTION: MotionModel = MotionModel {
        speed_m_per_s: 0.5,
        acceleration_m_per_s2: f64::INFINITY,
        angular_speed_rad_per_s: 1.0,
        angular_acceleration_rad_per_s2: f64::INFINITY,
        brakes: true,
    };

    #[test]
    fn open_parts_are_free_and_what_lies_between_is_not() {
        let map =
            GridMap::from_drawing("............\n.....#......\n..........#.\n............", 0.25).unwrap();
        let floor = Floor::new(&map, 0.25, 0.2, 0.5).unwrap();
        let cell = floor.lattice().cells().find(|&cell| floor.cell_is_drivable(cell)).unwrap();
        let instance = Instance::whole_floor(&floor, vec![Start::at(cell)], MOTION, Mode::Cover);
        let space = ConfigurationSpace::new(&instance);
        let mut parts = 0;
        let number = |step: i32| f64::from(step) * 0.025;
        let slanting = (0..40).map(|step| [[0.0, number(step)], [3.0, 1.0 - number(step)]]);
        let flat = (0..40).map(|step| [[-0.3, number(step)], [3.2, number(step)]]);
        let steep = (0..120).map(|step| [[number(step), 1.1], [number(step), -0.1]]);
        for [from, to] in slanting.chain(flat).chain(steep) {
            let line = Segment::new(Point::from(from), Point::from(to));
            let at = |way_m: f64| line.from + (line.to - line.from) * (way_m / line.length());
            let open = space.slice(line);
            for &(from_m, to_m) in &open {
                parts += 1;
                assert!(floor.segment_is_free(Segment::new(at(from_m), at(to_m))), "{line:?}: {open:?}");
            }
            for sample in 0..600 {
                let way_m = line.length() * f64::from(sample) / 600.0;
                let inside = open.iter().any(|part| part.0 <= way_m && way_m <= part.1);
                assert!(inside || !map.disc_is_free(at(way_m), 0.2001), "{line:?} {way_m} {open:?}");
            }
        }
        assert!(parts > 100);
    }
}
