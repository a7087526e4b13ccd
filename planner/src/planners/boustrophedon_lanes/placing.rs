//! Where the lanes of an orientation are driven: the body has to fit, and what is swept has to be worth the time.
//!
//! A run of squares wants a lane along its middle. Where walls cut into the run the lane moves aside, in small steps, to
//! where it is worth the most: what it sweeps of the run's samples, less what its time could sweep elsewhere ([`Worth`]). By the same measure it ends where going on sweeps too little, so that the last half tool before a wall is
//! left to the way along the wall to the next lane. Parts of a line with an obstacle between them are one lane that
//! bends round it when that is hardly longer, else two.

use super::profile::{Samples, Slab, Swath};
use crate::{
    Instance,
    configuration_space::ConfigurationSpace,
    ground::Ground,
    lane_tour::Lane,
    minimum_lanes::{Orientation, Run, ToolLattice},
    transfers::Transfers,
};
use std::f64::consts::PI;
use terrain::{Cell, Point, Segment};

/// A lane in the middle that sweeps this share of what is left need not move aside.
const GOOD: f64 = 0.98;
/// Lines that are tried lie this share of a tool apart, at least.
const STEPS_ASIDE: f64 = 14.0;
/// Parts of a line are joined to one lane when the way between is longer than the gap by no more than this, tool widths.
const DETOUR_TOOLS: f64 = 0.4;
/// A place to visit is made a lane of this length, so that it is entered and left with a heading, tool widths.
const VISIT_TOOLS: f64 = 0.1;

/// What time is worth, in samples that could be swept elsewhere.
#[derive(Debug, Clone, Copy)]
pub(super) struct Worth {
    pub(super) per_s: f64,
    per_m: f64,
    lane_turns: f64,
}

impl Worth {
    /// With the share of a tool's full work that still counts as work.
    pub(super) fn new(instance: &Instance<'_>, sample_m: f64, share: f64) -> Self {
        let tool_m = instance.floor.tool_width_m();
        let per_m = share * tool_m / (sample_m * sample_m);
        let turn_m = instance.motion.turn_s(PI) * instance.motion.speed_m_per_s;
        let per_s = per_m * instance.motion.speed_m_per_s;
        Self { per_s, per_m, lane_turns: per_m * (turn_m + tool_m) }
    }

    /// A lane is driven anyway: only its length counts.
    pub(super) fn without_turns(self) -> Self {
        Self { lane_turns: 0.0, ..self }
    }
}

/// Lanes for each run, the longest runs first. What they sweep is swept in `ground`.
pub(super) fn lanes(
    space: &ConfigurationSpace<'_>,
    transfers: &mut Transfers<'_, '_>,
    ground: &mut Ground,
    orientation: &Orientation,
    worth: Worth,
) -> Vec<Lane> {
    let lattice = &orientation.lattice;
    let mut runs = orientation.runs();
    runs.sort_by_key(|run| (std::cmp::Reverse(run.squares.len()), run.squares[0]));
    let mut lanes = Vec::new();
    for run in &runs {
        let radius_m = ground.radius_m();
        let step_m = (space.places().cell_m / 2.0).max(lattice.side_m / STEPS_ASIDE);
        let line = Lines { space, lattice, is_along: run.is_along, radius_m, step_m, worth };
        let middle_m = line.middle_m(run);
        loop {
            let slab = line.slab(ground, run);
            let left = Samples::Slab(&slab);
            if (left.count() as f64) < worth.lane_turns {
                break;
            }
            let before = ground.left_count();
            for lane in line.best(transfers, left, middle_m, lattice.side_m / 2.0) {
                ground.sweep(&lane.points);
                lanes.push(lane);
            }
            if ground.left_count() == before {
                break;
            }
        }
    }
    lanes
}

/// Lines along one direction of a lattice. Positions are (along the line, across it).
pub(super) struct Lines<'l, 's> {
    pub(super) space: &'l ConfigurationSpace<'s>,
    pub(super) lattice: &'l ToolLattice,
    pub(super) is_along: bool,
    pub(super) radius_m: f64,
    /// How far apart the lines are that are tried.
    pub(super) step_m: f64,
    pub(super) worth: Worth,
}

/// A part of a line, and what driving it is worth, its turns not counted.
#[derive(Debug, Clone, Copy)]
struct Part {
    from_m: f64,
    to_m: f64,
    value: f64,
    swept: usize,
}

impl Lines<'_, '_> {
    pub(super) fn position(&self, point: Point) -> [f64; 2] {
        let [along, across] = self.lattice.position(point);
        if self.is_along { [along, across] } else { [across, along] }
    }

    fn point(&self, along_m: f64, across_m: f64) -> Point {
        self.lattice.point(if self.is_along { [along_m, across_m] } else { [across_m, along_m] })
    }

    fn middle_m(&self, run: &Run) -> f64 {
        let (column, row) = (run.squares[0] % self.lattice.columns, run.squares[0] / self.lattice.columns);
        (if run.is_along { row } else { column } as f64 + 0.5) * self.lattice.side_m
    }

