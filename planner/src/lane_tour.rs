//! A short closed tour over straight lanes, each driven once, either way.
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
//! **Complexity.** One bounded search per end for its near ends; others are searched for only when a bound on their price
//! promises a gain. O(n) for a reversal.
//! **Paper.** 2-opt and Or-opt with near lists: J. J. Bentley: Fast algorithms for geometric traveling salesman problems. ORSA Journal on Computing 4, 1992.

use crate::transfers::{Targets, Transfers, Way, heading_rad};
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use terrain::{Point, Vector};

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

/// A straight lane, free for the body all along. Its ends are the same point for a place that is only visited.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lane {
    pub(crate) from: Point,
    pub(crate) to: Point,
}

/// Lanes with the prices between their ends. End `2 n` is the first of lane n, `2 n + 1` the other one; `end ^ 1` is
/// the other end of the same lane. Lane 0 is the place where the tour begins and ends.
#[derive(Debug)]
pub(crate) struct LaneTour<'t, 's, 'a> {
    transfers: &'t mut Transfers<'s, 'a>,
    ends: Vec<Point>,
    /// Per end: heading out of its lane.
    outward_rad: Vec<Option<f64>>,
    /// Per end, by number of the other end: price and way from this end to that one.
    known: Vec<Vec<(u32, f64, u32)>>,
    ways: Vec<Option<Way>>,
    near: Vec<Vec<u32>>,
    /// Ends by which lanes are entered, in the order of driving.
    order: Vec<u32>,
    /// Per lane, its place in the order.
    at: Vec<u32>,
    /// Whether the way back to lane 0 counts.
    returns: bool,
}

impl<'t, 's, 'a> LaneTour<'t, 's, 'a> {
    /// Over lanes that can all be reached from `start`; in the order given, or the nearest lane first.
    pub(crate) fn new(
        transfers: &'t mut Transfers<'s, 'a>,
        start: Point,
        lanes: &[Lane],
        in_order: bool,
        returns: bool,
    ) -> Self {
        let mut ends = vec![start, start];
        ends.extend(lanes.iter().flat_map(|lane| [lane.from, lane.to]));
        let outward = |end: usize| {
            let (from, to) = (ends[end ^ 1], ends[end]);
            ((to - from).norm() > 1e-9).then(|| heading_rad(from, to))
        };
        let outward_rad = (0..ends.len()).map(outward).collect();
        let mut tour = Self {
            transfers,
            known: vec![Vec::new(); ends.len()],
            near: vec![Vec::new(); ends.len()],
            ways: Vec::new(),
            order: Vec::new(),
            at: vec![0; ends.len() / 2],
            ends,
            outward_rad,
            returns,
        };
        tour.find_near_ends();
        tour.order = if in_order {
            (0..=lanes.len() as u32).map(|lane| 2 * lane).collect()
        } else {
            tour.nearest_first()
        };
        tour.number_from(0, tour.order.len());
        tour
    }

    /// Entered ends, in the order of driving, from lane 0 on.
    pub(crate) fn entries(&self) -> Vec<usize> {
        let first = self.at[0] as usize;
        let mut entries: Vec<usize> =
            (0..self.order.len()).map(|n| self.order[(first + n) % self.order.len()] as usize).collect();
        if entries[0] == 1 {
            // Lane 0 is left by its end 1: turn the tour around.
            entries[1..].reverse();
            for end in &mut entries {
                *end ^= 1;
            }
        }
        entries
    }

    /// The way from one end to another.
    pub(crate) fn way(&mut self, from: usize, to: usize) -> Option<Way> {
        self.price(from, to);
        let known = &self.known[from];
        let found = known.binary_search_by_key(&(to as u32), |entry| entry.0).ok()?;
        let way = self.ways[known[found].2 as usize].as_ref()?;
        Some(if from < to { way.clone() } else { way.reversed() })
    }

    fn find_near_ends(&mut self) {
        let targets = Targets::new(self.transfers.space(), self.ends.clone());
        for end in 0..self.ends.len() {
            let wanted = |other: usize| other / 2 != end / 2;
            let found = self.transfers.ways_to_nearest(self.ends[end], &targets, wanted, f64::INFINITY, NEAR);
            for (other, way) in found {
                if self.lookup(end, other).is_none() {
                    let way = if end < other { way } else { way.reversed() };
                    self.learn(end.min(other), end.max(other), Some(way));
                }
                self.near[end].push(other as u32);
            }
        }
        for end in 0..self.ends.len() {
            let mut priced: Vec<(f64, u32)> = self.near[end]
                .iter()
                .map(|&other| (self.lookup(end, other as usize).unwrap_or(f64::INFINITY), other))
                .collect();
            priced.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            self.near[end] = priced.into_iter().map(|(_, other)| other).collect();
        }
    }

