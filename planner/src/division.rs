//! Division of closed walks among robots, by true cost.
//!
//! The loops are laid end to end as one sequence of cells. A division gives each robot a run of it: cost is the
//! way from the robot to the run, then the run with its turns. The largest cost is bisected; for one bound the
//! sequence is dealt out greedily, each time to the robot that gets furthest within the bound. Several places to
//! begin dealing are tried. In the end each run is driven in the direction that is cheaper, and the ways between
//! cells that do not touch are filled in.

mod cut;

use crate::{
    Instance, Mode, Plan, PlanError, Route, Start,
    shortest_way::{WayFinder, moves_from},
};
use cut::Cut;
use std::{collections::BTreeMap, f64::consts::FRAC_PI_2};
use terrain::Cell;

/// Places to begin dealing, at most.
const BEGINNINGS_MAX: usize = 48;
const BISECTIONS: u32 = 24;
/// Bounds leave out the turns of ways: what is a little worse by the bound may be better in truth.
const SLACK: f64 = 1.02;
/// Ways to deal that are driven to see what they take.
const CUTS_DRIVEN: usize = 6;

/// The sequence with running costs.
struct Sequence {
    cells: Vec<Cell>,
    /// Seconds from the first cell to each cell, along the sequence.
    clock: Vec<f64>,
}

/// Divides loops among the robots of an instance.
///
/// # Errors
///
/// [`PlanError::Unreachable`] when a cell cannot be reached.
pub(crate) fn divide(instance: &Instance<'_>, loops: Vec<Vec<Cell>>) -> Result<Plan, PlanError> {
    divide_among(instance, loops, &vec![true; instance.starts.len()])
}

/// The same among those robots only that are marked.
///
/// # Errors
///
/// [`PlanError::Unreachable`] when none of them can reach a cell.
pub(crate) fn divide_among(
    instance: &Instance<'_>,
    loops: Vec<Vec<Cell>>,
    takes_part: &[bool],
) -> Result<Plan, PlanError> {
    let mut finder = WayFinder::new(instance);
    let mut routes = vec![Route::default(); instance.starts.len()];
    for (team, cells) in teams(instance, loops, takes_part)? {
        let sequence = lay_out(instance, cells, &mut finder)?;
        let mut best: Option<Cut> = None;
        for runs in deal_best(&team, &sequence) {
            let cut = Cut::drive(&team, &sequence, runs, &mut finder)?;
            if best.as_ref().is_none_or(|best| cut.makespan_s() < best.makespan_s()) {
                best = Some(cut);
            }
        }
        let mut best = best.expect("without a bound, dealing works");
        best.improve(&team, &sequence, &mut finder)?;
        for (member, (_, route)) in best.driven.into_iter().enumerate() {
            routes[team.robots[member]] = route;
        }
    }
    Ok(Plan { routes })
}

/// Per connected piece of ground: its robots, and its loops one after another.
///
/// # Errors
///
/// [`PlanError::Unreachable`] for a piece without a robot.
pub(crate) fn teams<'a>(
    instance: &'a Instance<'a>,
    loops: Vec<Vec<Cell>>,
    takes_part: &[bool],
) -> Result<Vec<(Team<'a>, Vec<Cell>)>, PlanError> {
    let lattice = instance.floor.lattice();
    let component = instance.components();
    let component_of = |cell: Cell| lattice.index(cell).map_or(u32::MAX, |index| component[index]);
    let mut pieces: BTreeMap<u32, Vec<Vec<Cell>>> = BTreeMap::new();
    for cells in loops {
        pieces.entry(component_of(cells[0])).or_default().push(cells);
    }
    let team = |(number, loops): (u32, Vec<Vec<Cell>>)| {
        let robots: Vec<usize> = (0..instance.starts.len())
            .filter(|&robot| takes_part[robot] && component_of(instance.starts[robot].cell) == number)
            .collect();
        if robots.is_empty() {
            return Err(PlanError::Unreachable(loops[0][0]));
        }
        let team = Team::new(instance, robots);
        let ordered = order_loops(instance, loops, &team.legs);
        Ok((team, ordered.into_iter().flatten().collect()))
    };
    pieces.into_iter().map(team).collect()
}

/// Time of the slowest robot, seconds.
pub(crate) fn makespan_s(instance: &Instance<'_>, plan: &Plan) -> f64 {
    let times =
        plan.routes.iter().zip(&instance.starts).map(|(route, start)| route_s(instance, start, route));
    times.fold(0.0, f64::max)
}

/// Time of one robot, its delay included; 0 when it stays, seconds.
fn route_s(instance: &Instance<'_>, start: &Start, route: &Route) -> f64 {
    match route.points.len() {
        0 | 1 => 0.0,
        _ => start.available_in_s + instance.path_s(&route.points, start.heading_rad),
    }
}

