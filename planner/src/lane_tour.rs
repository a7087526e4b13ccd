//! A short closed tour over lanes, each driven once, either way. Lanes come and go.
//!
//! **Problem.** A travelling salesman's tour over the ends of lanes in which the lanes themselves are fixed: the only
//! choice is the order, and the direction of each. What lies between two ends is a shortest way for the body
//! ([`crate::transfers`]), priced in time with the turns out of the one lane and into the other.
//! **Idea.** Which end is left and which one is entered fixes the headings there, so the price of a join belongs to a pair of
//! ends, and is the same both ways: a symmetric problem with fixed edges, and reversing a piece of the tour reverses its
//! lanes at no cost. Nearest lane first; then 2-opt and moves of up to three lanes (Or-opt, either way round) over lists of
//! near ends, with only those lanes looked at again of which something changed. Then, as long as there are steps left, two
//! short pieces of the tour change places (double bridge), the neighbourhood is improved again, and what has become worse is
//! taken back.
//! **Guarantee.** Each lane is on the tour once at any time; it never gets worse. None on quality.
//! **Complexity.** One bounded search per end for its near ends; ways, to these and to others, are searched for only when a
//! bound on their price (the distance, and the turn from the one heading to the other) promises a gain, and only as far as that. O(n) for a reversal.
//! **Paper.** 2-opt and Or-opt with near lists: J. J. Bentley: Fast algorithms for geometric traveling salesman problems. ORSA Journal on Computing 4, 1992.

use crate::transfers::{Targets, Transfers, Way, heading_rad};
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use terrain::{Point, Vector, angle_between};

/// Near ends that are kept for each end.
const NEAR: usize = 10;
/// How many lanes are moved together, at most.
const MOVED: usize = 3;
/// Longest piece that a double bridge moves.
const BRIDGE: usize = 12;
/// Exchanges that cost more than this at once are not tried, seconds.
const BRIDGE_S: f64 = 25.0;
/// What counts as better, seconds.
const BETTER_S: f64 = 1e-7;
/// The place of a lane that is not on the tour.
const OUT: u32 = u32::MAX;
/// The way of two ends of which only a bound on the price is known.
const UNKNOWN: u32 = u32::MAX;

/// A line of points that is free for the body all along, straight where nothing is in the way. One point (or the same one
/// twice) is a place that is only visited.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lane {
    pub(crate) points: Vec<Point>,
}

impl Lane {
    /// Straight from one point to another.
    pub(crate) fn straight(from: Point, to: Point) -> Self {
        Self { points: vec![from, to] }
    }

    pub(crate) fn from(&self) -> Point {
        self.points[0]
    }

    pub(crate) fn to(&self) -> Point {
        self.points[self.points.len() - 1]
    }

    pub(crate) fn length_m(&self) -> f64 {
        self.points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
    }

    /// From the other end.
    pub(crate) fn reversed(&self) -> Self {
        Self { points: self.points.iter().rev().copied().collect() }
    }

    /// Headings out of its first end and its last one.
    fn outward_rad(&self) -> [Option<f64>; 2] {
        let heading = |from: Point, to: Point| ((to - from).norm() > 1e-9).then(|| heading_rad(from, to));
        let (points, last) = (&self.points, self.points.len() - 1);
        [heading(points[1.min(last)], points[0]), heading(points[last.saturating_sub(1)], points[last])]
    }
}

