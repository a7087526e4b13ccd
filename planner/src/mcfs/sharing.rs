//! Shares closed lines among robots: cut at any length by chords, then evened out between neighbours.
//!
//! ```text
//!    ╭───────────╮          ╭───╮ ╭─────╮     a chord: two places of one line, side by side; exchanging
//!    │ ╭───────╮ │    ──▶   │ ╭─╯ ╰───╮ │     the links there makes two closed lines of it
//!    ╰─╯       ╰─╯          ╰─╯       ╰─╯
//! ```
//!
//! First one share after the other is cut off. Then two neighbours at a time are joined where that costs least, and
//! cut again where the longer of the two (line and drives there and back) is shortest: until nobody gains.

use super::drive::{Drives, Neighbours};
use super::walls::Walls;
use super::web::{Exchange, SPACING, Web};
use std::collections::BTreeSet;

/// Pairs of shares closer than this part of their length are left as they are.
const EVEN: f64 = 5e-4;
/// Way that one radian of turning at a chord is worth, as a share of the tool's width: evenness counts more.
const TURN_WORTH: f64 = 0.6;

/// How much the sum of two lines counts beside the longer of them.
const SUM_WORTH: f64 = 0.2;
/// Pairs farther apart than this part of their length are joined at several places in turn.
const UNEVEN: f64 = 2e-3;
/// Of pairs farther apart than this part of their length only the way counts, not what both sweep.
const FAR_APART: f64 = 1e-2;
/// Places that are linked when lines are joined are no farther apart, in tool widths.
const JOIN_REACH: f64 = 1.6;
/// A part to hand over is looked for from so many stretches of a line.
const GIVEN: usize = 8;
/// At so many places.
const JOINS: usize = 8;
/// Share of the turning that recutting adds, in way, that the gain must be beyond.
const PAIR_TURN: f64 = 0.5;

/// So many chords of a line are compared by the ground that both sides of them sweep.
const CUTS: usize = 8;
/// Shares are peeled off at every third place, for they are evened out later.
const COARSE: usize = 3;
/// Way that it is worth that one metre less is swept by two robots: the second one need not have come.
const OVERLAP_WORTH: f64 = 1.0;
/// What a drive costs for its length: there, back, and over ground that another robot sweeps.
const DRIVE_COST: f64 = 2.0 + OVERLAP_WORTH;

/// One robot's closed line.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Share {
    pub(super) robot: usize,
    pub(super) line: Vec<u32>,
}

/// All that is needed to cut and join.
pub(super) struct Sharing<'a> {
    pub(super) web: &'a mut Web,
    pub(super) walls: &'a Walls,
    pub(super) neighbours: &'a Neighbours,
    /// Per robot; `None` when it reaches no place.
    pub(super) drives: &'a [Option<Drives>],
    /// Per robot: what smoothing will add to its way (mostly below 0), metres.
    pub(super) corrections_m: Vec<f64>,
}

/// Where a line is cut in two: it goes on from position `first` right after position `last`.
#[derive(Debug, Clone, Copy)]
struct Chord {
    first: usize,
    last: usize,
    inner_m: f64,
    outer_m: f64,
    score_m: f64,
    inner_robot: usize,
    outer_robot: usize,
}

