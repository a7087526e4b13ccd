//! Where the centre of the body may be, as a raster of places, and what the tool covers from there.
//!
//! ```text
//!   map squares ──▶ clearance of each place ──▶ free places ──▶ open steps ──▶ those that a robot reaches
//!                   (exact distance to the       ≥ radius,       body free      ──▶ ground within half a tool:
//!                    squares, not to centres)    not blocked     all along            coverable
//! ```
//!
//! The raster is the floor's lattice, refined by an odd number: the centre of each cell is a place, so what is joined
//! on the lattice is joined here, and each place lies in one cell, so blocked cells are blocked places. Distances to
//! squares of the map are exact, and a step between places is open only when the body's disc is free all along, by the
//! same test with which [`crate::verify()`] judges: nothing here is looser than that. On floors without a map the
//! centre may be anywhere in a drivable cell, and crosses to the next one by an open move.

mod blocked_cells;
mod clearance;
mod slices;
mod wall_runs;

use crate::Instance;
use blocked_cells::BlockedCells;
use clearance::clearances_m;
use terrain::{Cell, Direction, GridMap, Lattice, Point, Segment, Vector};
use wall_runs::WallRuns;

/// Column and row difference of the eight steps, anticlockwise from east; `opposite = step ^ 4`.
pub(crate) const STEPS: [(i32, i32); 8] =
    [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)];
/// As in [`terrain::Floor::segment_is_free`]: a wall that touches is no obstacle.
const TANGENT_M: f64 = 1e-6;
/// Clearances beyond the body's radius by more than this are not told apart, metres.
const FAR_M: f64 = 0.6;
/// Places across a tool, and across the body's radius, at least.
const PLACES_ACROSS: f64 = 5.0;
const PLACES_IN_RADIUS: f64 = 3.0;
/// With more places than this the raster is made coarser.
const PLACES_MAX: usize = 6_000_000;

/// The places of a floor. Row-major `Vec`s by place; a place's number is its index in [`Self::places`].
#[derive(Debug)]
pub(crate) struct ConfigurationSpace<'a> {
    instance: &'a Instance<'a>,
    places: Lattice,
    /// Odd number of places across a cell.
    fineness: u32,
    clearance_m: Vec<f32>,
    /// Per place, a bit for each open step.
    steps: Vec<u8>,
    reached: Vec<bool>,
    any_blocked: bool,
    blocked: BlockedCells,
    walls: Option<WallRuns>,
}

impl<'a> ConfigurationSpace<'a> {
    /// The places that robots of the instance reach from where they start. `instance` has its starts open (see
    /// [`Instance::with_open_starts`]).
    pub(crate) fn new(instance: &'a Instance<'a>) -> Self {
        let fineness = fineness(instance);
        let places = refined(instance.floor.lattice(), fineness);
        let clearance_m = clearances_m(instance.floor, &places, instance.floor.body_radius_m() + FAR_M);
        let any_blocked = instance.blocked.contains(&true);
        let mut space = Self {
            instance,
            places,
            fineness,
            clearance_m,
            steps: Vec::new(),
            reached: Vec::new(),
            any_blocked,
            blocked: BlockedCells::new(instance),
            walls: instance.floor.map().map(WallRuns::new),
        };
        space.steps = space.open_steps();
        let everybody: Vec<usize> = (0..instance.starts.len()).collect();
        space.reached = space.reached_from(&everybody);
        space
    }

    /// The same ground, with only those places reached that these robots reach.
    pub(crate) fn only(&self, robots: &[usize]) -> Self {
        let reached = self.reached_from(robots);
        Self {
            reached,
            clearance_m: self.clearance_m.clone(),
            steps: self.steps.clone(),
            walls: self.walls.clone(),
            blocked: self.blocked.clone(),
            ..*self
        }
    }

    /// The instance it was made for.
    pub(crate) fn instance(&self) -> &'a Instance<'a> {
        self.instance
    }

    /// The raster: its cells are the places.
    pub(crate) fn places(&self) -> &Lattice {
        &self.places
    }

    /// Where a place is.
    pub(crate) fn point(&self, place: usize) -> Point {
        self.places.center(self.places.cell(place))
    }