/// Lanes with the prices between their ends. End `2 n` is the first of lane n, `2 n + 1` the other one; `end ^ 1` is
/// the other end of the same lane. Lane 0 is the place where the tour begins and ends.
#[derive(Debug)]
pub(crate) struct LaneTour<'s, 'a> {
    transfers: Transfers<'s, 'a>,
    targets: Targets,
    lanes: Vec<Lane>,
    ends: Vec<Point>,
    /// Per end: heading out of its lane.
    outward_rad: Vec<Option<f64>>,
    /// Per end, by number of the other end: price and way from this end to that one. Where the way is [`UNKNOWN`], the
    /// price is more than that.
    known: Vec<Vec<(u32, f64, u32)>>,
    ways: Vec<Option<Way>>,
    /// Per end: ends near it, those first that can be the cheapest to join.
    near: Vec<Vec<NearEnd>>,
    /// Ends by which lanes are entered, in the order of driving.
    order: Vec<u32>,
    /// Per lane, its place in the order; [`OUT`] for one that is not on the tour.
    at: Vec<u32>,
    /// Per lane, whether it was taken out.
    is_gone: Vec<bool>,
    /// Whether the way back to lane 0 counts.
    returns: bool,
}

/// An end near another one, and what joining them takes at least, as a rule, seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
struct NearEnd {
    end: u32,
    at_least_s: f64,
}

/// A lane on the tour, in the direction of driving, and the way to it.
#[derive(Debug, Clone)]
pub(crate) struct Stop {
    pub(crate) lane: Lane,
    pub(crate) way: Way,
}

impl<'s, 'a> LaneTour<'s, 'a> {
    /// Over lanes that can all be reached from `start`, the nearest lane first.
    pub(crate) fn new(transfers: Transfers<'s, 'a>, start: Point, lanes: Vec<Lane>, returns: bool) -> Self {
        let mut tour = Self {
            targets: Targets::new(transfers.space(), Vec::new()),
            transfers,
            lanes: Vec::new(),
            ends: Vec::new(),
            outward_rad: Vec::new(),
            known: Vec::new(),
            near: Vec::new(),
            ways: Vec::new(),
            order: Vec::new(),
            at: Vec::new(),
            is_gone: Vec::new(),
            returns,
        };
        tour.know(Lane::straight(start, start));
        for lane in lanes {
            tour.know(lane);
        }
        tour.find_near_ends(0);
        tour.order = tour.nearest_first();
        tour.number_from(0, tour.order.len());
        tour
    }

    fn know(&mut self, lane: Lane) {
        self.outward_rad.extend(lane.outward_rad());
        for point in [lane.from(), lane.to()] {
            self.targets.push(self.transfers.space(), point);
            self.ends.push(point);
            self.known.push(Vec::new());
            self.near.push(Vec::new());
        }
        self.lanes.push(lane);
        self.at.push(OUT);
        self.is_gone.push(false);
    }

    /// Makes a lane known that is not on the tour yet: its number.
    pub(crate) fn announce(&mut self, lane: Lane) -> usize {
        self.know(lane);
        let number = self.lanes.len() - 1;
        self.find_near_ends(2 * number);
        self.is_gone[number] = true;
        number
    }

    /// Seconds that a lane that is not on the tour would add.
    pub(crate) fn cost_s(&mut self, lane: usize) -> f64 {
        let motion = self.transfers.space().instance().motion;
        motion.path_s(&self.lanes[lane].points, None) + self.cheapest_place(2 * lane).0
    }

    /// Puts a lane that is not on the tour where it costs least; its place in the order.
    pub(crate) fn insert(&mut self, lane: usize) -> usize {
        let (_, place, entry) = self.cheapest_place(2 * lane);
        self.is_gone[lane] = false;
        self.order.insert(place, entry as u32);
        self.number_from(0, self.order.len());
        place
    }

    /// The ways to and from a place of the order, and the way that is driven without it.
    pub(crate) fn ways_at(&mut self, at: usize) -> [Option<Way>; 3] {
        let lanes = self.order.len();
        let (before, entry, after) = (self.exit(at + lanes - 1), self.entry(at), self.entry(at + 1));
        // Where nobody has to return, what leads to the first end of lane 0 is not driven.
        [(before, entry), (entry ^ 1, after), (before, after)].map(|(from, to)| {
            let is_driven = self.returns || from.min(to) != 0;
            if is_driven { self.way(from, to) } else { None }
        })
    }