impl Sharing<'_> {
    /// Evens out until nobody gains, or for so many rounds. `stay_worth`: what leaving way with its robot is worth.
    pub(super) fn settle(&mut self, shares: &mut [Share], rounds: usize, stay_worth: f64) {
        // Pairs that have gained nothing and have not changed since.
        let mut settled = BTreeSet::new();
        for _ in 0..rounds {
            if !self.even_out(shares, &mut settled, stay_worth) {
                break;
            }
        }
    }

    /// Cuts one share after the other off a line: the first at the best chord but `rank`, the others at the best.
    pub(super) fn peel(&mut self, line: Vec<u32>, mut robots: Vec<usize>, rank: usize) -> Vec<Share> {
        let mut shares = Vec::new();
        let mut rest = line;
        while robots.len() > 1 {
            let rank = if shares.is_empty() { rank } else { 0 };
            let Some(chord) = self.best_peel(&rest, &robots, rank) else { break };
            let (inner, outer) = self.cut(&rest, chord);
            robots.retain(|&robot| robot != chord.inner_robot);
            shares.push(Share { robot: chord.inner_robot, line: inner });
            rest = outer;
        }
        shares.push(Share { robot: robots[0], line: rest });
        shares
    }

    /// The best chord but `rank` of those that cut off a fair share for some robot.
    fn best_peel(&self, line: &[u32], robots: &[usize], rank: usize) -> Option<Chord> {
        let ruler = Ruler::new(self, line, robots);
        let drives_m: f64 = (0..robots.len()).map(|slot| DRIVE_COST * ruler.whole_m(slot)).sum();
        let fair_m = (ruler.length_m() + drives_m) / robots.len() as f64;
        let rest_m = fair_m * (robots.len() - 1) as f64;
        let chords = self.best_chords::<CUTS>(
            line,
            &ruler,
            COARSE,
            |_, _| true,
            |cutting| {
                let drives_m = |slot: usize| cutting.outer_cost_m(slot) - cutting.outer_m;
                let all_drives_m: f64 = (0..robots.len()).map(drives_m).sum();
                let mut best: Option<(f64, usize, usize)> = None;
                for (slot, &robot) in robots.iter().enumerate() {
                    let there_m = cutting.inner_cost_m(slot);
                    let rest_need_m = cutting.outer_m + all_drives_m - drives_m(slot);
                    let worst = (there_m / fair_m).max(rest_need_m / rest_m) * fair_m
                        + SUM_WORTH * (there_m + rest_need_m);
                    if best.is_none_or(|(least, ..)| worst < least) {
                        best = Some((worst, robot, usize::MAX));
                    }
                }
                best
            },
        );
        let chords = self.least_overlapping(line, chords);
        chords.get(rank).or(chords.last()).copied()
    }

    /// Joins and cuts again pairs of neighbours; whether anything got better.
    fn even_out(
        &mut self,
        shares: &mut [Share],
        settled: &mut BTreeSet<(usize, usize)>,
        stay_worth: f64,
    ) -> bool {
        let mut better = false;
        let mut order: Vec<(usize, usize)> =
            (0..shares.len()).flat_map(|a| (0..a).map(move |b| (b, a))).collect();
        let costs: Vec<f64> = shares.iter().map(|share| self.cost_m(share)).collect();
        order.sort_by(|&(a, b), &(c, d)| costs[c].max(costs[d]).total_cmp(&costs[a].max(costs[b])));
        for (a, b) in order {
            let is_even = stay_worth > 0.0 && self.are_even(&shares[a], &shares[b]);
            if is_even || settled.contains(&(a, b)) {
                continue;
            }
            let evened = self.even_pair(shares, a, b, stay_worth);
            let (longer, shorter) =
                if self.cost_m(&shares[a]) >= self.cost_m(&shares[b]) { (a, b) } else { (b, a) };
            if self.hand_over(shares, longer, shorter) || evened {
                better = true;
                settled.retain(|&(one, other)| ![a, b].contains(&one) && ![a, b].contains(&other));
            } else {
                settled.insert((a, b));
            }
        }
        better
    }

    fn are_even(&self, one: &Share, other: &Share) -> bool {
        let [one_m, other_m] = [self.cost_m(one), self.cost_m(other)];
        (one_m - other_m).abs() < EVEN * one_m.max(other_m)
    }

    /// Cuts a part off one share and joins it to another one.
    fn hand_over(&mut self, shares: &mut [Share], from: usize, to: usize) -> bool {
        let before_m = [self.cost_m(&shares[from]), self.cost_m(&shares[to])];
        if before_m[0] - before_m[1] < EVEN * before_m[0] {
            return false;
        }
        let (giver, taker) = (shares[from].clone(), shares[to].clone());
        let touching = self.touching(&giver.line, &taker.line);
        if touching.last() == Some(&0) {
            return false;
        }
        let ruler = Ruler::new(self, &giver.line, &[giver.robot]);
        // The robot of the part that is kept is the giver's; of the part given none yet.
        let kept_m = self.corrections_m[giver.robot];
        let may_do = |inner_m: f64, outer_m: f64| {
            let gives = |given_m: f64, left_m: f64| (before_m[1] + given_m).max(left_m + kept_m);
            gives(inner_m, outer_m).min(gives(outer_m, inner_m)) < before_m[0]
        };
        let chords = self.best_chords::<GIVEN>(&giver.line, &ruler, 1, may_do, |cutting| {
            let touches_inside = touching[cutting.last + 1] - touching[cutting.first];
            let touches_outside = touching[giver.line.len()] - touches_inside;
            let give_inner = cutting.outer_cost_m(0).max(before_m[1] + cutting.inner_m);
            let give_outer = cutting.inner_cost_m(0).max(before_m[1] + cutting.outer_m);
            let inner = (touches_inside > 0).then_some((give_inner, usize::MAX, giver.robot));
            let outer = (touches_outside > 0).then_some((give_outer, giver.robot, usize::MAX));
            let best = [inner, outer].into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));
            best.filter(|best| best.0 < before_m[0])
        });
        let handed = chords.into_iter().find_map(|chord| self.handed(&giver, &taker, chord, before_m[0]));
        let Some((kept, grown)) = handed else { return false };
        (shares[from], shares[to]) = (kept, grown);
        true
    }

    /// What two shares become when a chord cuts a part off one that the other takes, if both cost less than `most_m`.
    fn handed(&mut self, giver: &Share, taker: &Share, chord: Chord, most_m: f64) -> Option<(Share, Share)> {
        let (inner, outer) = self.cut(&giver.line, chord);
        let (kept, given) = if chord.inner_robot == giver.robot { (inner, outer) } else { (outer, inner) };
        if let Some(exchange) = self.best_join(&given, &taker.line) {
            self.web.apply(exchange);
            let kept = Share { robot: giver.robot, line: kept };
            let grown = Share { robot: taker.robot, line: self.web.closed_line(exchange.one.0) };
            if self.cost_m(&kept).max(self.cost_m(&grown)) < most_m * (1.0 - EVEN / 4.0) {
                return Some((kept, grown));
            }
            self.web.apply(exchange.undone());
        }
        self.undo(&giver.line, chord);
        None
    }

    /// Up to each position of a line, how many places lie beside another line.
    fn touching(&self, line: &[u32], other: &[u32]) -> Vec<u32> {
        let is_other = self.marks(other);
        let mut touching = vec![0];
        for &place in line {
            let touches = self.neighbours.of(place).iter().any(|&beside| is_other[beside as usize]);
            touching.push(touching[touching.len() - 1] + u32::from(touches));
        }
        touching
    }

    /// Up to each position of a line, how many places belong to a part of it.
    fn up_to(&self, line: &[u32], part: &[u32]) -> Vec<u32> {
        let is_part = self.marks(part);
        let mut counts = vec![0];
        for &place in line {
            counts.push(counts[counts.len() - 1] + u32::from(is_part[place as usize]));
        }
        counts
    }

    fn marks(&self, line: &[u32]) -> Vec<bool> {
        let mut marks = vec![false; self.web.len()];
        for &place in line {
            marks[place as usize] = true;
        }
        marks
    }

    fn even_pair(&mut self, shares: &mut [Share], a: usize, b: usize, stay_worth: f64) -> bool {
        let before_m = [self.cost_m(&shares[a]), self.cost_m(&shares[b])];
        let (most_m, least_m) = (before_m[0].max(before_m[1]), before_m[0].min(before_m[1]));
        let before = PairBefore {
            score_m: score_m(most_m, least_m),
            least_gain_m: most_m * EVEN / 4.0,
            stay_worth,
            overlap_worth: if most_m - least_m > FAR_APART * most_m { 0.0 } else { OVERLAP_WORTH },
        };
        let joins = self.joins(&shares[a].line, &shares[b].line);
        let tries = if most_m - least_m > UNEVEN * most_m { JOINS } else { 1 };
        joins.into_iter().take(tries).any(|exchange| self.recut(shares, (a, b), exchange, &before))
    }

    /// Joins two shares there and cuts them again where that is best.
    fn recut(
        &mut self,
        shares: &mut [Share],
        (a, b): (usize, usize),
        exchange: Exchange,
        before: &PairBefore,
    ) -> bool {
        let (one, other) = (shares[a].clone(), shares[b].clone());
        let turn_m = TURN_WORTH * self.web.width_m * self.web.cost(exchange).turn_rad;
        self.web.apply(exchange);
        let line = self.web.closed_line(exchange.one.0);
        let robots = [one.robot, other.robot];
        let ruler = Ruler::new(self, &line, &robots);
        let ones = self.up_to(&line, &one.line);
        let place_m = before.stay_worth * ruler.length_m() / line.len() as f64;
        let less_m = robots.map(|robot| self.corrections_m[robot]).into_iter().fold(0.0, f64::min);
        let may_do =
            |inner_m: f64, outer_m: f64| score_m(inner_m + less_m, outer_m + less_m) < before.score_m;
        let chords = self.best_chords::<CUTS>(&line, &ruler, 1, may_do, |cutting| {
            // Places that change hands when `one` gets the part inside.
            let inside = cutting.last + 1 - cutting.first;
            let inside_ones = (ones[cutting.last + 1] - ones[cutting.first]) as usize;
            let moved = one.line.len() - inside_ones + inside - inside_ones;
            let stays = line.len() - moved;
            let straight = score_m(cutting.inner_cost_m(0), cutting.outer_cost_m(1)) + place_m * moved as f64;
            let swapped = score_m(cutting.inner_cost_m(1), cutting.outer_cost_m(0)) + place_m * stays as f64;
            let best = if straight <= swapped {
                (straight, robots[0], robots[1])
            } else {
                (swapped, robots[1], robots[0])
            };
            Some(best)
        });
        if let Some(&chord) = self.least_overlapping(&line, chords).first() {
            let overlap_m =
                self.overlap_m(&line, &line[chord.first..=chord.last]) - self.overlap_m(&line, &one.line);
            let turns_m = turn_m
                + TURN_WORTH
                    * self.web.width_m
                    * self.web.cost(exchange_of(&line, chord.first, chord.last)).turn_rad;
            let (inner, outer) = self.cut(&line, chord);
            let pair = [
                Share { robot: chord.inner_robot, line: inner },
                Share { robot: chord.outer_robot, line: outer },
            ];
            let [one_m, other_m] = pair.each_ref().map(|share| self.cost_m(share));
            let cost_m =
                score_m(one_m, other_m) + PAIR_TURN * turns_m.max(0.0) + before.overlap_worth * overlap_m;
            if cost_m < before.score_m - before.least_gain_m {
                [shares[a], shares[b]] = pair;
                return true;
            }
            self.undo(&line, chord);
        }
        self.web.apply(exchange.undone());
        false
    }

    /// Line and drives of a share, with what smoothing adds, metres.
    pub(super) fn cost_m(&self, share: &Share) -> f64 {
        let line = &share.line;
        let next = line.iter().cycle().skip(1);
        let line_m: f64 = line.iter().zip(next).map(|(&a, &b)| self.web.distance_m(a, b)).sum();
        line_m + DRIVE_COST * self.drive_m(share.robot, line) + self.corrections_m[share.robot]
    }

    pub(super) fn drive_m(&self, robot: usize, line: &[u32]) -> f64 {
        let Some(drives) = &self.drives[robot] else { return f64::INFINITY };
        line.iter().map(|&place| drives.distance_m[place as usize]).fold(f64::INFINITY, f64::min)
    }

    /// The cheapest exchange that joins two lines.
    pub(super) fn best_join(&self, one: &[u32], other: &[u32]) -> Option<Exchange> {
        self.joins(one, other).first().copied()
    }

    /// The cheapest exchanges along each part of a line that join it to another, the best first.
    fn joins(&self, one: &[u32], other: &[u32]) -> Vec<Exchange> {
        let is_other = self.marks(other);
        let reach_m = JOIN_REACH * self.web.width_m;
        let mut best: [Option<(f64, Exchange)>; JOINS] = [None; JOINS];
        for (at, &place) in one.iter().enumerate() {
            let best = &mut best[at * JOINS / one.len()];
            let beside = self.neighbours.of(place).iter().filter(|&&beside| is_other[beside as usize]);
            for exchange in beside.flat_map(|&beside| super::joining::exchanges(self.web, place, beside)) {
                if !self.is_candidate(&exchange) || !super::joining::may_pay(self.web, exchange, reach_m) {
                    continue;
                }
                let value_m = self.web.cost(exchange).value_m(self.web.width_m);
                if best.is_none_or(|(least_m, _)| value_m < least_m) && self.allows(exchange) {
                    *best = Some((value_m, exchange));
                }
            }
        }
        let mut joins: Vec<(f64, Exchange)> = best.into_iter().flatten().collect();
        joins.sort_by(|a, b| a.0.total_cmp(&b.0));
        joins.into_iter().map(|(_, exchange)| exchange).collect()
    }

    /// Earlier joints are all looked at, of the stretches of tracks every third place: neighbours are alike.
    fn is_candidate(&self, exchange: &Exchange) -> bool {
        let Exchange { one: (a, a2), other: (b, b2) } = *exchange;
        a % 3 == 0 || !self.web.is_short(a, a2) || !self.web.is_short(b, b2)
    }

    /// Chords by their scores when ground that both sides of them sweep counts, too; the least first.
    fn least_overlapping(&self, line: &[u32], mut chords: Vec<Chord>) -> Vec<Chord> {
        for chord in &mut chords {
            chord.score_m += OVERLAP_WORTH * self.overlap_m(line, &line[chord.first..=chord.last]);
        }
        chords.sort_by(|a, b| a.score_m.total_cmp(&b.score_m));
        chords
    }

    /// How much of the way of one part of a line is swept by the rest of it, too: metres at the tool's full width.
    fn overlap_m(&self, line: &[u32], part: &[u32]) -> f64 {
        let (is_line, is_part) = (self.marks(line), self.marks(part));
        let width_m = self.web.width_m;
        let swept_twice_m = |&place: &u32| {
            let rest = self
                .neighbours
                .of(place)
                .iter()
                .filter(|&&beside| is_line[beside as usize] && !is_part[beside as usize]);
            let apart_m = rest.map(|&beside| self.web.distance_m(place, beside)).fold(width_m, f64::min);
            SPACING * (width_m - apart_m)
        };
        part.iter().map(swept_twice_m).sum()
    }

    /// The best chord that begins in each of N parts of a line, the best first; every `step`th place is tried; `judge` says
    /// makespan, robot inside and robot outside from the two lengths and the drives of each robot to either; `may_do`,
    /// whether lengths inside and outside are worth a closer look.
    fn best_chords<const N: usize>(
        &self,
        line: &[u32],
        ruler: &Ruler,
        step: usize,
        may_do: impl Fn(f64, f64) -> bool,
        judge: impl Fn(&Cutting<'_>) -> Option<(f64, usize, usize)>,
    ) -> Vec<Chord> {
        let mut position = vec![u32::MAX; self.web.len()];
        line.iter().enumerate().for_each(|(at, &place)| position[place as usize] = at as u32);
        let mut chords: [Option<Chord>; N] = [None; N];
        for (before_first, &place) in line.iter().enumerate().step_by(step) {
            let best = &mut chords[before_first * N / line.len()];
            for &beside in self.neighbours.of(place) {
                let after_last = position[beside as usize];
                if after_last == u32::MAX || (after_last as usize) < before_first + 4 {
                    continue;
                }
                let (first, last) = (before_first + 1, after_last as usize - 1);
                let around_m = ruler.length_m() - ruler.between_m(before_first, after_last as usize);
                if !may_do(ruler.between_m(first, last), around_m) {
                    continue;
                }
                let exchange = exchange_of(line, first, last);
                let closing_m = self.web.distance_m(line[last], line[first]);
                let passing_m = self.web.distance_m(place, beside);
                if closing_m > 2.5 * self.web.width_m {
                    continue;
                }
                let inner_m = ruler.between_m(first, last) + closing_m;
                let outer_m = around_m + passing_m;
                let cutting = Cutting { ruler, first, last, inner_m, outer_m };
                let Some((worst_m, inner_robot, outer_robot)) = judge(&cutting) else { continue };
                if best.is_some_and(|best| worst_m >= best.score_m) {
                    continue;
                }
                let turn_m = TURN_WORTH * self.web.width_m * self.web.cost(exchange).turn_rad;
                let score_m = worst_m + turn_m.max(0.0);
                if best.is_none_or(|best| score_m < best.score_m) && self.allows(exchange) {
                    *best = Some(Chord { first, last, inner_m, outer_m, score_m, inner_robot, outer_robot });
                }
            }
        }
        let mut chords: Vec<Chord> = chords.into_iter().flatten().collect();
        chords.sort_by(|a, b| a.score_m.total_cmp(&b.score_m));
        chords
    }

    fn allows(&self, exchange: Exchange) -> bool {
        self.web.allows(exchange, self.walls) && !self.web.crosses(exchange)
    }

    fn cut(&mut self, line: &[u32], chord: Chord) -> (Vec<u32>, Vec<u32>) {
        debug_assert!(chord.inner_m + chord.outer_m > 0.0);
        self.web.apply(exchange_of(line, chord.first, chord.last));
        let inner = line[chord.first..=chord.last].to_vec();
        let outer = [&line[chord.last + 1..], &line[..chord.first]].concat();
        (inner, outer)
    }

    fn undo(&mut self, line: &[u32], chord: Chord) {
        self.web.apply(exchange_of(line, chord.first, chord.last).undone());
    }
}

