//! Repair of lines: keep what robots sweep off the lattice, deal out what has no driver, and no planning afresh.
//!
//! ```text
//!   incumbent  ══════╗ ───── ╔══════      kept: stretches that sweep something wanted and are free
//!              done   ╚══════╝  way       dropped: what is swept already, and the ways between
//!   orphan     ══╪══════╪════             cut into pieces, each put where the last robot ends least later
//! ```
//!
//! **Problem**: robots are driving lines; one is lost, ground is blocked or free again, a robot came back. A first
//! order is wanted at once, while planning afresh takes seconds. **Idea**: each robot keeps its own stretches in
//! their order. What sweeps nothing that is still wanted is dropped. Stretches without a driver are cut into pieces no
//! longer than a share of the whole, and inserted one by one, forwards or backwards, where the makespan grows least:
//! distances choose a few candidates, true ways for the body decide between them. Then the robot that ends last gives
//! ends of its route away, as long as that helps. Ground that no line sweeps any more gets lines of its own, cell row
//! by cell row.
//!
//! **Guarantee**: none but [`crate::verify()`]'s; where a stretch cannot be reached by anybody there is no answer.
//! **Complexity**: O(p s) for p pieces and s stretches, and at most [`CANDIDATES`] + 2 ways for each piece; rastering
//! what the lines sweep dominates. **Paper**: ours; insertion by least added cost is that of Rosenkrantz, Stearns and
//! Lewis, "An analysis of several heuristics for the traveling salesman problem", 1977.

use crate::{Instance, Mode, Plan, Route, configuration_space::ConfigurationSpace, transfers::Transfers};
use terrain::{Cell, CellClass, Point, Segment, SweptRaster, for_each_swept};

/// Positions looked at closely for each piece.
const CANDIDATES: usize = 3;
/// A piece of line is kept when at least this share of what its tool passes over is wanted.
const WORTH_SHARE: f64 = 0.06;
/// Parts of a line that sweep nothing are driven rather than cut out up to this many tool widths.
const BRIDGE_TOOLS: f64 = 1.5;
/// Cells that lack more samples than this get lines of their own, of 64; then those that lack less, until enough is swept.
/// What is left then are specks, which are visited in the end.
const LACKS_SAMPLES: [u32; 5] = [32, 16, 8, 3, 0];
/// Of what a plan may leave, this share is used.
const LEFT_SHARE: f64 = 0.8;
/// Orphans are cut into at least so many pieces for each robot …
const PIECES_EACH: f64 = 2.0;
/// … that take no less than this, seconds.
const PIECE_MIN_S: f64 = 15.0;
/// Ends are given away so often for each robot at most.
const GIFTS_EACH: usize = 3;
/// A gift has to bring the end nearer by this share of it.
const LEAST_GAIN_SHARE: f64 = 0.05;
/// Ways are longer than straight lines.
const DETOUR: f64 = 1.25;

/// Plans by keeping the incumbent lines; `None` when there are none, or when something of them is out of reach.
pub(crate) fn repair(instance: &Instance<'_>) -> Option<Plan> {
    let under_way = instance.incumbent_lines.iter().chain(&instance.orphan_lines).any(|line| line.len() > 1);
    if !under_way || instance.incumbent_lines.len() != instance.starts.len() {
        return None;
    }
    let space = ConfigurationSpace::new(instance);
    let mut workshop = Workshop::new(&space);
    workshop.keep_incumbents();
    workshop.deal_orphans()?;
    workshop.cover_the_rest()?;
    workshop.balance();
    workshop.routes()
}

/// A part of a line that sweeps something wanted.
#[derive(Debug, Clone)]
struct Stretch {
    points: Vec<Point>,
    time_s: f64,
}

impl Stretch {
    fn new(instance: &Instance<'_>, points: Vec<Point>) -> Self {
        Self { time_s: instance.motion.path_s(&points, None), points }
    }

    fn first(&self) -> Point {
        self.points[0]
    }

    fn last(&self) -> Point {
        self.points[self.points.len() - 1]
    }

    fn reversed(&self) -> Self {
        Self { points: self.points.iter().rev().copied().collect(), time_s: self.time_s }
    }
}

/// Where a piece could go.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    robot: usize,
    at: usize,
    backwards: bool,
    /// Makespan then, and the time it adds, seconds.
    cost_s: (f64, f64),
}