    /// Where the joins of the tour begin and end, and the seconds they take.
    pub(crate) fn joins(&mut self) -> Vec<(Point, Point, f64)> {
        (0..self.order.len())
            .map(|at| {
                let (from, to) = (self.exit(at), self.entry(at + 1));
                (self.ends[from], self.ends[to], self.price(from, to))
            })
            .collect()
    }

    /// Seconds that a lane adds at the best place among its near ends, that place and the end by which it is entered.
    fn cheapest_place(&mut self, first: usize) -> (f64, usize, usize) {
        let lanes = self.order.len();
        let mut best = (f64::INFINITY, lanes, first);
        for (end, near) in [first, first + 1]
            .into_iter()
            .flat_map(|end| self.near[end].iter().map(move |near| (end, near.end as usize)))
            .collect::<Vec<_>>()
        {
            if self.at[near / 2] == OUT {
                continue;
            }
            let near_at = self.at[near / 2] as usize;
            let follows = !self.is_entry(near);
            let (before_at, after_at) =
                if follows { (near_at, near_at + 1) } else { (near_at + lanes - 1, near_at) };
            let (before, after) = (self.exit(before_at), self.entry(after_at));
            let entry = if follows { end } else { end ^ 1 };
            let freed_s = self.price(before, after);
            let most_s = best.0 + freed_s;
            let least_s = self.price_at_least(entry ^ 1, after);
            let Some(to_s) = self.price_below(before, entry, most_s - least_s) else { continue };
            let Some(from_s) = self.price_below(entry ^ 1, after, most_s - to_s) else { continue };
            best = (to_s + from_s - freed_s, (before_at % lanes) + 1, entry);
        }
        best
    }

    /// What taking the lane at a place of the order out saves, seconds.
    pub(crate) fn saving_s(&mut self, at: usize) -> f64 {
        let (before, after) = self.ends_around(at);
        self.taken_s(at) - self.price(before, after)
    }

    /// As [`Self::saving_s`], or a little more: as if the way without the lane were straight.
    pub(crate) fn most_saving_s(&mut self, at: usize) -> f64 {
        let (before, after) = self.ends_around(at);
        self.taken_s(at) - self.price_at_least(before, after)
    }

    fn ends_around(&self, at: usize) -> (usize, usize) {
        (self.exit(at + self.order.len() - 1), self.entry(at + 1))
    }

    /// The lane at a place of the order, and the ways to it and from it, seconds.
    fn taken_s(&mut self, at: usize) -> f64 {
        let ((before, after), entry) = (self.ends_around(at), self.entry(at));
        let motion = self.transfers.space().instance().motion;
        let inner_s = motion.path_s(&self.lanes[entry / 2].points, None);
        inner_s + self.price(before, entry) + self.price(entry ^ 1, after)
    }

    /// Takes the lane at a place of the order out.
    pub(crate) fn remove(&mut self, at: usize) {
        let entry = self.order.remove(at);
        self.at[entry as usize / 2] = OUT;
        self.is_gone[entry as usize / 2] = true;
        self.number_from(0, self.order.len());
    }

    /// The number of the lane at a place of the order; 0 is where the tour begins.
    pub(crate) fn lane_at(&self, at: usize) -> usize {
        self.order[at] as usize / 2
    }

    /// The place of a lane in the order.
    pub(crate) fn place_of(&self, lane: usize) -> Option<usize> {
        (self.at[lane] != OUT).then_some(self.at[lane] as usize)
    }

    pub(crate) fn lane(&self, lane: usize) -> &Lane {
        &self.lanes[lane]
    }

    /// Another line between the same ends for a lane, with the same headings at both.
    pub(crate) fn reshape(&mut self, lane: usize, points: Vec<Point>) {
        self.lanes[lane].points = points;
    }

    pub(crate) fn len(&self) -> usize {
        self.order.len()
    }

    pub(crate) fn transfers(&mut self) -> &mut Transfers<'s, 'a> {
        &mut self.transfers
    }

