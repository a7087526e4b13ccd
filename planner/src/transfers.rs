//! Shortest ways for the body between points, around walls and blocked cells.
//!
//! ```text
//!   point ─▶ nearest place ═▶ open steps (8 directions) ═▶ nearest place ─▶ point      then pulled tight
//! ```
//!
//! A search grows from one place over the open steps until what is asked for has been reached, so that its cost depends
//! on how far that is and not on the size of the floor. It goes in strides of a few steps in the same direction, and step by
//! step only where that does not get there: through passages as narrow as the body. What it finds is pulled tight: points are left out wherever the
//! straight line between others is free. A [`Way`] holds the very points that are driven, and is priced by them: no
//! price is paid for one way and another one driven.

use crate::{
    Instance,
    configuration_space::{ConfigurationSpace, STEPS},
};
use std::collections::{BTreeMap, BTreeSet};
use terrain::{Cell, Point, Segment, Vector, angle_between};

/// Cost of a straight and of a slanting step.
const STRAIGHT: u32 = 10;
const SLANTING: u32 = 14;
/// Most places to a step of a search.
const STRIDE_MAX: usize = 3;
/// A step is no longer than this share of a tool.
const STRIDE_TOOLS: f64 = 0.25;
/// A way over eight directions is longer than the shortest by no more than this.
const EIGHT_DIRECTIONS: f64 = 1.0824;
/// Buckets of a queue of costs that differ by at most a slanting step and what an estimate of the rest grows by with it.
const BUCKETS: usize = 2 * STRIDE_MAX * SLANTING as usize + 1;
const UNSEEN: u32 = u32::MAX;
/// The step that leads nowhere: where a search began.
const ROOT: u8 = 8;

/// A line of points that the body can drive.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Way {
    /// At least one; straight lines between them.
    pub(crate) points: Vec<Point>,
    /// Length, metres.
    pub(crate) length_m: f64,
    /// Time from standstill to standstill with the turns between, seconds.
    pub(crate) inner_s: f64,
    /// Headings with which it begins and ends, radians; `None` for a way without length.
    pub(crate) headings_rad: Option<(f64, f64)>,
}

impl Way {
    /// Along these points.
    pub(crate) fn new(instance: &Instance<'_>, mut points: Vec<Point>) -> Self {
        points.dedup_by(|a, b| (*a - *b).norm() < 1e-7);
        let length_m = points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
        let inner_s = instance.motion.path_s(&points, None);
        let headings_rad = match points.len() {
            0 | 1 => None,
            last => {
                Some((heading_rad(points[0], points[1]), heading_rad(points[last - 2], points[last - 1])))
            }
        };
        Self { points, length_m, inner_s, headings_rad }
    }

    /// Time with the turns at both ends, for a robot that comes with one heading and goes on with another, seconds.
    pub(crate) fn time_s(
        &self,
        instance: &Instance<'_>,
        before_rad: Option<f64>,
        after_rad: Option<f64>,
    ) -> f64 {
        let turn_s = |from: Option<f64>, to: Option<f64>| match (from, to) {
            (Some(from), Some(to)) => instance.motion.turn_s(angle_between(from, to)),
            _ => 0.0,
        };
        match self.headings_rad {
            Some((first, last)) => {
                self.inner_s + turn_s(before_rad, Some(first)) + turn_s(Some(last), after_rad)
            }
            None => turn_s(before_rad, after_rad),
        }
    }

    /// The same way back.
    pub(crate) fn reversed(&self) -> Self {
        let back = |heading: f64| angle_between(0.0, heading + std::f64::consts::PI);
        Self {
            points: self.points.iter().rev().copied().collect(),
            headings_rad: self.headings_rad.map(|(first, last)| (back(last), back(first))),
            ..*self
        }
    }
}

/// Heading from one point to another, radians.
pub(crate) fn heading_rad(from: Point, to: Point) -> f64 {
    let way: Vector = to - from;
    way.y.atan2(way.x)
}