struct Workshop<'s, 'a> {
    instance: &'a Instance<'a>,
    transfers: Transfers<'s, 'a>,
    /// Row-major: samples that are to be swept.
    wanted: Vec<u64>,
    /// What the stretches chosen so far sweep.
    raster: SweptRaster,
    sequences: Vec<Vec<Stretch>>,
    /// Estimate of when each robot is done, seconds.
    ends_s: Vec<f64>,
    orphans: Vec<Stretch>,
}

impl<'s, 'a> Workshop<'s, 'a> {
    fn new(space: &'s ConfigurationSpace<'a>) -> Self {
        let instance = space.instance();
        let robots = instance.starts.len();
        Self {
            wanted: wanted(instance),
            raster: SweptRaster::new(*instance.floor.lattice()),
            transfers: Transfers::new(space),
            sequences: vec![Vec::new(); robots],
            ends_s: instance.starts.iter().map(|start| start.available_in_s).collect(),
            orphans: Vec::new(),
            instance,
        }
    }

    /// Each robot keeps what is left of its own line; what it cannot reach any more is an orphan.
    fn keep_incumbents(&mut self) {
        for robot in 0..self.sequences.len() {
            let mut at = self.start_of(robot);
            for stretch in self.worthwhile(&self.instance.incumbent_lines[robot]) {
                if self.transfers.way(at, stretch.first()).is_some() {
                    at = stretch.last();
                    self.sequences[robot].push(stretch);
                } else {
                    self.orphans.push(stretch);
                }
            }
            self.estimate(robot);
        }
    }

    /// The parts of a line that are free and sweep something wanted; they count as swept from now on.
    fn worthwhile(&mut self, line: &[Point]) -> Vec<Stretch> {
        let mut stretches: Vec<Vec<Point>> = Vec::new();
        let bridge_m = BRIDGE_TOOLS * self.instance.floor.tool_width_m();
        let mut skipped: Vec<Point> = Vec::new();
        let mut skipped_m = f64::INFINITY;
        for edge in self.edges(line) {
            let free = self.transfers.space().segment_is_free(edge);
            if free && self.is_worthwhile(edge) {
                self.raster.sweep(edge, self.radius_m(), |_| {});
                match stretches.last_mut() {
                    Some(stretch) if skipped_m <= bridge_m => stretch.append(&mut skipped),
                    _ => stretches.push(vec![edge.from]),
                }
                stretches.last_mut().expect("one was just made").push(edge.to);
                skipped_m = 0.0;
                skipped.clear();
            } else {
                skipped_m = if free { skipped_m + edge.length() } else { f64::INFINITY };
                skipped.push(edge.to);
            }
        }
        stretches.into_iter().map(|points| Stretch::new(self.instance, joined(&points))).collect()
    }

    /// A line in pieces: straight runs as a whole where all of it is wanted, else cell by cell.
    fn edges(&self, line: &[Point]) -> Vec<Segment> {
        let cell_m = self.instance.floor.lattice().cell_m;
        let mut edges = Vec::new();
        for pair in joined(line).windows(2) {
            let run = Segment::new(pair[0], pair[1]);
            let pieces = if self.is_untouched(run) { 1.0 } else { (run.length() / cell_m).ceil().max(1.0) };
            let at = |piece: f64| run.from + (run.to - run.from) * (piece / pieces);
            edges.extend(
                (0..pieces as u32).map(f64::from).map(|piece| Segment::new(at(piece), at(piece + 1.0))),
            );
        }
        edges
    }

    fn radius_m(&self) -> f64 {
        self.instance.floor.tool_width_m() / 2.0
    }

    /// Samples along a segment that are passed over, and those of them that are wanted and not swept.
    fn gain(&self, edge: Segment) -> (u32, u32) {
        let (mut passed, mut gained) = (0, 0);
        for_each_swept(self.instance.floor.lattice(), edge, self.radius_m(), |index, swept| {
            passed += swept.count_ones();
            gained += (swept & self.wanted[index] & !self.raster.samples(index)).count_ones();
        });
        (passed, gained)
    }

    fn is_worthwhile(&self, edge: Segment) -> bool {
        let (passed, gained) = self.gain(edge);
        f64::from(gained) > WORTH_SHARE * f64::from(passed)
    }