    /// Seconds of the whole tour.
    pub(crate) fn time_s(&mut self) -> f64 {
        let motion = self.transfers.space().instance().motion;
        let joins: f64 = (0..self.order.len()).map(|at| self.price(self.exit(at), self.entry(at + 1))).sum();
        let on_tour = self.order.iter().map(|&entry| &self.lanes[entry as usize / 2]);
        joins + on_tour.map(|lane| motion.path_s(&lane.points, None)).sum::<f64>()
    }

    /// The lanes in the order of driving, and the way back to where the tour begins.
    pub(crate) fn stops(&mut self) -> (Vec<Stop>, Option<Way>) {
        let mut stops = Vec::with_capacity(self.order.len());
        let mut from = 1;
        for entered in self.entries().into_iter().skip(1) {
            // What cannot be reached is left out.
            let Some(way) = self.way(from, entered) else { continue };
            let lane = &self.lanes[entered / 2];
            let lane = if entered.is_multiple_of(2) { lane.clone() } else { lane.reversed() };
            stops.push(Stop { lane, way });
            from = entered ^ 1;
        }
        let home = if self.returns { self.way(from, 0) } else { None };
        (stops, home)
    }

    /// Entered ends, in the order of driving, from lane 0 on.
    fn entries(&self) -> Vec<usize> {
        let first = self.at[0] as usize;
        let mut entries: Vec<usize> =
            (0..self.order.len()).map(|n| self.order[(first + n) % self.order.len()] as usize).collect();
        if entries[0] == 1 {
            // Lane 0 is left by its end 1: turn the tour around.
            entries[1..].reverse();
            for entry in &mut entries {
                *entry ^= 1;
            }
        }
        entries
    }

    /// The way from one end to another.
    pub(crate) fn way(&mut self, from: usize, to: usize) -> Option<Way> {
        self.price(from, to);
        let (_, number) = self.entry_of(from, to)?;
        let way = self.ways[number as usize].as_ref()?;
        Some(if from < to { way.clone() } else { way.reversed() })
    }

    /// Looks for the ends near all ends from a number on.
    fn find_near_ends(&mut self, first: usize) {
        for end in first..self.ends.len() {
            let wanted = |other: usize| other / 2 != end / 2 && !self.is_gone[other / 2];
            let from = self.ends[end];
            let found = self.transfers.nearest(from, &self.targets, wanted, f64::INFINITY, NEAR);
            for near in found {
                self.note_near(end, near.target, near.at_least_m);
                if near.target < first {
                    self.note_near(near.target, end, near.at_least_m);
                }
            }
        }
    }

    fn note_near(&mut self, end: usize, other: usize, at_least_m: f64) {
        let speed = self.transfers.space().instance().motion.speed_m_per_s;
        let over_ground_s = at_least_m / speed + self.turns_at_least_s(end, other);
        let at_least_s = self.price_at_least(end, other).max(over_ground_s);
        if self.lookup(end, other).is_none() && (self.returns || end.min(other) != 0) {
            self.note(end, other, at_least_s, UNKNOWN);
        }
        let place = self.near[end]
            .partition_point(|known| (known.at_least_s, known.end) < (at_least_s, other as u32));
        self.near[end].insert(place, NearEnd { end: other as u32, at_least_s });
    }

    fn entry_of(&self, from: usize, to: usize) -> Option<(f64, u32)> {
        let known = &self.known[from];
        let found = known.binary_search_by_key(&(to as u32), |entry| entry.0).ok()?;
        Some((known[found].1, known[found].2))
    }

    fn lookup(&self, from: usize, to: usize) -> Option<f64> {
        self.entry_of(from, to).filter(|&(_, way)| way != UNKNOWN).map(|(price_s, _)| price_s)
    }

    /// Remembers the way between two ends, the smaller number first.
    fn learn(&mut self, from: usize, to: usize, way: Option<Way>) -> f64 {
        let instance = self.transfers.space().instance();
        let inward = self.outward_rad[to].map(|heading| heading + std::f64::consts::PI);
        let time_s =
            way.as_ref().map_or(f64::INFINITY, |way| way.time_s(instance, self.outward_rad[from], inward));
        // Where nobody has to return, what leads to the first end of lane 0 is not driven.
        let price_s = if from == 0 && !self.returns { 0.0 } else { time_s };
        let number = self.ways.len() as u32;
        self.ways.push(way);
        self.note(from, to, price_s, number);
        price_s
    }