    /// Row-major number of the cell of the floor's lattice that a place lies in.
    pub(crate) fn cell_index(&self, place: usize) -> usize {
        let at = self.places.cell(place);
        let fineness = self.fineness as i32;
        let cell = Cell::new(at.x / fineness, at.y / fineness);
        self.instance.floor.lattice().index(cell).expect("the raster lies over the lattice")
    }

    /// The place in the middle of a cell.
    pub(crate) fn place_in_middle(&self, cell: Cell) -> Option<usize> {
        let (fineness, half) = (self.fineness as i32, self.fineness as i32 / 2);
        self.places.index(Cell::new(cell.x * fineness + half, cell.y * fineness + half))
    }

    /// Whether a robot reaches a place.
    pub(crate) fn is_reached(&self, place: usize) -> bool {
        self.reached[place]
    }

    /// Whether a robot reaches the place that a point lies in, or one beside it.
    pub(crate) fn is_reached_at(&self, point: Point) -> bool {
        let Some(cell) = self.places.cell_at(point) else { return false };
        let mut around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| Cell::new(cell.x + dx, cell.y + dy)));
        around.any(|cell| self.places.index(cell).is_some_and(|place| self.reached[place]))
    }

    /// Row-major: the places that robots reach.
    #[allow(dead_code, reason = "for planners with batteries")]
    pub(crate) fn reached(&self) -> &[bool] {
        &self.reached
    }

    /// Distance from a place to the nearest blocked square of the map, metres, where it is not far; infinite on floors
    /// without a map.
    pub(crate) fn clearance_m(&self, place: usize) -> f64 {
        f64::from(self.clearance_m[place])
    }

    /// The open steps of a place: number in [`STEPS`], and place beyond.
    pub(crate) fn steps(&self, place: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        let open = self.steps[place];
        (0..8).filter(move |step| open >> step & 1 == 1).map(move |step| (step, self.beyond(place, step)))
    }

    /// As [`Self::steps`], so many of them on end in the same direction.
    pub(crate) fn strides(&self, place: usize, stride: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        let open = self.steps[place];
        (0..8).filter(move |step| open >> step & 1 == 1).filter_map(move |step| {
            let mut at = self.beyond(place, step);
            for _ in 1..stride {
                if self.steps[at] >> step & 1 == 0 {
                    return None;
                }
                at = self.beyond(at, step);
            }
            Some((step, at))
        })
    }

    fn beyond(&self, place: usize, step: usize) -> usize {
        let (dx, dy) = STEPS[step];
        (place as isize + dy as isize * self.places.columns as isize + dx as isize) as usize
    }

    /// Whether the body can drive straight along a segment: never looser than what [`crate::verify()`] asks for.
    pub(crate) fn segment_is_free(&self, segment: Segment) -> bool {
        self.keeps_off_walls(segment) && self.keeps_to_open_cells(segment)
    }

    /// Goes along by as much as clearance allows, and looks closely only where walls are near.
    fn keeps_off_walls(&self, segment: Segment) -> bool {
        let Some(map) = self.instance.floor.map() else { return true };
        let (length_m, radius_m) = (segment.length(), self.instance.floor.body_radius_m());
        let piece_m = 2.0 * self.places.cell_m;
        let at = |way_m: f64| {
            if length_m == 0.0 {
                return segment.from;
            }
            segment.from + (segment.to - segment.from) * (way_m / length_m)
        };
        let mut way_m = 0.0;
        loop {
            let Some(clearance_m) = self.clearance_at_least_m(at(way_m)) else { return false };
            let spare_m = clearance_m - radius_m;
            if spare_m >= length_m - way_m {
                return true;
            }
            if spare_m > 0.5 * self.places.cell_m {
                way_m += spare_m;
                continue;
            }
            let end_m = (way_m + piece_m).min(length_m);
            if !piece_is_free(map, Segment::new(at(way_m), at(end_m)), radius_m - 0.5 * TANGENT_M) {
                return false;
            }
            if end_m >= length_m {
                return true;
            }
            way_m = end_m;
        }
    }

    /// A bound from below on the clearance of any point; `None` outside the raster.
    fn clearance_at_least_m(&self, point: Point) -> Option<f64> {
        let place = self.places.index(self.places.cell_at(point)?)?;
        Some(self.clearance_m(place) - (self.point(place) - point).norm() - TANGENT_M)
    }

    fn keeps_to_open_cells(&self, segment: Segment) -> bool {
        let (lattice, floor) = (self.instance.floor.lattice(), self.instance.floor);
        let ends_inside = lattice.cell_at(segment.from).is_some() && lattice.cell_at(segment.to).is_some();
        // On a line of the lattice but for rounding, the cells on either side may be meant.
        let rim = Vector::repeat(TANGENT_M);
        let low = Point::from(segment.from.coords.inf(&segment.to.coords)) - rim;
        let high = Point::from(segment.from.coords.sup(&segment.to.coords)) + rim;
        if floor.map().is_some() && !self.blocked.any_in_box(lattice, low, high) {
            return ends_inside;
        }
        let open = |&cell: &Cell| lattice.index(cell).is_some_and(|index| !self.instance.blocked[index]);
        ends_inside
            && lattice.cells_along(segment).iter().all(open)
            && (floor.map().is_some() || floor.segment_is_free(segment))
    }

    fn is_free(&self, place: usize, cell: usize) -> bool {
        let floor = self.instance.floor;
        let fits = match floor.map() {
            Some(_) => self.clearance_m(place) >= floor.body_radius_m() - 0.5 * TANGENT_M,
            None => floor.is_drivable(cell),
        };
        fits && !self.instance.blocked[cell]
    }

    /// Row-major: whether the body's centre may be at a place.
    fn free_places(&self) -> Vec<bool> {
        let (columns, fineness) = (self.places.columns as usize, self.fineness as usize);
        let cells_across = columns / fineness;
        let mut free = vec![false; self.places.len()];
        for (row, free) in free.chunks_exact_mut(columns).enumerate() {
            let first_cell = row / fineness * cells_across;
            for (cell, free) in free.chunks_exact_mut(fineness).enumerate() {
                for (column, free) in free.iter_mut().enumerate() {
                    let place = row * columns + cell * fineness + column;
                    *free = self.is_free(place, first_cell + cell);
                }
            }
        }
        free
    }

    fn open_steps(&self) -> Vec<u8> {
        let free = self.free_places();
        let mut steps = vec![0_u8; self.places.len()];
        let enough_m = [self.clear_for(0), self.clear_for(1)];
        // With so much clearance, and nothing blocked but by walls, the places around are free and the steps to them open.
        let all_m = (self.instance.floor.body_radius_m() + 1.5 * self.places.cell_m) as f32;
        let deep = |place: usize| {
            (all_m..f32::INFINITY).contains(&self.clearance_m[place]) && !self.is_near_blocked(place)
        };
        let (columns, rows) = (self.places.columns as i32, self.places.rows as i32);
        for (place, _) in free.iter().enumerate().filter(|(_, free)| **free) {
            if deep(place) {
                steps[place] = u8::MAX;
                continue;
            }
            let (x, y) = (place as i32 % columns, place as i32 / columns);
            for (step, (dx, dy)) in STEPS.into_iter().enumerate() {
                let (to_x, to_y) = (x + dx, y + dy);
                if to_x < 0 || to_x >= columns || to_y < 0 || to_y >= rows {
                    continue;
                }
                let beyond = self.beyond(place, step);
                let is_open = || match step {
                    _ if deep(beyond) => true,
                    0..4 => self.step_is_open(place, beyond, enough_m[step % 2]),
                    // Looked at from there before.
                    _ => steps[beyond] >> (step ^ 4) & 1 == 1,
                };
                if free[beyond] && is_open() {
                    steps[place] |= 1 << step;
                }
            }
        }
        steps
    }

    fn is_near_blocked(&self, place: usize) -> bool {
        let (point, step) = (self.point(place), Vector::repeat(self.places.cell_m));
        self.any_blocked && self.blocked.any_in_box(self.instance.floor.lattice(), point - step, point + step)
    }

    /// Between two places with so much clearance, a step apart, no point is nearer to a wall than the body's radius.
    fn clear_for(&self, step: usize) -> f32 {
        let (dx, dy) = STEPS[step];
        let half_m = f64::from(dx).hypot(f64::from(dy)) * self.places.cell_m / 2.0;
        self.instance.floor.body_radius_m().hypot(half_m) as f32 + 1e-6
    }

    fn step_is_open(&self, from: usize, to: usize, enough_m: f32) -> bool {
        let clear = self.clearance_m[from].min(self.clearance_m[to]) >= enough_m || {
            let segment = Segment::new(self.point(from), self.point(to));
            let (map, radius_m) = (self.instance.floor.map(), self.instance.floor.body_radius_m());
            map.is_none_or(|map| piece_is_free(map, segment, radius_m - 0.5 * TANGENT_M))
        };
        clear && self.crosses_openly(from, to)
    }

    /// Whether a step stays in its cell, or leads to the next one by an open move and past no blocked corner.
    fn crosses_openly(&self, from: usize, to: usize) -> bool {
        let (floor, lattice) = (self.instance.floor, self.instance.floor.lattice());
        if floor.map().is_some() && !self.any_blocked {
            return true;
        }
        let (one, other) = (self.cell_index(from), self.cell_index(to));
        if one == other {
            return true;
        }
        let (one, other) = (lattice.cell(one), lattice.cell(other));
        if let Some(way) = Direction::between(one, other) {
            return floor.map().is_some() || floor.can_move(one, way);
        }
        let sides = [Cell::new(one.x, other.y), Cell::new(other.x, one.y)];
        floor.map().is_some() && sides.iter().all(|&cell| self.cell_is_open(cell))
    }

    fn cell_is_open(&self, cell: Cell) -> bool {
        self.instance.floor.lattice().index(cell).is_some_and(|index| !self.instance.blocked[index])
    }

    fn reached_from(&self, robots: &[usize]) -> Vec<bool> {
        let mut reached = vec![false; self.places.len()];
        let mut stack: Vec<usize> = Vec::new();
        for &robot in robots {
            if let Some(place) = self.place_in_middle(self.instance.starts[robot].cell) {
                reached[place] = true;
                stack.push(place);
            }
        }
        while let Some(place) = stack.pop() {
            for (_, next) in self.steps(place) {
                if !reached[next] {
                    reached[next] = true;
                    stack.push(next);
                }
            }
        }
        reached
    }

    /// The nearest reached place with a free straight way from a point, within three places of it.
    pub(crate) fn nearest_place(&self, point: Point) -> Option<usize> {
        let is_good = |place: usize| self.segment_is_free(Segment::new(point, self.point(place)));
        let own = self.places.cell_at(point).and_then(|cell| self.places.index(cell));
        if let Some(own) = own.filter(|&own| self.reached[own] && is_good(own)) {
            return Some(own);
        }
        let reach_m = 3.0 * self.places.cell_m;
        let low = Point::new(point.x - reach_m, point.y - reach_m);
        let high = Point::new(point.x + reach_m, point.y + reach_m);
        let mut near: Vec<(f64, usize)> = self
            .places
            .cells_in_box(low, high)
            .filter_map(|cell| self.places.index(cell))
            .filter(|&place| self.reached[place])
            .map(|place| ((self.point(place) - point).norm(), place))
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near.into_iter().map(|(_, place)| place).find(|&place| is_good(place))
    }

    /// Row-major by place: whether the square around a place is free ground within `radius_m` of a reached place.
    /// With half a tool for the radius that is what can be covered.
    pub(crate) fn coverable(&self, radius_m: f64) -> Vec<bool> {
        let floor = self.instance.floor;
        let mut within = self.within(radius_m);
        for (place, within) in within.iter_mut().enumerate().filter(|(_, within)| **within) {
            *within = match floor.map() {
                Some(map) => map.point_is_free(self.point(place)),
                None => floor.is_drivable(self.cell_index(place)),
            };
        }
        within
    }

    /// Places within a distance of reached ones: a column of half-heights moved along the rows.
    fn within(&self, radius_m: f64) -> Vec<bool> {
        let (columns, rows) = (self.places.columns as usize, self.places.rows as usize);
        let reach = (radius_m / self.places.cell_m + 1e-9).floor() as i64;
        let half_width = |dy: i64| {
            let height_m = dy as f64 * self.places.cell_m;
            ((radius_m * radius_m - height_m * height_m).max(0.0).sqrt() / self.places.cell_m + 1e-9) as usize
        };
        let mut within = vec![false; self.places.len()];
        let mut changes = vec![0_i32; columns + 1];
        for row in 0..rows as i64 {
            changes.fill(0);
            for dy in -reach..=reach {
                let from = row + dy;
                if from < 0 || from >= rows as i64 {
                    continue;
                }
                let half = half_width(dy);
                let reached = &self.reached[from as usize * columns..(from as usize + 1) * columns];
                for (begin, end) in runs(reached) {
                    changes[begin.saturating_sub(half)] += 1;
                    changes[(end + half).min(columns)] -= 1;
                }
            }
            let mut depth = 0;
            for column in 0..columns {
                depth += changes[column];
                within[row as usize * columns + column] = depth > 0;
            }
        }
        within
    }
}