    /// Whether nothing of what the cells in the middle of a run hold is done, seen at its ends and on the way.
    fn is_untouched(&self, run: Segment) -> bool {
        let lattice = self.instance.floor.lattice();
        lattice.cells_along(run).into_iter().all(|cell| {
            lattice.index(cell).is_some_and(|index| {
                let required = self.instance.floor.required(index);
                required != 0
                    && self.wanted[index] == required
                    && self.raster.samples(index) & required != required
            })
        })
    }

    fn start_of(&self, robot: usize) -> Point {
        self.instance.place(&self.instance.starts[robot])
    }

    /// Estimate of a hop between two stretches, seconds.
    fn hop_s(&self, from: Point, to: Point) -> f64 {
        let apart_m = (to - from).norm();
        if apart_m < 1e-6 {
            return 0.0;
        }
        let turns_s = 2.0 * self.instance.motion.turn_s(std::f64::consts::FRAC_PI_4);
        turns_s + self.instance.motion.run_s(DETOUR * apart_m)
    }

    fn estimate(&mut self, robot: usize) {
        let mut end_s = self.instance.starts[robot].available_in_s;
        let mut at = self.start_of(robot);
        for stretch in &self.sequences[robot] {
            end_s += self.hop_s(at, stretch.first()) + stretch.time_s;
            at = stretch.last();
        }
        self.ends_s[robot] = end_s;
    }

    fn makespan_s(&self) -> f64 {
        self.ends_s.iter().copied().fold(0.0, f64::max)
    }

    fn deal_orphans(&mut self) -> Option<()> {
        let mut stretches = std::mem::take(&mut self.orphans);
        for line in &self.instance.orphan_lines {
            stretches.extend(self.worthwhile(line));
        }
        let total_s: f64 = stretches.iter().map(|stretch| stretch.time_s).sum();
        let most_s = (total_s / (PIECES_EACH * self.sequences.len() as f64)).max(PIECE_MIN_S);
        for stretch in stretches {
            for piece in cut(self.instance, stretch, most_s) {
                self.insert(piece)?;
            }
        }
        Some(())
    }

    /// Puts a piece where the makespan grows least, and then the time of its robot.
    fn insert(&mut self, piece: Stretch) -> Option<Candidate> {
        let best = self.best_place(&piece)?;
        let piece = if best.backwards { piece.reversed() } else { piece };
        self.sequences[best.robot].insert(best.at, piece);
        self.ends_s[best.robot] += best.cost_s.1;
        Some(best)
    }

    fn best_place(&mut self, piece: &Stretch) -> Option<Candidate> {
        let mut candidates = self.candidates(piece);
        candidates.sort_by(cheaper);
        let mut best: Option<Candidate> = None;
        let mut seen = 0;
        for candidate in candidates {
            if seen == CANDIDATES && best.is_some() {
                break;
            }
            seen += 1;
            if let Some(added_s) = self.added_s(piece, &candidate) {
                let cost_s = self.cost_s(candidate.robot, added_s);
                let candidate = Candidate { cost_s, ..candidate };
                if best.is_none_or(|best| cheaper(&candidate, &best).is_lt()) {
                    best = Some(candidate);
                }
            }
            if seen > 12 {
                break;
            }
        }
        best
    }

    fn cost_s(&self, robot: usize, added_s: f64) -> (f64, f64) {
        (self.makespan_s().max(self.ends_s[robot] + added_s), added_s)
    }

    /// All positions, priced by straight lines.
    fn candidates(&self, piece: &Stretch) -> Vec<Candidate> {
        let mut candidates = Vec::new();
        for robot in 0..self.sequences.len() {
            for at in 0..=self.sequences[robot].len() {
                let (before, after) = self.around(robot, at);
                for backwards in [false, true] {
                    let (first, last) = ends(piece, backwards);
                    let leave_s =
                        after.map_or(0.0, |after| self.hop_s(last, after) - self.hop_s(before, after));
                    let added_s = self.hop_s(before, first) + piece.time_s + leave_s;
                    candidates.push(Candidate { robot, at, backwards, cost_s: self.cost_s(robot, added_s) });
                }
            }
        }
        candidates
    }