    fn note(&mut self, from: usize, to: usize, price_s: f64, way: u32) {
        for (one, other) in [(from, to), (to, from)] {
            let entry = (other as u32, price_s, way);
            match self.known[one].binary_search_by_key(&(other as u32), |entry| entry.0) {
                Ok(place) => self.known[one][place] = entry,
                Err(place) => self.known[one].insert(place, entry),
            }
        }
    }

    fn price(&mut self, from: usize, to: usize) -> f64 {
        self.price_below(from, to, f64::INFINITY).unwrap_or(f64::INFINITY)
    }

    /// The price where it is less than `limit_s`. No way is looked for that would be much longer.
    fn price_below(&mut self, from: usize, to: usize, limit_s: f64) -> Option<f64> {
        if let Some(price_s) = self.lookup(from, to) {
            return Some(price_s).filter(|&price_s| price_s < limit_s);
        }
        if self.price_at_least(from, to) > limit_s {
            return None;
        }
        let (one, other) = (from.min(to), from.max(to));
        let speed = self.transfers.space().instance().motion.speed_m_per_s;
        let limit_m = (limit_s - self.turns_at_least_s(from, to)) * speed;
        match self.transfers.way_within(self.ends[one], self.ends[other], limit_m) {
            None if limit_s < f64::INFINITY => {
                self.note(one, other, limit_s, UNKNOWN);
                None
            }
            way => Some(self.learn(one, other, way)).filter(|&price_s| price_s < limit_s),
        }
    }

    /// As a rule no more than the price; exact where it is known.
    fn price_at_least(&self, from: usize, to: usize) -> f64 {
        self.entry_of(from, to).map_or_else(
            || {
                if !self.returns && from.min(to) == 0 {
                    return 0.0;
                }
                let way: Vector = self.ends[to] - self.ends[from];
                let speed = self.transfers.space().instance().motion.speed_m_per_s;
                way.norm() / speed + self.turns_at_least_s(from, to)
            },
            |(price_s, _)| price_s,
        )
    }

    /// However the way bends: it has to come from the heading of the one lane to that of the other.
    fn turns_at_least_s(&self, from: usize, to: usize) -> f64 {
        match (self.outward_rad[from], self.outward_rad[to]) {
            (Some(out), Some(of_next)) if self.returns || from.min(to) != 0 => {
                let turn = angle_between(out, of_next + std::f64::consts::PI);
                self.transfers.space().instance().motion.turn_s(turn)
            }
            _ => 0.0,
        }
    }

    fn nearest_first(&mut self) -> Vec<u32> {
        let lanes = self.ends.len() / 2;
        let mut is_open = vec![true; lanes];
        is_open[0] = false;
        let mut order = vec![0_u32];
        let mut at = 1_usize;
        while order.len() < lanes {
            let best = self.nearest_open(at, &is_open);
            let entry = best.unwrap_or_else(|| {
                // Out of reach: last, at an infinite price.
                2 * is_open.iter().position(|&open| open).expect("a lane is left")
            });
            is_open[entry / 2] = false;
            order.push(entry as u32);
            at = entry ^ 1;
        }
        order
    }