/// A chord while it is judged.
struct Cutting<'a> {
    ruler: &'a Ruler,
    first: usize,
    last: usize,
    inner_m: f64,
    outer_m: f64,
}

impl Cutting<'_> {
    /// The part within and what the drives of a robot cost, metres.
    fn inner_cost_m(&self, slot: usize) -> f64 {
        self.inner_m
            + self.ruler.corrections_m[slot]
            + DRIVE_COST * self.ruler.inside_m(slot, self.first, self.last)
    }

    fn outer_cost_m(&self, slot: usize) -> f64 {
        self.outer_m
            + self.ruler.corrections_m[slot]
            + DRIVE_COST * self.ruler.outside_m(slot, self.first, self.last)
    }
}

/// What recutting a pair must improve on.
struct PairBefore {
    score_m: f64,
    least_gain_m: f64,
    stay_worth: f64,
    overlap_worth: f64,
}

/// The longer of two lines; less way in all counts a little, for it is evened out among all in the end.
fn score_m(one_m: f64, other_m: f64) -> f64 {
    one_m.max(other_m) + SUM_WORTH * (one_m + other_m)
}

/// Cuts `first..=last` out of a line: its ends are linked, and what lies around them.
fn exchange_of(line: &[u32], first: usize, last: usize) -> Exchange {
    let (before, after) = (line[(first + line.len() - 1) % line.len()], line[(last + 1) % line.len()]);
    Exchange { one: (before, line[first]), other: (after, line[last]) }
}