    /// Where a robot comes from at a position of its sequence, and where it goes on.
    fn around(&self, robot: usize, at: usize) -> (Point, Option<Point>) {
        let sequence = &self.sequences[robot];
        let before = at.checked_sub(1).map_or_else(|| self.start_of(robot), |before| sequence[before].last());
        (before, sequence.get(at).map(Stretch::first))
    }

    /// The time a candidate truly adds; `None` when there is no way.
    fn added_s(&mut self, piece: &Stretch, candidate: &Candidate) -> Option<f64> {
        let (before, after) = self.around(candidate.robot, candidate.at);
        let (first, last) = ends(piece, candidate.backwards);
        let mut added_s = piece.time_s + self.way_s(before, first)?;
        if let Some(after) = after {
            added_s += self.way_s(last, after)? - self.way_s(before, after)?;
        }
        Some(added_s)
    }

    fn way_s(&mut self, from: Point, to: Point) -> Option<f64> {
        if (to - from).norm() < 1e-6 {
            return Some(0.0);
        }
        let turns_s = 2.0 * self.instance.motion.turn_s(std::f64::consts::FRAC_PI_4);
        Some(turns_s + self.transfers.way(from, to)?.inner_s)
    }

    /// Lines for ground that no stretch sweeps: along rows of cells, those that lack most first.
    fn cover_the_rest(&mut self) -> Option<()> {
        for more_than in LACKS_SAMPLES {
            if self.is_enough_swept() {
                break;
            }
            for row in 0..self.instance.floor.lattice().rows as i32 {
                self.cover_row(row, more_than)?;
            }
        }
        Some(())
    }

    fn is_enough_swept(&self) -> bool {
        let (mut wanted, mut missing) = (0_u64, 0_u64);
        for index in (0..self.wanted.len()).filter(|&index| self.instance.visit[index]) {
            wanted += u64::from(self.wanted[index].count_ones());
            missing += u64::from(self.missing(index));
        }
        missing as f64 <= LEFT_SHARE * (1.0 - self.instance.coverage_min) * wanted as f64
    }

    fn cover_row(&mut self, y: i32, more_than: u32) -> Option<()> {
        let lattice = *self.instance.floor.lattice();
        let mut run: Vec<Point> = Vec::new();
        for cell in (0..lattice.columns as i32).map(|x| Cell::new(x, y)) {
            let index = lattice.index(cell).expect("a row is on the lattice");
            if !self.instance.visit[index] || self.missing(index) <= more_than {
                continue;
            }
            let here = lattice.center(cell);
            let goes_on = run.last().is_some_and(|&last| {
                (here - last).norm() <= 2.1 * lattice.cell_m
                    && self.transfers.space().segment_is_free(Segment::new(last, here))
            });
            if !goes_on && !run.is_empty() {
                self.add_line(&std::mem::take(&mut run))?;
            }
            run.push(here);
        }
        if run.is_empty() { Some(()) } else { self.add_line(&run) }
    }

    /// How many samples of a cell no stretch sweeps.
    fn missing(&self, index: usize) -> u32 {
        (self.wanted[index] & !self.raster.samples(index)).count_ones()
    }

    fn add_line(&mut self, points: &[Point]) -> Option<()> {
        let points = joined(points);
        let only = points[0];
        for pair in points.windows(2) {
            self.raster.sweep(Segment::new(pair[0], pair[1]), self.radius_m(), |_| {});
        }
        self.raster.sweep(Segment::new(only, only), self.radius_m(), |_| {});
        self.insert(Stretch::new(self.instance, points)).map(|_| ())
    }

    /// The robot that ends last gives the end of its route away, as long as it and the one that takes it are done sooner
    /// then.
    fn balance(&mut self) {
        for _ in 0..GIFTS_EACH * self.sequences.len() {
            let latest = (0..self.ends_s.len()).max_by(|&a, &b| self.ends_s[a].total_cmp(&self.ends_s[b]));
            let earliest_s = self.ends_s.iter().copied().fold(f64::INFINITY, f64::min);
            let Some(latest) = latest else { return };
            let most_s = (self.ends_s[latest] - earliest_s) / 2.0;
            let helps =
                |share: &f64| most_s * share >= PIECE_MIN_S && self.give_end_away(latest, most_s * share);
            if ![1.0, 0.5].iter().any(helps) {
                return;
            }
        }
    }