/// The robots that share a connected piece of ground, and how far each has to everywhere.
pub(crate) struct Team<'a> {
    instance: &'a Instance<'a>,
    /// Their numbers.
    pub(crate) robots: Vec<usize>,
    /// Per robot, row-major: moves from its start; `u32::MAX` where there is no way.
    pub(crate) legs: Vec<Vec<u32>>,
}

impl<'a> Team<'a> {
    fn new(instance: &'a Instance<'a>, robots: Vec<usize>) -> Self {
        let legs = robots.iter().map(|&robot| moves_from(instance, instance.starts[robot].cell)).collect();
        Self { instance, robots, legs }
    }

    fn available_in_s(&self, member: usize) -> f64 {
        self.instance.starts[self.robots[member]].available_in_s
    }
}

/// Loops in the order of a walk from piece to piece, each turned so that it begins near the end of the last.
fn order_loops(instance: &Instance<'_>, mut loops: Vec<Vec<Cell>>, legs: &[Vec<u32>]) -> Vec<Vec<Cell>> {
    let lattice = instance.floor.lattice();
    let near_start = |cell: Cell| {
        let index = lattice.index(cell).expect("cells to visit are on the lattice");
        legs.iter().map(|moves| moves[index]).min().unwrap_or(u32::MAX)
    };
    let mut ordered: Vec<Vec<Cell>> = Vec::with_capacity(loops.len());
    loops.sort_by_key(|cells| std::cmp::Reverse(cells.len()));
    if loops.len() > 400 {
        loops.sort_by_key(|cells| cells.iter().map(|&cell| near_start(cell)).min());
        return loops;
    }
    let mut at: Option<Cell> = None;
    while !loops.is_empty() {
        let distance = |cell: Cell| at.map_or_else(|| near_start(cell), |from| cell.manhattan(from));
        let (best, offset) = loops
            .iter()
            .enumerate()
            .flat_map(|(number, cells)| {
                cells.iter().enumerate().map(move |(offset, &cell)| (number, offset, cell))
            })
            .min_by_key(|&(_, _, cell)| distance(cell))
            .map(|(number, offset, _)| (number, offset))
            .expect("loops are not empty");
        let mut cells = loops.swap_remove(best);
        cells.rotate_left(offset);
        at = cells.last().copied();
        ordered.push(cells);
    }
    ordered
}

fn lay_out(instance: &Instance<'_>, cells: Vec<Cell>, finder: &mut WayFinder) -> Result<Sequence, PlanError> {
    let mut clock = Vec::with_capacity(cells.len());
    let mut now_s = 0.0;
    let mut heading: Option<(i32, i32)> = None;
    for (number, &cell) in cells.iter().enumerate() {
        if number > 0 {
            let before = cells[number - 1];
            let mut way = vec![before];
            finder.go(instance, before, cell, &mut way)?;
            for pair in way.windows(2) {
                let step = (pair[1].x - pair[0].x, pair[1].y - pair[0].y);
                now_s += move_s(instance) + heading.map_or(0.0, |from| turn_s(instance, from, step));
                heading = Some(step);
            }
        }
        clock.push(now_s);
    }
    Ok(Sequence { cells, clock })
}

fn move_s(instance: &Instance<'_>) -> f64 {
    instance.floor.lattice().cell_m / instance.motion.speed_m_per_s
}

/// What a corner costs: the turn itself, and the ramps of the runs that it separates.
fn turn_s(instance: &Instance<'_>, from: (i32, i32), to: (i32, i32)) -> f64 {
    if from == to {
        return 0.0;
    }
    let motion = &instance.motion;
    let quarters = if from.0 == -to.0 && from.1 == -to.1 { 2.0 } else { 1.0 };
    let ramps = if motion.brakes { 1.0 } else { 0.5 };
    motion.turn_s(quarters * FRAC_PI_2) + ramps * motion.speed_m_per_s / motion.acceleration_m_per_s2
}

/// A robot's run: from one number of the sequence up to, not including, another.
type Run = std::ops::Range<usize>;

/// The best few ways to deal, each better than the one before it, by the bound.
fn deal_best(team: &Team<'_>, sequence: &Sequence) -> Vec<Vec<Option<Run>>> {
    let mut to_beat_s = f64::INFINITY;
    let mut dealt = Vec::new();
    for rotation in beginnings(team, sequence) {
        if let Some((bound_s, runs)) = Dealer::new(team, sequence, rotation).bisect(to_beat_s) {
            to_beat_s = bound_s * SLACK;
            dealt.push((bound_s, runs));
        }
    }
    dealt.sort_by(|a, b| a.0.total_cmp(&b.0));
    dealt.into_iter().take(CUTS_DRIVEN).map(|(_, runs)| runs).collect()
}