    fn nearest_open(&mut self, at: usize, is_open: &[bool]) -> Option<usize> {
        let mut nearest: Option<(f64, usize)> = None;
        for number in 0..self.near[at].len() {
            let NearEnd { end: other, at_least_s } = self.near[at][number];
            let most_s = nearest.map_or(f64::INFINITY, |(price_s, _)| price_s);
            if at_least_s >= most_s {
                break;
            }
            if is_open[other as usize / 2] {
                let price_s = self.price_below(at, other as usize, most_s);
                nearest = price_s.map(|price_s| (price_s, other as usize)).or(nearest);
            }
        }
        if let Some((_, other)) = nearest {
            return Some(other);
        }
        let wanted = |other: usize| is_open[other / 2];
        let found = self.transfers.ways_to_nearest(self.ends[at], &self.targets, wanted, f64::INFINITY, 1);
        let mut best: Option<(f64, usize)> = None;
        for (other, way) in found {
            let price_s = self.lookup(at, other).unwrap_or_else(|| {
                let way = if at < other { way } else { way.reversed() };
                self.learn(at.min(other), at.max(other), Some(way))
            });
            if best.is_none_or(|(known_s, _)| price_s < known_s) {
                best = Some((price_s, other));
            }
        }
        best.map(|(_, other)| other)
    }

    fn number_from(&mut self, from: usize, to: usize) {
        for at in from..to {
            self.at[self.order[at] as usize / 2] = at as u32;
        }
    }

    fn entry(&self, at: usize) -> usize {
        self.order[at % self.order.len()] as usize
    }

    fn exit(&self, at: usize) -> usize {
        self.entry(at) ^ 1
    }

    fn is_entry(&self, end: usize) -> bool {
        self.order[self.at[end / 2] as usize] as usize == end
    }

    /// Improves until nothing near helps, then `steps` times with two pieces exchanged.
    pub(crate) fn improve(&mut self, steps: u64, random: &mut ChaCha8Rng) {
        let lanes = self.order.len();
        if lanes < 3 {
            return;
        }
        self.settle(self.order.iter().map(|entry| entry / 2).collect());
        if lanes < 8 {
            return;
        }
        let mut kept = (self.order.clone(), self.at.clone());
        for _ in 0..steps {
            let Some((changed_s, touched)) = self.bridge(random) else { continue };
            let gained_s = self.settle(touched);
            if gained_s - changed_s < -BETTER_S {
                self.order.copy_from_slice(&kept.0);
                self.at.copy_from_slice(&kept.1);
            } else {
                kept.0.copy_from_slice(&self.order);
                kept.1.copy_from_slice(&self.at);
            }
        }
    }

    /// Exchanges two neighbouring pieces; what that costs, and the lanes at the joins.
    fn bridge(&mut self, random: &mut ChaCha8Rng) -> Option<(f64, Vec<u32>)> {
        let lanes = self.order.len();
        let longest = BRIDGE.min((lanes - 2) / 2);
        let (one, other) = (random.random_range(1..=longest), random.random_range(1..=longest));
        let first = random.random_range(0..lanes - one - other);
        let (middle, last) = (first + one, first + one + other);
        let joins = [(first, first + 1), (middle, middle + 1), (last, last + 1)];
        let before_s: f64 = joins.iter().map(|&(a, b)| self.price(self.exit(a), self.entry(b))).sum();
        let new = [(first, middle + 1), (last, first + 1), (middle, last + 1)];
        let new = new.map(|(a, b)| (self.exit(a), self.entry(b)));
        let mut after_s: f64 = new.iter().map(|&(from, to)| self.price_at_least(from, to)).sum();
        for (from, to) in new {
            let others_s = after_s - self.price_at_least(from, to);
            after_s = others_s + self.price_below(from, to, before_s + BRIDGE_S - others_s)?;
        }
        self.order[first + 1..=last].rotate_left(one);
        self.number_from(first + 1, last + 1);
        let joins = [(first, first + 1), (first + other, first + other + 1), (last, last + 1)];
        let touched = joins.iter().flat_map(|&(a, b)| [a, b]).map(|at| self.entry(at) as u32 / 2).collect();
        Some((after_s - before_s, touched))
    }