/// Finds ways, one search after another, without clearing its tables in between.
#[derive(Debug)]
pub(crate) struct Transfers<'s, 'a> {
    space: &'s ConfigurationSpace<'a>,
    /// Per place: number of the search that saw it last, cost, and the step by which it was entered.
    seen: Vec<(u32, u32)>,
    entered_by: Vec<u8>,
    search: u32,
    /// Steps to a stride of the last search, and of those to come.
    stride: usize,
    longest: usize,
    buckets: Vec<Vec<u32>>,
}

impl<'s, 'a> Transfers<'s, 'a> {
    pub(crate) fn new(space: &'s ConfigurationSpace<'a>) -> Self {
        let places = space.places().len();
        Self {
            space,
            seen: vec![(0, UNSEEN); places],
            entered_by: vec![ROOT; places],
            search: 0,
            stride: 1,
            longest: longest_stride(space),
            buckets: vec![Vec::new(); BUCKETS],
        }
    }

    /// The space it searches.
    pub(crate) fn space(&self) -> &'s ConfigurationSpace<'a> {
        self.space
    }

    /// The way from one point to another: straight where that is free, else around; `None` where there is none.
    pub(crate) fn way(&mut self, from: Point, to: Point) -> Option<Way> {
        self.way_within(from, to, f64::INFINITY)
    }

    /// As [`Self::way`]; `None` also where it is clearly longer than `limit_m`.
    pub(crate) fn way_within(&mut self, from: Point, to: Point, limit_m: f64) -> Option<Way> {
        let instance = self.space.instance();
        if self.space.segment_is_free(Segment::new(from, to)) {
            return Some(Way::new(instance, vec![from, to]));
        }
        let (source, target) = (self.space.nearest_place(from)?, self.space.nearest_place(to)?);
        let limit = cost(self.space, EIGHT_DIRECTIONS * limit_m)
            .saturating_add(2 * STRIDE_MAX as u32 * SLANTING)
            .min(UNSEEN / 2);
        let strides = self.strides();
        let points =
            strides.into_iter().find_map(|stride| self.search_way(source, target, to, stride, limit))?;
        Some(self.tight(from, points, to))
    }

    /// Long strides first; single steps get everywhere.
    fn strides(&self) -> Vec<usize> {
        if self.longest > 1 { vec![self.longest, 1] } else { vec![1] }
    }

    fn search_way(
        &mut self,
        source: usize,
        target: usize,
        to: Point,
        stride: usize,
        limit: u32,
    ) -> Option<Vec<Point>> {
        let space = self.space;
        let rest = rest_to(space, target);
        let near = SLANTING * (stride as u32 - 1);
        let mut end = None;
        self.grow(source, stride, &rest, |place, cost| {
            if cost + rest(place) > limit {
                return true;
            }
            let there = place == target
                || rest(place) <= near && space.segment_is_free(Segment::new(space.point(place), to));
            end = there.then_some(place);
            there
        });
        self.trace(end?)
    }

    /// The ways from a point to those of `targets` that are `wanted` and at most `limit_m` of steps away; at most `most` of
    /// them, the nearest first, as far as strides tell.
    pub(crate) fn ways_to_nearest(
        &mut self,
        from: Point,
        targets: &Targets,
        wanted: impl Fn(usize) -> bool,
        limit_m: f64,
        most: usize,
    ) -> Vec<(usize, Way)> {
        let found = self.nearest(from, targets, wanted, limit_m, most);
        found.into_iter().filter_map(|near| Some((near.target, self.way_to(from, targets, near)?))).collect()
    }

    /// As [`Self::ways_to_nearest`], without the ways.
    pub(crate) fn nearest(
        &mut self,
        from: Point,
        targets: &Targets,
        wanted: impl Fn(usize) -> bool,
        limit_m: f64,
        most: usize,
    ) -> Vec<Near> {
        let Some(source) = self.space.nearest_place(from) else { return Vec::new() };
        let (space, limit) = (self.space, cost(self.space, limit_m));
        let mut found: Vec<Near> = Vec::new();
        for stride in self.strides() {
            found.clear();
            let mut seen = BTreeSet::new();
            self.grow(
                source,
                stride,
                |_| 0,
                |place, cost| {
                    if cost > limit {
                        return true;
                    }
                    for target in targets.around(space, place, stride) {
                        let way = || Segment::new(space.point(place), targets.points[target]);
                        let is_there = |target: usize| targets.places[target] == Some(place);
                        if !seen.contains(&target)
                            && wanted(target)
                            && (is_there(target) || space.segment_is_free(way()))
                        {
                            seen.insert(target);
                            found.push(Near { target, place, at_least_m: at_least_m(space, cost, stride) });
                        }
                    }
                    found.len() >= most
                },
            );
            if found.len() >= most {
                break;
            }
        }
        found.truncate(most);
        found
    }