    /// Gives up to so much of the end of a route to another robot; false (and nothing changed) where that does not help.
    fn give_end_away(&mut self, robot: usize, most_s: f64) -> bool {
        let before = (self.sequences[robot].clone(), self.ends_s[robot]);
        let gift = self.take_end(robot, most_s);
        self.estimate(robot);
        let taken = self.best_taker(robot, &gift);
        let taken = taken
            .filter(|taken| self.ends_s[robot].max(taken.cost_s.0) < before.1 - LEAST_GAIN_SHARE * most_s);
        let Some(taken) = taken else {
            (self.sequences[robot], self.ends_s[robot]) = before;
            return false;
        };
        self.sequences[taken.robot].extend(if taken.backwards { backwards(&gift) } else { gift });
        self.ends_s[taken.robot] = taken.cost_s.0;
        true
    }

    /// Cuts the end off a route that takes up to so long, hops within it included.
    fn take_end(&mut self, robot: usize, most_s: f64) -> Vec<Stretch> {
        let mut gift: Vec<Stretch> = Vec::new();
        let mut left_s = most_s;
        while let Some(last) = self.sequences[robot].pop() {
            let hop_s = gift.last().map_or(0.0, |next: &Stretch| self.hop_s(last.last(), next.first()));
            if hop_s + last.time_s <= left_s {
                left_s -= hop_s + last.time_s;
                gift.push(last);
                continue;
            }
            let mut pieces = cut(self.instance, last, (left_s - hop_s).max(PIECE_MIN_S));
            if left_s - hop_s >= PIECE_MIN_S {
                gift.extend(pieces.pop());
            }
            self.sequences[robot].extend(pieces);
            break;
        }
        gift.reverse();
        gift
    }

    /// The robot that would be done soonest with a gift appended to its route; the cost is its end then, and what that
    /// adds.
    fn best_taker(&mut self, giver: usize, gift: &[Stretch]) -> Option<Candidate> {
        let (first, last) = (gift.first()?.first(), gift.last()?.last());
        let hops_s: f64 = gift.windows(2).map(|pair| self.hop_s(pair[0].last(), pair[1].first())).sum();
        let gift_s = hops_s + gift.iter().map(|stretch| stretch.time_s).sum::<f64>();
        let mut candidates: Vec<Candidate> = Vec::new();
        for robot in (0..self.sequences.len()).filter(|&robot| robot != giver) {
            let at = self.sequences[robot].len();
            let from = self.around(robot, at).0;
            for (backwards, to) in [(false, first), (true, last)] {
                let added_s = self.hop_s(from, to) + gift_s;
                let cost_s = (self.ends_s[robot] + added_s, added_s);
                candidates.push(Candidate { robot, at, backwards, cost_s });
            }
        }
        candidates.sort_by(cheaper);
        let truly = |candidate: &Candidate| {
            let from = self.around(candidate.robot, candidate.at).0;
            let to = if candidate.backwards { last } else { first };
            let added_s = self.way_s(from, to)? + gift_s;
            Some(Candidate { cost_s: (self.ends_s[candidate.robot] + added_s, added_s), ..*candidate })
        };
        candidates.iter().take(2 * CANDIDATES).filter_map(truly).min_by(cheaper)
    }

    /// Joins each robot's stretches by ways.
    fn routes(mut self) -> Option<Plan> {
        let sequences = std::mem::take(&mut self.sequences);
        let routes = sequences.iter().enumerate().map(|(robot, sequence)| self.route(robot, sequence));
        Some(Plan { routes: routes.collect::<Option<_>>()? })
    }

    fn route(&mut self, robot: usize, sequence: &[Stretch]) -> Option<Route> {
        if sequence.is_empty() {
            return Some(Route::default());
        }
        let start = self.start_of(robot);
        let mut points = vec![start];
        for stretch in sequence {
            points.extend(self.transfers.way(points[points.len() - 1], stretch.first())?.points);
            points.extend(&stretch.points);
        }
        if self.instance.mode == Mode::CoverAndReturn {
            points.extend(self.transfers.way(points[points.len() - 1], start)?.points);
        }
        points.dedup_by(|a, b| (*a - *b).norm() < 1e-7);
        Some(Route::new(points))
    }
}