    /// Looks at lanes until none of them can be improved; what that gains.
    fn settle(&mut self, mut waiting: Vec<u32>) -> f64 {
        let mut gained_s = 0.0;
        let mut is_waiting = vec![false; self.at.len()];
        for &lane in &waiting {
            is_waiting[lane as usize] = true;
        }
        while let Some(lane) = waiting.pop() {
            is_waiting[lane as usize] = false;
            while let Some((gain_s, touched)) = self.improve_at(lane as usize) {
                gained_s += gain_s;
                for touched in touched {
                    if !is_waiting[touched as usize] {
                        is_waiting[touched as usize] = true;
                        waiting.push(touched);
                    }
                }
            }
        }
        gained_s
    }

    fn improve_at(&mut self, lane: usize) -> Option<(f64, Vec<u32>)> {
        self.two_opt(2 * lane).or_else(|| self.two_opt(2 * lane + 1)).or_else(|| self.move_lanes(lane))
    }

    /// Joins an end with a near one of the same kind (both left, or both entered), and turns around what lies between.
    fn two_opt(&mut self, end: usize) -> Option<(f64, Vec<u32>)> {
        let lanes = self.order.len();
        let leaves = !self.is_entry(end);
        let at = self.at[end / 2] as usize;
        let partner = if leaves { self.entry(at + 1) } else { self.exit(at + lanes - 1) };
        let now_s = self.price(end, partner);
        for number in 0..self.near[end].len() {
            let NearEnd { end: near, at_least_s } = self.near[end][number];
            if at_least_s >= now_s {
                return None;
            }
            let near = near as usize;
            if self.at[near / 2] == OUT || self.is_entry(near) == leaves {
                continue;
            }
            let near_at = self.at[near / 2] as usize;
            let near_partner = if leaves { self.entry(near_at + 1) } else { self.exit(near_at + lanes - 1) };
            let freed_s = now_s + self.price(near, near_partner);
            // No way is looked for where bounds say that nothing can be gained.
            if at_least_s + self.price_at_least(partner, near_partner) >= freed_s - BETTER_S {
                continue;
            }
            let Some(joined_s) = self.price_below(end, near, now_s) else { continue };
            let saved_s = freed_s - joined_s;
            let Some(other_s) = self.price_below(partner, near_partner, saved_s - BETTER_S) else { continue };
            let gain_s = saved_s - other_s;
            if gain_s > BETTER_S {
                if leaves {
                    self.turn_around(at + 1, near_at);
                } else {
                    self.turn_around(near_at, at + lanes - 1);
                }
                let touched = [end, partner, near, near_partner].map(|end| end as u32 / 2).to_vec();
                return Some((gain_s, touched));
            }
        }
        None
    }

    /// Turns around the lanes from one place of the order to another, or all others: the tour is the same.
    fn turn_around(&mut self, from: usize, to: usize) {
        let lanes = self.order.len();
        let (from, to) = (from % lanes, to % lanes);
        let inside = (to + lanes - from) % lanes + 1;
        let (mut left, mut right, count) = if inside * 2 <= lanes {
            (from, to, inside)
        } else {
            ((to + 1) % lanes, (from + lanes - 1) % lanes, lanes - inside)
        };
        for _ in 0..count / 2 {
            self.order.swap(left, right);
            self.order[left] ^= 1;
            self.order[right] ^= 1;
            self.at[self.order[left] as usize / 2] = left as u32;
            self.at[self.order[right] as usize / 2] = right as u32;
            left = (left + 1) % lanes;
            right = (right + lanes - 1) % lanes;
        }
        if count % 2 == 1 {
            self.order[left] ^= 1;
        }
    }

    /// Moves a piece that begins or ends with a lane to beside a near end, either way round.
    fn move_lanes(&mut self, lane: usize) -> Option<(f64, Vec<u32>)> {
        let lanes = self.order.len();
        for count in 1..=MOVED.min(lanes - 2) {
            for begin in [self.at[lane] as usize, self.at[lane] as usize + lanes + 1 - count] {
                let begin = begin % lanes;
                if let Some(found) = self.move_piece(begin, count) {
                    return Some(found);
                }
                if count == 1 {
                    break;
                }
            }
        }
        None
    }