    /// The way to a target that the last search found.
    fn way_to(&self, from: Point, targets: &Targets, near: Near) -> Option<Way> {
        let to = targets.points[near.target];
        if self.space.segment_is_free(Segment::new(from, to)) {
            return Some(Way::new(self.space.instance(), vec![from, to]));
        }
        Some(self.tight(from, self.trace(near.place)?, to))
    }

    #[allow(dead_code, reason = "for planners with batteries")]
    /// How far each place is from the nearest of some sources, each with metres that are counted before it.
    pub(crate) fn field(&mut self, sources: &[(Point, f64)]) -> Field {
        let places = self.space.places().len();
        let mut order: Vec<(u32, usize, usize)> = sources
            .iter()
            .enumerate()
            .filter_map(|(source, &(point, before_m))| {
                Some((cost(self.space, before_m), self.space.nearest_place(point)?, source))
            })
            .collect();
        order.sort_unstable();
        let mut field = Field {
            cost: vec![UNSEEN; places],
            entered_by: vec![ROOT; places],
            source: vec![u32::MAX; places],
            unit_m: self.space.places().cell_m / f64::from(STRAIGHT),
        };
        let mut waiting = order.into_iter().peekable();
        let mut buckets: Vec<Vec<u32>> = vec![Vec::new(); BUCKETS];
        let mut queued = 0_usize;
        let mut now = waiting.peek().map_or(0, |&(cost, ..)| cost);
        while queued > 0 || waiting.peek().is_some() {
            if let (0, Some(&(next, ..))) = (queued, waiting.peek()) {
                now = now.max(next);
            }
            while let Some((before, place, source)) = waiting.next_if(|&(cost, ..)| cost <= now) {
                if before.max(now) < field.cost[place] {
                    field.cost[place] = now;
                    field.entered_by[place] = ROOT;
                    field.source[place] = source as u32;
                    buckets[now as usize % BUCKETS].push(place as u32);
                    queued += 1;
                }
            }
            while let Some(place) = buckets[now as usize % BUCKETS].pop() {
                queued -= 1;
                let place = place as usize;
                if field.cost[place] != now {
                    continue;
                }
                for (step, next) in self.space.steps(place) {
                    let cost = now + step_cost(step);
                    if cost < field.cost[next] {
                        field.cost[next] = cost;
                        field.entered_by[next] = step as u8;
                        field.source[next] = field.source[place];
                        buckets[cost as usize % BUCKETS].push(next as u32);
                        queued += 1;
                    }
                }
            }
            now += 1;
        }
        field
    }

    #[allow(dead_code, reason = "for planners with batteries")]
    /// The way that a field leads along, from a point to the nearest source; the source's number with it.
    pub(crate) fn way_to_source(
        &self,
        field: &Field,
        sources: &[(Point, f64)],
        from: Point,
    ) -> Option<(usize, Way)> {
        let mut place = self.space.nearest_place(from)?;
        let source = *sources.get(field.source[place] as usize)?;
        let number = field.source[place] as usize;
        let mut points = vec![self.space.point(place)];
        while field.entered_by[place] != ROOT {
            place = before(self.space, place, field.entered_by[place]);
            points.push(self.space.point(place));
        }
        Some((number, self.tight(from, points, source.0)))
    }