    fn lookup(&self, from: usize, to: usize) -> Option<f64> {
        let known = &self.known[from];
        known.binary_search_by_key(&(to as u32), |entry| entry.0).ok().map(|found| known[found].1)
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
        for (one, other) in [(from, to), (to, from)] {
            let place = self.known[one].binary_search_by_key(&(other as u32), |entry| entry.0);
            if let Err(place) = place {
                self.known[one].insert(place, (other as u32, price_s, number));
            }
        }
        price_s
    }

    fn price(&mut self, from: usize, to: usize) -> f64 {
        if let Some(price_s) = self.lookup(from, to) {
            return price_s;
        }
        let (one, other) = (from.min(to), from.max(to));
        let way = self.transfers.way(self.ends[one], self.ends[other]);
        self.learn(one, other, way)
    }

    /// No more than the price; exact where it is known.
    fn price_at_least(&self, from: usize, to: usize) -> f64 {
        self.lookup(from, to).unwrap_or_else(|| {
            if !self.returns && from.min(to) == 0 {
                return 0.0;
            }
            let way: Vector = self.ends[to] - self.ends[from];
            way.norm() / self.transfers.space().instance().motion.speed_m_per_s
        })
    }

    fn nearest_first(&mut self) -> Vec<u32> {
        let targets = Targets::new(self.transfers.space(), self.ends.clone());
        let lanes = self.ends.len() / 2;
        let mut is_open = vec![true; lanes];
        is_open[0] = false;
        let mut order = vec![0_u32];
        let mut at = 1_usize;
        while order.len() < lanes {
            let best = self.nearest_open(at, &targets, &is_open);
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

    fn nearest_open(&mut self, at: usize, targets: &Targets, is_open: &[bool]) -> Option<usize> {
        let near = self.near[at].iter().map(|&other| other as usize);
        if let Some(other) = near.clone().find(|other| is_open[other / 2]) {
            return Some(other);
        }
        let wanted = |other: usize| is_open[other / 2];
        let found = self.transfers.ways_to_nearest(self.ends[at], targets, wanted, f64::INFINITY, 3);
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
        self.settle((0..lanes as u32).collect());
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
        let at_least_s: f64 =
            new.iter().map(|&(a, b)| self.price_at_least(self.exit(a), self.entry(b))).sum();
        if at_least_s > before_s + BRIDGE_S {
            return None;
        }
        self.order[first + 1..=last].rotate_left(one);
        self.number_from(first + 1, last + 1);
        let joins = [(first, first + 1), (first + other, first + other + 1), (last, last + 1)];
        let after_s: f64 = joins.iter().map(|&(a, b)| self.price(self.exit(a), self.entry(b))).sum();
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
            let near = self.near[end][number] as usize;
            let joined_s = self.price(end, near);
            if joined_s >= now_s {
                return None;
            }
            if self.is_entry(near) == leaves {
                continue;
            }
            let near_at = self.at[near / 2] as usize;
            let near_partner = if leaves { self.entry(near_at + 1) } else { self.exit(near_at + lanes - 1) };
            let saved_s = now_s + self.price(near, near_partner) - joined_s;
            if self.price_at_least(partner, near_partner) >= saved_s - BETTER_S {
                continue;
            }
            let gain_s = saved_s - self.price(partner, near_partner);
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
        if self.price_at_least(before, after) >= apart_s {
            return None;
        }
        let freed_s = apart_s - self.price(before, after);
        if freed_s <= BETTER_S {
            return None;
        }
        let inside = |at: usize| (at + lanes - begin) % lanes < count;
        for (end, far) in [(first, last), (last, first)] {
            for number in 0..self.near[end].len() {
                let near = self.near[end][number] as usize;
                let joined_s = self.price(end, near);
                if joined_s >= freed_s {
                    break;
                }
                let near_at = self.at[near / 2] as usize;
                if inside(near_at) {
                    continue;
                }
                let leaves = !self.is_entry(near);
                let beyond_at = if leaves { (near_at + 1) % lanes } else { (near_at + lanes - 1) % lanes };
                if inside(beyond_at) {
                    continue;
                }
                let beyond = if leaves { self.entry(beyond_at) } else { self.exit(beyond_at) };
                let opened_s = freed_s + self.price(near, beyond) - joined_s;
                if self.price_at_least(far, beyond) >= opened_s - BETTER_S {
                    continue;
                }
                let gain_s = opened_s - self.price(far, beyond);
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
