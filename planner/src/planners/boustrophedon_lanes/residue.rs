//! What a tour leaves unswept is swept by bends of its lanes and by short lanes between them.
//!
//! Samples that are left and touch form a patch. A lane that passes by may bend towards it; or a short lane through it is
//! put between two others. Whatever sweeps the most for the time it takes comes first, until the coverage asked for
//! is reached.

use super::{placing::Lines, profile::Samples, ranked::Ranked};
use crate::{
    ground::Ground,
    lane_tour::{Lane, LaneTour},
};
use std::collections::BinaryHeap;
use terrain::{Point, Segment};

/// Patches of fewer samples are left, and so is what a change of the tour would sweep that sweeps fewer: this bounds the number of
/// changes by the samples that are left.
const PATCH_MIN: usize = 4;
/// Lanes that pass a patch that are looked at for a bend.
const PASSING: usize = 3;
/// How far before and after a patch a bend begins and ends, tool widths.
const BEND_TOOLS: [f64; 3] = [0.4, 0.8, 1.6];
/// How far a bend goes of the way that would sweep all of a patch.
const BEND_SHARES: [f64; 3] = [1.0, 0.8, 0.5];
/// Longest way to a patch that is swept by a bend, tool widths.
const ASIDE_TOOLS: f64 = 1.5;
/// Joins that are looked at closely for a new lane.
const TIME_MIN_S: f64 = 0.05;

/// Changes a tour until the coverage is `goal`, or as near to it as can be; `ground` has been swept by the tour. The
/// samples that the last change swept for each second it takes. Patches are looked at together that hold `breadth` times
/// what is missing, the largest first.
pub(super) fn sweep<'a>(
    tour: &mut LaneTour<'_, 'a>,
    ground: &mut Ground,
    lines: &[Lines<'_, 'a>; 2],
    goal: f64,
    breadth: f64,
) -> Option<f64> {
    let mut last_per_s = None;
    if ground.coverage() >= goal {
        return last_per_s;
    }
    let mut residue = Residue { passing: passing(tour), joins: tour.joins(), tour, ground, lines };
    let patches = patches(residue.ground.samples().columns as usize, residue.ground);
    let mut waiting = (0..patches.len()).peekable();
    let mut heap = BinaryHeap::new();
    while residue.ground.coverage() < goal {
        // The larger patches first, as many as hold a good deal more than is missing.
        if heap.is_empty() {
            let mut enough = breadth * residue.ground.missing(goal);
            while let Some(number) = waiting.next_if(|_| enough > 0.0) {
                enough -= patches[number].len() as f64;
                let change = residue.best_change(&patches[number]);
                heap.extend(change.map(|change| Ranked { number, per_s: change.per_s() }));
            }
        }
        let Some(entry) = heap.pop() else {
            if waiting.peek().is_none() {
                break;
            }
            continue;
        };
        let patch = &patches[entry.number];
        // Changes before this one may have swept some of the patch, or changed the lane that would bend.
        let Some(change) = residue.best_change(patch).and_then(|change| residue.priced(change)) else {
            continue;
        };
        let per_s = change.per_s();
        if heap.peek().is_some_and(|next| next.per_s > per_s * 1.01) && per_s < 0.99 * entry.per_s {
            heap.push(Ranked { per_s, ..entry });
            continue;
        }
        last_per_s = Some(per_s);
        let before = residue.ground.left_count();
        residue.apply(change);
        if residue.ground.left_count() < before {
            heap.push(Ranked { per_s, ..entry });
        }
    }
    last_per_s
}

/// What can be done about a patch.
#[derive(Debug, Clone)]
struct Change {
    what: What,
    gain: f64,
    cost_s: f64,
}

#[derive(Debug, Clone)]
enum What {
    /// Another line for a lane.
    Bend(usize, Vec<Point>),
    New(Lane),
    /// A lane that the tour knows.
    Put(usize),
}

impl Change {
    fn per_s(&self) -> f64 {
        self.gain / self.cost_s.max(TIME_MIN_S)
    }
}

/// A straight part of a lane.
#[derive(Debug, Clone, Copy)]
struct Passing {
    lane: usize,
    number: usize,
    segment: Segment,
}

fn passing(tour: &LaneTour<'_, '_>) -> Vec<Passing> {
    (0..tour.len())
        .map(|at| tour.lane_at(at))
        .filter(|&lane| lane != 0)
        .flat_map(|lane| parts(tour, lane))
        .collect()
}

fn parts(tour: &LaneTour<'_, '_>, lane: usize) -> Vec<Passing> {
    let pairs = tour.lane(lane).points.windows(2).enumerate();
    pairs.map(|(number, pair)| Passing { lane, number, segment: Segment::new(pair[0], pair[1]) }).collect()
}