    /// Grows over open steps from a place, `stride` of them at a time, least cost with `rest(place)` first, until
    /// `stop(place, cost)` says so.
    fn grow(
        &mut self,
        source: usize,
        stride: usize,
        rest: impl Fn(usize) -> u32,
        mut stop: impl FnMut(usize, u32) -> bool,
    ) {
        self.search += 1;
        self.stride = stride;
        self.buckets.iter_mut().for_each(Vec::clear);
        self.seen[source] = (self.search, 0);
        self.entered_by[source] = ROOT;
        let mut now = rest(source);
        self.buckets[now as usize % BUCKETS].push(source as u32);
        let mut queued = 1_usize;
        while queued > 0 {
            while let Some(place) = self.buckets[now as usize % BUCKETS].pop() {
                queued -= 1;
                let place = place as usize;
                let so_far = self.seen[place].1;
                if so_far + rest(place) != now {
                    continue;
                }
                if stop(place, so_far) {
                    return;
                }
                for (step, next) in self.space.strides(place, stride) {
                    let cost = so_far + stride as u32 * step_cost(step);
                    let (search, known) = self.seen[next];
                    if search != self.search || cost < known {
                        self.seen[next] = (self.search, cost);
                        self.entered_by[next] = step as u8;
                        self.buckets[(cost + rest(next)) as usize % BUCKETS].push(next as u32);
                        queued += 1;
                    }
                }
            }
            now += 1;
        }
    }

    /// The places from the source of the last search to one that it has seen.
    fn trace(&self, target: usize) -> Option<Vec<Point>> {
        if self.seen[target].0 != self.search {
            return None;
        }
        let mut place = target;
        let mut points = vec![self.space.point(place)];
        while self.entered_by[place] != ROOT {
            let step = self.entered_by[place];
            for _ in 0..self.stride {
                place = before(self.space, place, step);
            }
            points.push(self.space.point(place));
        }
        points.reverse();
        Some(points)
    }

    fn tight(&self, from: Point, between: Vec<Point>, to: Point) -> Way {
        let mut points = vec![from];
        points.extend(between);
        points.push(to);
        Way::new(self.space.instance(), pulled_tight(self.space, &points))
    }
}

/// A target that a search has found, and from where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Near {
    pub(crate) target: usize,
    /// As a rule, no way there is shorter.
    pub(crate) at_least_m: f64,
    place: usize,
}

/// Points that searches look for.
#[derive(Debug)]
pub(crate) struct Targets {
    points: Vec<Point>,
    places: Vec<Option<usize>>,
    /// By place: the targets there.
    at: BTreeMap<usize, Vec<usize>>,
    /// By place: whether a target is less than a stride away.
    is_near: Vec<bool>,
}

impl Targets {
    pub(crate) fn new(space: &ConfigurationSpace<'_>, points: Vec<Point>) -> Self {
        let mut targets = Self {
            points: Vec::new(),
            places: Vec::new(),
            at: BTreeMap::new(),
            is_near: vec![false; space.places().len()],
        };
        for point in points {
            targets.push(space, point);
        }
        targets
    }

    /// One more, with the next number.
    pub(crate) fn push(&mut self, space: &ConfigurationSpace<'_>, point: Point) {
        let place = space.nearest_place(point);
        if let Some(place) = place {
            self.at.entry(place).or_default().push(self.points.len());
            for near in block(space, place, longest_stride(space)) {
                self.is_near[near] = true;
            }
        }
        self.points.push(point);
        self.places.push(place);
    }

    /// Those that are less than a stride from a place along both axes.
    fn around(&self, space: &ConfigurationSpace<'_>, place: usize, stride: usize) -> Vec<usize> {
        if !self.is_near[place] {
            return Vec::new();
        }
        block(space, place, stride).filter_map(|near| self.at.get(&near)).flatten().copied().collect()
    }
}

/// How long a way is at least, as a rule, that took a search so much to come within a stride of its end.
fn at_least_m(space: &ConfigurationSpace<'_>, cost: u32, stride: usize) -> f64 {
    let step_m = space.places().cell_m;
    let steps = f64::from(cost) / f64::from(STRAIGHT) / EIGHT_DIRECTIONS;
    ((steps - 2.0 * stride as f64) * step_m).max(0.0)
}

fn longest_stride(space: &ConfigurationSpace<'_>) -> usize {
    let tool_m = space.instance().floor.tool_width_m();
    ((STRIDE_TOOLS * tool_m / space.places().cell_m + 1e-6) as usize).clamp(1, STRIDE_MAX)
}