/// As [`GridMap::capsule_is_free`], for short segments: squares that the middle of the segment tells enough about are not
/// looked at closely.
fn piece_is_free(map: &GridMap, segment: Segment, radius_m: f64) -> bool {
    let square_m = map.resolution_m();
    let middle = nalgebra::center(&segment.from, &segment.to) - map.origin();
    let far_m = radius_m + segment.length() / 2.0;
    let index = |metres: f64| (metres / square_m).floor() as i64;
    for y in index(middle.y - far_m)..=index(middle.y + far_m) {
        let low_m = y as f64 * square_m;
        let aside_m = (low_m - middle.y).max(middle.y - low_m - square_m).max(0.0);
        let (first, last) = (index(middle.x - far_m), index(middle.x + far_m));
        if map.row_is_free(y, first, last) {
            continue;
        }
        for x in first..=last {
            if map.is_free(x, y) {
                continue;
            }
            let left_m = x as f64 * square_m;
            let along_m = (left_m - middle.x).max(middle.x - left_m - square_m).max(0.0);
            let apart2 = aside_m * aside_m + along_m * along_m;
            if apart2 >= far_m * far_m {
                continue;
            }
            if apart2 < (radius_m - 1e-9).powi(2) {
                return false;
            }
            let corner = map.origin() + Vector::new(left_m, low_m);
            if slices::touches(corner, square_m, segment, radius_m) {
                return false;
            }
        }
    }
    true
}