struct Residue<'r, 's, 'a> {
    tour: &'r mut LaneTour<'s, 'a>,
    ground: &'r mut Ground,
    lines: &'r [Lines<'r, 'a>; 2],
    passing: Vec<Passing>,
    joins: Vec<(Point, Point, f64)>,
}

impl Residue<'_, '_, '_> {
    fn tool_m(&self) -> f64 {
        self.lines[0].space.instance().floor.tool_width_m()
    }

    fn best_change(&mut self, patch: &[usize]) -> Option<Change> {
        let left: Vec<Point> = patch
            .iter()
            .filter(|&&sample| self.ground.is_left(sample))
            .map(|&sample| self.ground.point(sample))
            .collect();
        if left.len() < PATCH_MIN {
            return None;
        }
        let mut changes = self.bends(&left);
        changes.extend(self.new_lanes(&left));
        let is_enough = |change: &Change| change.gain >= PATCH_MIN as f64;
        changes.into_iter().filter(is_enough).max_by(|a, b| a.per_s().total_cmp(&b.per_s()))
    }

    fn bends(&mut self, left: &[Point]) -> Vec<Change> {
        let sum = left.iter().fold(terrain::Vector::zeros(), |sum, point| sum + point.coords);
        let middle = Point::from(sum / left.len() as f64);
        let reach_m = self.ground.radius_m() + ASIDE_TOOLS * self.tool_m();
        let mut near: Vec<(f64, Passing)> = self
            .passing
            .iter()
            .map(|&passing| (passing.segment.distance_to_point(middle), passing))
            .filter(|(distance_m, _)| *distance_m <= reach_m)
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        near.truncate(PASSING);
        let mut best_per_s = 0.0;
        near.into_iter().flat_map(|(_, passing)| self.bends_of(passing, left, &mut best_per_s)).collect()
    }

    /// Only those that can be worth more than the best so far, samples per second, by what is left of the patch.
    fn bends_of(&mut self, passing: Passing, left: &[Point], best_per_s: &mut f64) -> Vec<Change> {
        let Segment { from, to } = passing.segment;
        let length_m = (to - from).norm();
        if length_m < 0.2 * self.tool_m() {
            return Vec::new();
        }
        let along = (to - from) / length_m;
        let across = terrain::Vector::new(-along.y, along.x);
        let position = |point: &Point| ((point - from).dot(&along), (point - from).dot(&across));
        let (mut low_m, mut high_m, mut farthest_m) = (length_m, 0.0_f64, 0.0_f64);
        for point in left {
            let (along_m, across_m) = position(point);
            low_m = low_m.min(along_m);
            high_m = high_m.max(along_m);
            if across_m.abs() > f64::abs(farthest_m) {
                farthest_m = across_m;
            }
        }
        let aside_m = farthest_m.signum() * (farthest_m.abs() - self.ground.radius_m() + 1e-3);
        if aside_m * farthest_m <= 0.0 || low_m >= length_m || high_m <= 0.0 {
            return Vec::new();
        }
        let (low_m, high_m) = (low_m.max(0.0), high_m.min(length_m));
        let mut found = Vec::new();
        for share in BEND_SHARES {
            let mut is_free = false;
            for bend_m in BEND_TOOLS.map(|tools| tools * self.tool_m()) {
                let begin_m = (low_m - bend_m).max(1e-3);
                let end_m = (high_m + bend_m).min(length_m - 1e-3);
                let mut tops_m = vec![low_m.max(begin_m + 1e-3), high_m.min(end_m - 1e-3)];
                if high_m - low_m < 0.3 * self.tool_m() {
                    tops_m = vec![f64::midpoint(low_m, high_m).clamp(begin_m + 1e-3, end_m - 1e-3)];
                }
                let mut bent = vec![from + along * begin_m];
                bent.extend(tops_m.iter().map(|top_m| from + along * *top_m + across * (aside_m * share)));
                bent.push(from + along * end_m);
                let Some((points, cost_s)) = self.bend(passing, &bent) else { continue };
                is_free = true;
                let mut change =
                    Change { gain: left.len() as f64, cost_s, what: What::Bend(passing.lane, points) };
                if change.per_s() > *best_per_s {
                    let ends = [from, to];
                    change.gain = self.gain_of_bend(&ends, &[&ends[..1], &bent, &ends[1..]].concat());
                    *best_per_s = best_per_s.max(change.per_s());
                    found.push(change);
                }
            }
            if is_free {
                break;
            }
        }
        found
    }

    /// A lane with a bend in one of its parts, and what that costs, seconds.
    fn bend(&self, passing: Passing, bent: &[Point]) -> Option<(Vec<Point>, f64)> {
        let space = self.lines[0].space;
        let is_free = bent.windows(2).all(|pair| space.segment_is_free(Segment::new(pair[0], pair[1])));
        if !is_free {
            return None;
        }
        let old = &self.tour.lane(passing.lane).points;
        let mut points = old[..=passing.number].to_vec();
        points.extend(bent);
        points.extend(&old[passing.number + 1..]);
        let motion = &space.instance().motion;
        let cost_s = motion.path_s(&points, None) - motion.path_s(old, None);
        Some((points, cost_s))
    }

    /// Samples that are swept when one line stands in for another.
    fn gain_of_bend(&mut self, old: &[Point], new: &[Point]) -> f64 {
        let before = self.ground.left_count();
        self.ground.sweep(new);
        self.ground.unsweep(old);
        let gain = before as f64 - self.ground.left_count() as f64;
        self.ground.sweep(old);
        self.ground.unsweep(new);
        gain
    }

    fn new_lanes(&mut self, left: &[Point]) -> Vec<Change> {
        let mut found = Vec::new();
        for lines in self.lines {
            let samples: Vec<[f64; 2]> = left.iter().map(|&point| lines.position(point)).collect();
            let low_m = samples.iter().map(|at| at[1]).fold(f64::INFINITY, f64::min);
            let high_m = samples.iter().map(|at| at[1]).fold(f64::NEG_INFINITY, f64::max);
            let aside_m = (high_m - low_m) / 2.0 + self.ground.radius_m();
            let samples = Samples::Loose(&samples, self.ground.samples().cell_m);
            for lane in lines.best(self.tour.transfers(), samples, f64::midpoint(low_m, high_m), aside_m) {
                let gain: usize =
                    lane.points.windows(2).map(|pair| self.ground.gain(Segment::new(pair[0], pair[1]))).sum();
                let cost_s = self.least_cost_s(&lane);
                found.push(Change { what: What::New(lane), gain: gain as f64, cost_s });
            }
        }
        found
    }

    /// No more than what a lane costs at its best place, turns left out.
    fn least_cost_s(&self, lane: &Lane) -> f64 {
        let speed = self.lines[0].space.instance().motion.speed_m_per_s;
        let inner_s = lane.length_m() / speed;
        let more_s = |&(before, after, join_s): &(Point, Point, f64)| {
            let one_m = (lane.from() - before).norm() + (after - lane.to()).norm();
            let other_m = (lane.to() - before).norm() + (after - lane.from()).norm();
            one_m.min(other_m) / speed + inner_s - join_s
        };
        self.joins.iter().map(more_s).fold(f64::INFINITY, f64::min).max(inner_s)
    }

    /// With the price that the tour gives.
    fn priced(&mut self, change: Change) -> Option<Change> {
        let What::New(lane) = change.what else { return Some(change) };
        let lane = self.tour.announce(lane);
        let cost_s = self.tour.cost_s(lane);
        cost_s.is_finite().then_some(Change { what: What::Put(lane), cost_s, ..change })
    }

    fn apply(&mut self, change: Change) {
        match change.what {
            What::Bend(lane, points) => {
                self.ground.sweep(&points);
                self.ground.unsweep(&self.tour.lane(lane).points.clone());
                self.tour.reshape(lane, points);
                self.passing.retain(|part| part.lane != lane);
                self.passing.extend(parts(self.tour, lane));
            }
            What::Put(lane) => {
                let at = self.tour.insert(lane);
                let [to, from, instead] = self.tour.ways_at(at);
                let points =
                    |way: Option<crate::transfers::Way>| way.map(|way| way.points).unwrap_or_default();
                self.ground.sweep(&points(to));
                self.ground.sweep(&points(from));
                self.ground.sweep(&self.tour.lane(lane).points.clone());
                self.ground.unsweep(&points(instead));
                self.passing.extend(parts(self.tour, lane));
                self.joins = self.tour.joins();
            }
            What::New(_) => unreachable!("lanes are announced before they are put"),
        }
    }
}

/// Samples that are left, gathered where they touch; the largest patches first.
fn patches(columns: usize, ground: &Ground) -> Vec<Vec<usize>> {
    let places = ground.samples().len();
    let mut seen = vec![false; places];
    let mut patches = Vec::new();
    for first in 0..places {
        if seen[first] || !ground.is_left(first) {
            continue;
        }
        seen[first] = true;
        let mut patch = vec![first];
        let mut next = 0;
        while next < patch.len() {
            let place = patch[next];
            next += 1;
            let column = place % columns;
            let around = [
                (column + 1 < columns).then(|| place + 1),
                (column > 0).then(|| place - 1),
                (place + columns < places).then(|| place + columns),
                place.checked_sub(columns),
            ];
            for near in around.into_iter().flatten() {
                if !seen[near] && ground.is_left(near) {
                    seen[near] = true;
                    patch.push(near);
                }
            }
        }
        if patch.len() >= PATCH_MIN {
            patches.push(patch);
        }
    }
    patches.sort_by_key(|patch| std::cmp::Reverse(patch.len()));
    patches
}