/// A chain of stretches from its end to its begin.
fn backwards(chain: &[Stretch]) -> Vec<Stretch> {
    chain.iter().rev().map(Stretch::reversed).collect()
}

fn ends(piece: &Stretch, backwards: bool) -> (Point, Point) {
    if backwards { (piece.last(), piece.first()) } else { (piece.first(), piece.last()) }
}

fn cheaper(a: &Candidate, b: &Candidate) -> std::cmp::Ordering {
    let later = a.cost_s.0.total_cmp(&b.cost_s.0);
    let place = |c: &Candidate| (c.robot, c.at, c.backwards);
    later.then(a.cost_s.1.total_cmp(&b.cost_s.1)).then_with(|| place(a).cmp(&place(b)))
}

/// Row-major: what is to be swept in cells to visit, and beside them where no body can stand.
fn wanted(instance: &Instance<'_>) -> Vec<u64> {
    let (floor, lattice) = (instance.floor, *instance.floor.lattice());
    let reach = (floor.tool_width_m() / 2.0 / lattice.cell_m).ceil() as i32;
    let beside = |cell: Cell| {
        let mut around = (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy)));
        around.any(|(dx, dy)| {
            lattice.index(Cell::new(cell.x + dx, cell.y + dy)).is_some_and(|near| instance.visit[near])
        })
    };
    let asked = |(index, cell): (usize, Cell)| {
        let rim = !floor.is_drivable(index) && floor.class(index) == CellClass::Coverable;
        if instance.visit[index] || rim && beside(cell) { instance.wanted(index) } else { 0 }
    };
    lattice.cells().enumerate().map(asked).collect()
}

/// Leaves out points on straight lines.
fn joined(line: &[Point]) -> Vec<Point> {
    let mut points: Vec<Point> = Vec::with_capacity(line.len());
    for &point in line {
        if points.last().is_some_and(|last| (last - point).norm() < 1e-9) {
            continue;
        }
        if let [.., before, last] = points[..] {
            let (one, two) = ((last - before).normalize(), (point - last).normalize());
            if one.perp(&two).abs() < 1e-9 && one.dot(&two) > 0.0 {
                points.pop();
            }
        }
        points.push(point);
    }
    points
}