/// The places less than a stride from one along both axes.
fn block(space: &ConfigurationSpace<'_>, place: usize, stride: usize) -> impl Iterator<Item = usize> + use<> {
    let (lattice, reach) = (*space.places(), stride as i32 - 1);
    let at = lattice.cell(place);
    (-reach..=reach)
        .flat_map(move |dy| (-reach..=reach).map(move |dx| Cell::new(at.x + dx, at.y + dy)))
        .filter_map(move |cell| lattice.index(cell))
}

/// Distances of all places from the nearest of some sources.
#[allow(dead_code, reason = "for planners with batteries")]
#[derive(Debug, Clone)]
pub(crate) struct Field {
    cost: Vec<u32>,
    entered_by: Vec<u8>,
    source: Vec<u32>,
    unit_m: f64,
}

#[allow(dead_code, reason = "for planners with batteries")]
impl Field {
    /// Metres of steps from the nearest source to a place, what is counted before it included: never less than the way
    /// is long. `None` where no source is reached.
    pub(crate) fn distance_m(&self, place: usize) -> Option<f64> {
        (self.cost[place] != UNSEEN).then(|| f64::from(self.cost[place]) * self.unit_m * SLACK)
    }

    /// Number of the nearest source.
    pub(crate) fn source(&self, place: usize) -> Option<usize> {
        (self.source[place] != u32::MAX).then_some(self.source[place] as usize)
    }
}

/// A slanting step is counted as 1.4 straight ones: this much too short at most.
#[allow(dead_code, reason = "for planners with batteries")]
const SLACK: f64 = std::f64::consts::SQRT_2 / 1.4;

/// For each place, the cost to a target if nothing were in the way.
fn rest_to(space: &ConfigurationSpace<'_>, target: usize) -> impl Fn(usize) -> u32 {
    let columns = space.places().columns as usize;
    let (x, y) = (target % columns, target / columns);
    move |place| {
        let (dx, dy) = ((place % columns).abs_diff(x) as u32, (place / columns).abs_diff(y) as u32);
        STRAIGHT * dx.max(dy) + (SLANTING - STRAIGHT) * dx.min(dy)
    }
}

fn step_cost(step: usize) -> u32 {
    if step.is_multiple_of(2) { STRAIGHT } else { SLANTING }
}

fn cost(space: &ConfigurationSpace<'_>, length_m: f64) -> u32 {
    (length_m / space.places().cell_m * f64::from(STRAIGHT)).clamp(0.0, 4e9) as u32
}

fn before(space: &ConfigurationSpace<'_>, place: usize, entered_by: u8) -> usize {
    let (dx, dy) = STEPS[entered_by as usize];
    (place as isize - dy as isize * space.places().columns as isize - dx as isize) as usize
}

/// Leaves out points between which the straight line is free: as far ahead as it is, first from the one end and then, over
/// what is left with points put in between, from the other.
fn pulled_tight(space: &ConfigurationSpace<'_>, points: &[Point]) -> Vec<Point> {
    let forward = farthest_seen(space, points);
    if forward.len() <= 2 {
        return forward;
    }
    let mut finer = with_points_between(&forward, 4.0 * space.places().cell_m);
    finer.reverse();
    let mut tight = farthest_seen(space, &finer);
    tight.reverse();
    tight
}

fn farthest_seen(space: &ConfigurationSpace<'_>, points: &[Point]) -> Vec<Point> {
    let mut kept = vec![points[0]];
    let mut at = 0;
    while at + 1 < points.len() {
        let free = |to: usize| space.segment_is_free(Segment::new(points[at], points[to]));
        let next = last_free(at + 1, points.len() - 1, free);
        kept.push(points[next]);
        at = next;
    }
    kept
}

/// The last of `first..=last` that is free, as far as doubling steps and halving find it; `first` always is.
fn last_free(first: usize, last: usize, free: impl Fn(usize) -> bool) -> usize {
    if free(last) {
        return last;
    }
    let (mut good, mut bad, mut stride) = (first, last, 1);
    while good + stride < bad {
        if free(good + stride) {
            good += stride;
            stride *= 2;
        } else {
            bad = good + stride;
        }
    }
    while bad - good > 1 {
        let middle = usize::midpoint(good, bad);
        if free(middle) { good = middle } else { bad = middle }
    }
    good
}