/// Begin and end (exclusive) of the runs of `true`.
pub(crate) fn runs(marks: &[bool]) -> impl Iterator<Item = (usize, usize)> + '_ {
    let mut at = 0;
    std::iter::from_fn(move || {
        let begin = at + marks[at..].iter().position(|&mark| mark)?;
        let end = marks[begin..].iter().position(|&mark| !mark).map_or(marks.len(), |length| begin + length);
        at = end;
        Some((begin, end))
    })
}

/// The least odd number of places across a cell that is fine enough for the map and the tool.
fn fineness(instance: &Instance<'_>) -> u32 {
    let lattice = instance.floor.lattice();
    let map_m = instance.floor.map().map_or(f64::INFINITY, GridMap::resolution_m);
    let body_m = instance.floor.body_radius_m() / PLACES_IN_RADIUS;
    let wanted_m = map_m.min(instance.floor.tool_width_m() / PLACES_ACROSS).min(body_m).max(1e-3);
    let affordable = ((PLACES_MAX as f64 / lattice.len() as f64).sqrt() as u32).max(1);
    let wanted = ((lattice.cell_m / wanted_m - 1e-6).ceil() as u32).clamp(1, affordable);
    if wanted % 2 == 1 {
        wanted
    } else if wanted < affordable {
        wanted + 1
    } else {
        wanted - 1
    }
}