    /// The samples of a run that are left.
    fn slab(&self, ground: &Ground, run: &Run) -> Slab {
        let number = |square: usize| [square % self.lattice.columns, square / self.lattice.columns];
        let (first, last) = (number(run.squares[0]), number(run.squares[run.squares.len() - 1]));
        let range = |axis: usize| {
            let of = |number| self.lattice.samples_in(ground.samples(), axis, number);
            of(first[axis]).start..of(last[axis]).end
        };
        let ranges = [range(0), range(1)];
        let corner = Cell::new(ranges[0].start as i32, ranges[1].start as i32);
        let first_m = self.position(ground.samples().center(corner));
        Slab::new(ground, ranges, first_m, self.is_along)
    }

    /// The lanes on the line near `middle_m` that is worth the most for some samples.
    pub(super) fn best(
        &self,
        transfers: &mut Transfers<'_, '_>,
        samples: Samples<'_>,
        middle_m: f64,
        aside_m: f64,
    ) -> Vec<Lane> {
        let step_m = self.step_m;
        let count = (aside_m / step_m + 1e-6) as i32;
        let middle = self.on_line(samples, middle_m, false);
        let mut best = (self.value(&middle), middle_m);
        let swept: usize = middle.iter().map(|part| part.swept).sum();
        if (swept as f64) < GOOD * samples.count() as f64 {
            for number in (1..=count).flat_map(|number| [number, -number]) {
                let across_m = middle_m + f64::from(number) * step_m;
                let value = self.value(&self.on_line(samples, across_m, false));
                if value > best.0 {
                    best = (value, across_m);
                }
            }
        }
        self.joined(transfers, &self.on_line(samples, best.1, true), best.1)
    }

    /// Parts that are near each other share the turns to and from them.
    fn groups<'p>(&self, parts: &'p [Part]) -> impl Iterator<Item = &'p [Part]> {
        let near_m = 2.0 * self.lattice.side_m;
        parts.chunk_by(move |one, next| next.from_m - one.to_m < near_m)
    }

    fn value_of_group(&self, group: &[Part]) -> f64 {
        let gaps_m: f64 = group.windows(2).map(|pair| pair[1].from_m - pair[0].to_m).sum();
        let parts: f64 = group.iter().map(|part| part.value).sum();
        // A bend takes some turning as well.
        let bends = 0.3 * (group.len() - 1) as f64 * self.worth.lane_turns;
        parts - gaps_m * self.worth.per_m - self.worth.lane_turns - bends
    }

    fn value(&self, parts: &[Part]) -> f64 {
        self.groups(parts).map(|group| self.value_of_group(group).max(0.0)).sum()
    }

    fn joined(&self, transfers: &mut Transfers<'_, '_>, parts: &[Part], across_m: f64) -> Vec<Lane> {
        let most_m = DETOUR_TOOLS * self.lattice.side_m;
        let mut lanes: Vec<Lane> = Vec::new();
        for group in self.groups(parts).filter(|group| self.value_of_group(group) > 0.0) {
            for (number, part) in group.iter().enumerate() {
                let (from, to) = (self.point(part.from_m, across_m), self.point(part.to_m, across_m));
                let before = lanes.last_mut().filter(|_| number > 0);
                let bent = before.and_then(|lane| {
                    let way = transfers.way(lane.to(), from)?;
                    (way.length_m <= (from - lane.to()).norm() + most_m).then_some((lane, way))
                });
                match bent {
                    Some((lane, way)) => {
                        lane.points.extend(&way.points[1..]);
                        lane.points.push(to);
                    }
                    None => lanes.push(Lane::straight(from, to)),
                }
            }
        }
        lanes
    }

    /// The parts of the line at `across_m` that are worth driving; ends are looked at closely where it is `fine`.
    fn on_line(&self, samples: Samples<'_>, across_m: f64, fine: bool) -> Vec<Part> {
        let profile = samples.profile(across_m, self.radius_m, fine);
        let line = Segment::new(self.point(profile.from_m, across_m), self.point(profile.to_m(), across_m));
        let mut parts = Vec::new();
        for (from_m, to_m) in self.space.slice(line) {
            let (low_m, high_m) = (profile.from_m + from_m, profile.from_m + to_m);
            let Some(swath) = profile.worthy(low_m, high_m, self.worth.per_m) else { continue };
            let part = self.part(swath, low_m, high_m);
            let is_reached = |along_m: f64| {
                let point = self.point(along_m, across_m);
                if fine { self.space.nearest_place(point).is_some() } else { self.space.is_reached_at(point) }
            };
            if is_reached(part.from_m) && is_reached(part.to_m) {
                parts.push(part);
            }
        }
        parts
    }

    fn part(&self, swath: Swath, low_m: f64, high_m: f64) -> Part {
        let Swath { mut from_m, mut to_m, swept } = swath;
        let value = swept as f64 - (to_m - from_m) * self.worth.per_m;
        let visit_m = VISIT_TOOLS * self.lattice.side_m;
        if to_m - from_m < visit_m {
            let middle_m = f64::midpoint(from_m, to_m);
            from_m = (middle_m - visit_m / 2.0).max(low_m);
            to_m = (middle_m + visit_m / 2.0).min(high_m);
        }
        Part { from_m, to_m, value, swept }
    }
}