/// Lengths along a line and the shortest drives to any part of it.
struct Ruler {
    up_to_m: Vec<f64>,
    /// Per robot: shortest drive to each stretch of 2^level places.
    drives_m: Vec<Vec<Vec<f64>>>,
    corrections_m: Vec<f64>,
    places: usize,
}

impl Ruler {
    fn new(sharing: &Sharing<'_>, line: &[u32], robots: &[usize]) -> Self {
        let mut up_to_m = vec![0.0];
        for (at, &place) in line.iter().enumerate() {
            let next = line[(at + 1) % line.len()];
            up_to_m.push(up_to_m[at] + sharing.web.distance_m(place, next));
        }
        let drives_m = robots.iter().map(|&robot| minima(sharing, line, robot)).collect();
        let corrections_m = robots.iter().map(|&robot| sharing.corrections_m[robot]).collect();
        Self { up_to_m, drives_m, corrections_m, places: line.len() }
    }

    fn length_m(&self) -> f64 {
        self.up_to_m[self.places]
    }

    fn between_m(&self, first: usize, last: usize) -> f64 {
        self.up_to_m[last] - self.up_to_m[first]
    }

    fn whole_m(&self, slot: usize) -> f64 {
        self.inside_m(slot, 0, self.places - 1)
    }

    fn inside_m(&self, slot: usize, first: usize, last: usize) -> f64 {
        let count = last + 1 - first;
        let level = count.ilog2() as usize;
        let stretches = &self.drives_m[slot][level];
        stretches[first].min(stretches[last + 1 - (1 << level)])
    }

    fn outside_m(&self, slot: usize, first: usize, last: usize) -> f64 {
        let before = if first > 0 { self.inside_m(slot, 0, first - 1) } else { f64::INFINITY };
        let after = if last + 1 < self.places {
            self.inside_m(slot, last + 1, self.places - 1)
        } else {
            f64::INFINITY
        };
        before.min(after)
    }
}

fn minima(sharing: &Sharing<'_>, line: &[u32], robot: usize) -> Vec<Vec<f64>> {
    let drive = |&place: &u32| {
        sharing.drives[robot].as_ref().map_or(f64::INFINITY, |drives| drives.distance_m[place as usize])
    };
    let mut levels: Vec<Vec<f64>> = vec![line.iter().map(drive).collect()];
    let mut half = 1;
    while 2 * half <= line.len() {
        let below = &levels[levels.len() - 1];
        levels.push((0..=line.len() - 2 * half).map(|at| below[at].min(below[at + half])).collect());
        half *= 2;
    }
    levels
}