fn refined(lattice: &Lattice, fineness: u32) -> Lattice {
    Lattice {
        origin: lattice.origin,
        cell_m: lattice.cell_m / f64::from(fineness),
        columns: lattice.columns * fineness,
        rows: lattice.rows * fineness,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Mode, Start};
    use proptest::prelude::*;
    use terrain::{Floor, GridMap, MotionModel, Passages};

    const MOTION: MotionModel = MotionModel {
        speed_m_per_s: 0.5,
        acceleration_m_per_s2: f64::INFINITY,
        angular_speed_rad_per_s: 1.0,
        angular_acceleration_rad_per_s2: f64::INFINITY,
        brakes: true,
    };

    const ROOM: &str = "............
                        .....#......
                        .....#......
                        ............
                        ....####....
                        ............";

    fn with_space(cell_m: f64, check: impl FnOnce(&ConfigurationSpace<'_>)) {
        let map = GridMap::from_drawing(ROOM, 0.25).unwrap();
        let floor = Floor::new(&map, cell_m, 0.2, 0.5).unwrap();
        let cell = floor.lattice().cells().find(|&cell| floor.cell_is_drivable(cell)).unwrap();
        let mut instance = Instance::whole_floor(&floor, vec![Start::at(cell)], MOTION, Mode::Cover);
        let last = instance.blocked.len() - 1;
        instance.blocked[last] = true;
        check(&ConfigurationSpace::new(&instance));
    }

    proptest! {
        /// Two searches that share no code: whoever gets somewhere here also does over moves and passages.
        #[test]
        fn moves_and_passages_lead_wherever_the_body_gets(
            free in prop::collection::vec(prop::bool::weighted(0.93), 24 * 20),
            slant in -3_i32..4,
            radius_m in 0.15_f64..0.45,
            start in any::<prop::sample::Index>(),
        ) {
            // A slanted wall with a gap, and specks.
            let is_free = |(number, free): (usize, &bool)| {
                let (x, y) = (number as i32 % 24, number as i32 / 24);
                let on_wall = (4 * (x - 12) - slant * (y - 10)).abs() < 4 && !(8..12).contains(&y);
                *free && !on_wall
            };
            let squares = free.iter().enumerate().map(is_free).collect();
            let map = GridMap::new(24, 20, 0.25, Point::origin(), squares).unwrap();
            let Ok(floor) = Floor::new(&map, 0.5, radius_m, 0.7) else { return Ok(()) };
            let cells: Vec<Cell> = floor.lattice().cells().filter(|&cell| floor.cell_is_drivable(cell)).collect();
            let start = *start.get(&cells);
            let instance = Instance::whole_floor(&floor, vec![Start::at(start)], MOTION, Mode::Cover);
            let space = ConfigurationSpace::new(&instance);
            let reached = Passages::new(&floor).reached(&floor, [start], |_| true);
            for cell in cells {
                let is_reached_here = space.place_in_middle(cell).is_some_and(|place| space.is_reached(place));
                let index = floor.lattice().index(cell).unwrap();
                prop_assert!(reached[index] || !is_reached_here, "{} from {}", cell, start);
            }
        }
    }

    #[test]
    fn a_place_is_free_just_when_the_disc_is() {
        with_space(0.25, |space| {
            let floor = space.instance().floor;
            let map = floor.map().unwrap();
            for place in 0..space.places().len() {
                let disc = map.disc_is_free(space.point(place), floor.body_radius_m() - TANGENT_M);
                let blocked = space.instance().blocked[space.cell_index(place)];
                assert_eq!(space.free_places()[place], disc && !blocked, "{}", space.point(place));
            }
        });
    }

    #[test]
    fn every_open_step_stands_the_test_of_verify() {
        for cell_m in [0.25, 0.4, 0.6] {
            with_space(cell_m, |space| {
                let steps =
                    (0..space.places().len()).flat_map(|place| space.steps(place).map(move |s| (place, s.1)));
                for (from, to) in steps {
                    let segment = Segment::new(space.point(from), space.point(to));
                    assert!(space.instance().floor.segment_is_free(segment), "{segment:?}");
                    assert!(space.segment_is_free(segment), "{segment:?}");
                }
            });
        }
    }

    #[test]
    fn what_is_joined_on_the_lattice_is_joined_here() {
        with_space(0.3, |space| {
            let reachable = space.instance().reachable();
            for cell in space.instance().floor.lattice().cells() {
                let index = space.instance().floor.lattice().index(cell).unwrap();
                let place = space.place_in_middle(cell).unwrap();
                assert!(!reachable[index] || space.is_reached(place), "{cell}");
            }
        });
    }

    #[test]
    fn a_free_segment_is_free_for_verify_and_almost_the_other_way_round() {
        with_space(0.25, |space| {
            let (mut said, mut truth) = (0, 0);
            let free = space.free_places();
            for from in (0..space.places().len()).step_by(5).filter(|&place| free[place]) {
                for to in (0..space.places().len()).step_by(7).filter(|&place| free[place]) {
                    let segment = Segment::new(space.point(from), space.point(to));
                    let free = space.instance().floor.segment_is_free(segment);
                    assert!(free || !space.segment_is_free(segment), "{segment:?}");
                    said += u32::from(space.segment_is_free(segment));
                    truth += u32::from(free);
                }
            }
            assert!(said > 100 && f64::from(said) > 0.95 * f64::from(truth), "{said} of {truth}");
        });
    }
}