/// A stretch in pieces of about the same time, at most `most_s` each; cut on edges, too, where they are long.
fn cut(instance: &Instance<'_>, stretch: Stretch, most_s: f64) -> Vec<Stretch> {
    let count = (stretch.time_s / most_s).ceil();
    if count <= 1.0 || stretch.points.len() < 2 {
        return vec![stretch];
    }
    let length_m: f64 = stretch.points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
    let share_m = length_m / count;
    let mut pieces = vec![vec![stretch.points[0]]];
    let mut left_m = share_m;
    for pair in stretch.points.windows(2) {
        let (mut at, to) = (pair[0], pair[1]);
        while (to - at).norm() > left_m + 1e-6 {
            at += (to - at).normalize() * left_m;
            left_m = share_m;
            pieces.last_mut().expect("it began with one").push(at);
            pieces.push(vec![at]);
        }
        left_m -= (to - at).norm();
        pieces.last_mut().expect("it began with one").push(to);
    }
    pieces.retain(|points| points.len() > 1);
    pieces.into_iter().map(|points| Stretch::new(instance, points)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_motion::MOTION;
    use crate::{PlanOptions, Start, plan, verify};
    use proptest::prelude::*;
    use terrain::{Floor, Lattice};

    /// A walk from cell to cell with its corners cut: over the middles between the cells.
    fn chamfered(points: &[Point]) -> Vec<Point> {
        let middles = points.windows(2).map(|pair| middle(pair[0], pair[1]));
        points.first().copied().into_iter().chain(middles).chain(points.last().copied()).collect()
    }

    fn middle(a: Point, b: Point) -> Point {
        a + (b - a) * 0.5
    }

    /// A mission some way on: each robot has driven a share of its line, the first is lost, some ground is blocked.
    fn some_way_on<'a>(
        floor: &'a Floor,
        starts: Vec<Start>,
        share: f64,
        blocked: &[bool],
    ) -> Option<Instance<'a>> {
        let whole = Instance::whole_floor(floor, starts, MOTION, Mode::Cover);
        let planned = plan(&whole, &PlanOptions::default()).ok()?;
        let lattice = *floor.lattice();
        let mut raster = SweptRaster::new(lattice);
        let mut later = whole.clone();
        for (robot, route) in planned.routes().iter().enumerate() {
            let line = chamfered(&route.points);
            let driven = ((line.len() as f64 * share) as usize).min(line.len().saturating_sub(1));
            for pair in line.get(..=driven).unwrap_or_default().windows(2) {
                raster.sweep(Segment::new(pair[0], pair[1]), floor.tool_width_m() / 2.0, |_| {});
            }
            let ahead = line.get(driven..).unwrap_or_default().to_vec();
            if let Some(&at) = ahead.first() {
                later.starts[robot] = Start { point: Some(at), ..Start::at(lattice.cell_at(at)?) };
            }
            later.incumbent_lines.push(ahead);
        }
        later.swept = (0..lattice.len()).map(|index| raster.samples(index)).collect();
        if later.starts.len() > 1 {
            later.starts.remove(0);
            later.orphan_lines.push(later.incumbent_lines.remove(0));
        }
        later.blocked = blocked.to_vec();
        let later = later.with_open_starts();
        let reachable = later.reachable();
        let visit = (0..reachable.len()).map(|index| reachable[index] && later.wanted(index) != 0).collect();
        let later = Instance { visit, ..later };
        (later.visit.contains(&true) && later.incumbent_lines.iter().any(|line| line.len() > 1))
            .then_some(later)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(100))]
        #[test]
        fn a_repair_holds_and_sweeps_what_is_left(
            columns in 3_u32..14,
            rows in 3_u32..14,
            free in prop::collection::vec(prop::bool::weighted(0.85), 14 * 14),
            blocked in prop::collection::vec(prop::bool::weighted(0.05), 14 * 14),
            starts in prop::collection::vec(0_usize..196, 1..5),
            share in 0.0_f64..0.9,
        ) {
            let lattice = Lattice { origin: Point::origin(), cell_m: 0.5, columns, rows };
            let floor = Floor::from_cells(lattice, &free[..lattice.len()], 0.177, 0.75);
            let drivable: Vec<usize> = (0..lattice.len()).filter(|&index| floor.is_drivable(index)).collect();
            prop_assume!(!drivable.is_empty());
            let mut cells: Vec<usize> = starts.iter().map(|start| drivable[start % drivable.len()]).collect();
            cells.sort_unstable();
            cells.dedup();
            let starts = cells.iter().map(|&cell| Start::at(lattice.cell(cell))).collect();
            let Some(later) = some_way_on(&floor, starts, share, &blocked[..lattice.len()]) else { return Ok(()) };
            let Some(repaired) = repair(&later) else { return Ok(()) };
            prop_assert_eq!(&repair(&later), &Some(repaired.clone()), "the same again");
            let figures = verify(&later, &repaired);
            prop_assert!(figures.is_ok(), "{figures:?}");
        }
    }

    #[test]
    fn a_lost_robots_line_is_shared_and_a_finished_one_is_dropped() {
        let free = vec![true; 20 * 6];
        let lattice = Lattice { origin: Point::origin(), cell_m: 0.5, columns: 20, rows: 6 };
        let floor = Floor::from_cells(lattice, &free, 0.177, 0.75);
        let starts: Vec<Start> = [(0, 0), (0, 5), (19, 5)].map(|(x, y)| Start::at(Cell::new(x, y))).to_vec();
        let later = some_way_on(&floor, starts, 0.3, &[false; 120]).expect("there is something left");
        let alone_s = later.motion.path_s(&later.orphan_lines[0], None);
        let own_s =
            later.incumbent_lines.iter().map(|line| later.motion.path_s(line, None)).fold(0.0, f64::max);
        let repaired = repair(&later).expect("everything can be reached");
        let figures = verify(&later, &repaired).expect("it holds");
        assert!(figures.coverage_ratio >= 0.99, "{figures:?}");
        assert!(
            figures.makespan_s < own_s + 0.8 * alone_s,
            "{} s, {own_s} + {alone_s} s",
            figures.makespan_s
        );
        let done = Instance { visit: vec![false; 120], ..later };
        let nothing = repair(&done).expect("nothing is out of reach");
        assert!(nothing.routes.iter().all(|route| route.points.is_empty()));
    }
}