fn with_points_between(points: &[Point], apart_m: f64) -> Vec<Point> {
    let mut finer = vec![points[0]];
    for pair in points.windows(2) {
        let pieces = ((pair[1] - pair[0]).norm() / apart_m).ceil().max(1.0);
        let at = |piece: u32| pair[0] + (pair[1] - pair[0]) * (f64::from(piece) / pieces);
        finer.extend((1..=pieces as u32).map(at));
    }
    finer
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Mode, Start};
    use terrain::{Floor, GridMap, MotionModel};

    const MOTION: MotionModel = MotionModel {
        speed_m_per_s: 0.5,
        acceleration_m_per_s2: f64::INFINITY,
        angular_speed_rad_per_s: 1.0,
        angular_acceleration_rad_per_s2: f64::INFINITY,
        brakes: true,
    };

    const ROOM: &str = "....................
                        ....................
                        ......########......
                        ......########......
                        ....................
                        ....................";

    fn with_transfers(check: impl FnOnce(&mut Transfers<'_, '_>)) {
        let map = GridMap::from_drawing(ROOM, 0.25).unwrap();
        let floor = Floor::new(&map, 0.25, 0.2, 0.5).unwrap();
        let cell = floor.lattice().cells().find(|&cell| floor.cell_is_drivable(cell)).unwrap();
        let instance = Instance::whole_floor(&floor, vec![Start::at(cell)], MOTION, Mode::Cover);
        let space = ConfigurationSpace::new(&instance);
        check(&mut Transfers::new(&space));
    }

    #[test]
    fn a_way_around_a_block_is_free_tight_and_priced_as_driven() {
        with_transfers(|transfers| {
            let (from, to) = (Point::new(2.5, 0.25), Point::new(2.5, 1.25));
            let way = transfers.way(from, to).unwrap();
            let floor = transfers.space().instance().floor;
            for pair in way.points.windows(2) {
                assert!(floor.segment_is_free(Segment::new(pair[0], pair[1])), "{pair:?}");
            }
            assert_eq!((way.points[0], *way.points.last().unwrap()), (from, to));
            // Around the left or the right end: out, along the side with round corners, and back in.
            assert!(way.length_m > 2.9 && way.length_m < 3.6, "{way:?}");
            assert!(way.points.len() <= 8, "{way:?}");
            let driven_s = MOTION.path_s(&way.points, None);
            assert!((way.time_s(transfers.space().instance(), None, None) - driven_s).abs() < 1e-9);
            assert_eq!(way.reversed().reversed().points, way.points);
        });
    }

    #[test]
    fn the_nearest_targets_come_first_and_no_more_than_asked_for() {
        with_transfers(|transfers| {
            let points = vec![Point::new(4.5, 0.25), Point::new(1.0, 0.25), Point::new(0.4, 1.25)];
            let targets = Targets::new(transfers.space(), points);
            let found = transfers.ways_to_nearest(Point::new(0.4, 0.25), &targets, |_| true, 2.0, 5);
            assert_eq!(found.iter().map(|(target, _)| *target).collect::<Vec<_>>(), [1, 2]);
            assert_eq!(transfers.ways_to_nearest(Point::new(0.4, 0.25), &targets, |_| true, 9.0, 1).len(), 1);
        });
    }

    #[test]
    fn a_field_leads_to_the_source_that_is_nearest_with_what_counts_before_it() {
        with_transfers(|transfers| {
            let sources = [(Point::new(0.4, 0.25), 0.0), (Point::new(4.6, 0.25), 3.0)];
            let field = transfers.field(&sources);
            for (x, number) in [(0.5, 0), (2.5, 0), (3.5, 0), (4.4, 1)] {
                let place = transfers.space().nearest_place(Point::new(x, 0.25)).unwrap();
                assert_eq!(field.source(place), Some(number), "{x}");
                let (found, way) =
                    transfers.way_to_source(&field, &sources, transfers.space().point(place)).unwrap();
                assert_eq!(found, number);
                let bound_m = field.distance_m(place).unwrap() - sources[number].1;
                assert!(
                    way.length_m <= bound_m + 0.3 && bound_m <= 1.1 * way.length_m + 0.3,
                    "{x} {bound_m}"
                );
            }
        });
    }
}