/// Numbers of the sequence at which dealing may begin: where robots stand, and evenly spread ones.
fn beginnings(team: &Team<'_>, sequence: &Sequence) -> Vec<usize> {
    let lattice = team.instance.floor.lattice();
    let count = sequence.cells.len();
    let index_of = |number: usize| lattice.index(sequence.cells[number]).expect("cells are on the lattice");
    let mut numbers: Vec<usize> = team
        .legs
        .iter()
        .take(BEGINNINGS_MAX / 2)
        .filter_map(|moves| (0..count).min_by_key(|&number| moves[index_of(number)]))
        .collect();
    let spread = (BEGINNINGS_MAX / 2).min(count);
    numbers.extend((0..spread).map(|part| part * count / spread));
    numbers.push(0);
    numbers.sort_unstable();
    numbers.dedup();
    numbers
}

/// Deals the sequence out, beginning at one place of it (it is taken as closed).
struct Dealer<'a> {
    team: &'a Team<'a>,
    sequence: &'a Sequence,
    rotation: usize,
    closing_s: f64,
}

impl<'a> Dealer<'a> {
    fn new(team: &'a Team<'a>, sequence: &'a Sequence, rotation: usize) -> Self {
        let (first, last) = (sequence.cells[0], sequence.cells[sequence.cells.len() - 1]);
        let closing_s = f64::from(first.manhattan(last)) * move_s(team.instance);
        Self { team, sequence, rotation, closing_s }
    }

    /// Seconds from the beginning to the cell with this number, along the rotated sequence.
    fn clock(&self, number: usize) -> f64 {
        let count = self.sequence.cells.len();
        let at = self.rotation + number;
        let begin_s = self.sequence.clock[self.rotation];
        if at < count {
            self.sequence.clock[at] - begin_s
        } else {
            self.sequence.clock[count - 1] - begin_s + self.closing_s + self.sequence.clock[at - count]
        }
    }

    fn leg_s(&self, member: usize, number: usize) -> f64 {
        let cell = self.sequence.cells[(self.rotation + number) % self.sequence.cells.len()];
        let index = self.team.instance.floor.lattice().index(cell).expect("cells are on the lattice");
        f64::from(self.team.legs[member][index]) * move_s(self.team.instance)
    }

    /// The smallest bound that works, to within the bisection's precision, and its runs; nothing when
    /// `to_beat_s` does not work.
    fn bisect(&self, to_beat_s: f64) -> Option<(f64, Vec<Option<Run>>)> {
        let mut best = self.deal(to_beat_s)?;
        let all_s = self.clock(self.sequence.cells.len() - 1);
        let mut low_s = all_s / self.team.robots.len() as f64;
        let mut high_s = if to_beat_s.is_finite() { to_beat_s } else { self.enough_s(all_s) };
        for _ in 0..BISECTIONS {
            let middle_s = f64::midpoint(low_s, high_s);
            match self.deal(middle_s) {
                Some(runs) => {
                    best = runs;
                    high_s = middle_s;
                }
                None => low_s = middle_s,
            }
        }
        Some((high_s, best))
    }

    /// A bound within which the first robot alone can do it all.
    fn enough_s(&self, all_s: f64) -> f64 {
        let members = 0..self.team.robots.len();
        let delay_s = members.clone().map(|member| self.team.available_in_s(member)).fold(0.0, f64::max);
        let longest = (0..self.sequence.cells.len())
            .flat_map(|number| members.clone().map(move |member| (member, number)))
            .map(|(member, number)| self.leg_s(member, number))
            .fold(0.0, f64::max);
        delay_s + all_s + 2.0 * longest
    }

    /// Runs within a bound, in numbers of the unrotated sequence; `None` when the bound is too small.
    fn deal(&self, bound_s: f64) -> Option<Vec<Option<Run>>> {
        let count = self.sequence.cells.len();
        let mut runs: Vec<Option<Run>> = vec![None; self.team.robots.len()];
        let mut at = 0;
        while at < count {
            let (member, end) = (0..runs.len())
                .filter(|&member| runs[member].is_none())
                .map(|member| (member, self.furthest(member, at, bound_s)))
                .max_by_key(|&(member, end)| (end, std::cmp::Reverse(member)))?;
            if end <= at {
                return None;
            }
            runs[member] = Some(self.rotation + at..self.rotation + end);
            at = end;
        }
        Some(runs)
    }

    /// The number up to which a robot gets within the bound when it begins at `at`.
    fn furthest(&self, member: usize, at: usize, bound_s: f64) -> usize {
        let before_s = self.team.available_in_s(member) + self.leg_s(member, at) - self.clock(at);
        let cost_s = |last: usize| {
            let back_s = match self.team.instance.mode {
                Mode::Cover => 0.0,
                Mode::CoverAndReturn => self.leg_s(member, last),
            };
            before_s + self.clock(last) + back_s
        };
        if cost_s(at) > bound_s {
            return at;
        }
        let (mut low, mut high) = (at, self.sequence.cells.len() - 1);
        while low < high {
            let middle = (low + high).div_ceil(2);
            if cost_s(middle) <= bound_s {
                low = middle;
            } else {
                high = middle - 1;
            }
        }
        low + 1
    }
}