    fn move_piece(&mut self, begin: usize, count: usize) -> Option<(f64, Vec<u32>)> {
        let lanes = self.order.len();
        let (first, last) = (self.entry(begin), self.exit(begin + count - 1));
        let (before, after) = (self.exit(begin + lanes - 1), self.entry(begin + count));
        let apart_s = self.price(before, first) + self.price(last, after);
        let most_freed_s = apart_s - self.price_at_least(before, after);
        if most_freed_s <= BETTER_S {
            return None;
        }
        // What is freed is known once bounds say that it could be enough somewhere.
        let mut freed_s: Option<f64> = None;
        let inside = |at: usize| (at + lanes - begin) % lanes < count;
        for (end, far) in [(first, last), (last, first)] {
            for number in 0..self.near[end].len() {
                let NearEnd { end: near, at_least_s } = self.near[end][number];
                if at_least_s >= freed_s.unwrap_or(most_freed_s) {
                    break;
                }
                let near = near as usize;
                let near_at = self.at[near / 2] as usize;
                if near_at == OUT as usize || inside(near_at) {
                    continue;
                }
                let leaves = !self.is_entry(near);
                let beyond_at = if leaves { (near_at + 1) % lanes } else { (near_at + lanes - 1) % lanes };
                if inside(beyond_at) {
                    continue;
                }
                let beyond = if leaves { self.entry(beyond_at) } else { self.exit(beyond_at) };
                let least_s = at_least_s + self.price_at_least(far, beyond) - self.price(near, beyond);
                if least_s >= freed_s.unwrap_or(most_freed_s) - BETTER_S {
                    continue;
                }
                if freed_s.is_none() {
                    let closed_s = self.price_below(before, after, apart_s - BETTER_S)?;
                    freed_s = Some(apart_s - closed_s);
                }
                let freed_s = freed_s.unwrap_or(most_freed_s);
                if least_s >= freed_s - BETTER_S {
                    continue;
                }
                let Some(joined_s) = self.price_below(end, near, freed_s) else { continue };
                let opened_s = freed_s + self.price(near, beyond) - joined_s;
                let Some(far_s) = self.price_below(far, beyond, opened_s - BETTER_S) else { continue };
                let gain_s = opened_s - far_s;
                if gain_s > BETTER_S {
                    // The piece is entered by `end` when it comes after `near`, else by `far`.
                    let entered_by = if leaves { end } else { far };
                    let follows = if leaves { near } else { beyond };
                    self.insert_after(begin, count, follows, entered_by == last);
                    let ends = [first, last, before, after, near, beyond];
                    return Some((gain_s, ends.map(|end| end as u32 / 2).to_vec()));
                }
            }
        }
        None
    }

    fn insert_after(&mut self, begin: usize, count: usize, follows: usize, turned: bool) {
        let lanes = self.order.len();
        let mut piece: Vec<u32> = (0..count).map(|n| self.order[(begin + n) % lanes]).collect();
        if turned {
            piece.reverse();
            for end in &mut piece {
                *end ^= 1;
            }
        }
        // Shift what lies between the gap and the new place by the length of the piece, the shorter way.
        let target = self.at[follows / 2] as usize;
        let ahead = (target + lanes - (begin + count - 1)) % lanes;
        let behind = lanes - count - ahead;
        if ahead <= behind {
            for n in 0..ahead {
                self.put((begin + n) % lanes, self.order[(begin + count + n) % lanes]);
            }
            for (n, &end) in piece.iter().enumerate() {
                self.put((begin + ahead + n) % lanes, end);
            }
        } else {
            for n in 0..behind {
                let (to, from) = (begin + count - 1 + lanes - n, begin + lanes - 1 - n);
                self.put(to % lanes, self.order[from % lanes]);
            }
            for (n, &end) in piece.iter().enumerate() {
                self.put((begin + lanes - behind + n) % lanes, end);
            }
        }
    }

    fn put(&mut self, at: usize, entry: u32) {
        self.order[at] = entry;
        self.at[entry as usize / 2] = at as u32;
    }
}
