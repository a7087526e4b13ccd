//! Prices of the ways between ends of stretches, and between them and where the robots stand.

use super::{Ends, Stretch};
use crate::{
    Instance, Mode, Start,
    transfers::{Targets, Transfers, Way},
};
use std::f64::consts::FRAC_PI_2;
use terrain::{Point, Vector};

/// Near ends whose links are known, for an end; without effort, and with it.
const NEAR: [usize; 2] = [8, 20];
/// They are looked for up to this many tool widths away.
const REACH_TOOLS: f64 = 24.0;
/// Up to so many ends, all prices are kept in one table.
const TABLE_ENDS: usize = 3000;
/// A link that is only guessed counts as this much longer than the straight line.
const DETOUR: f64 = 1.5;

/// Prices of links, seconds.
pub(crate) struct Links<'a> {
    instance: &'a Instance<'a>,
    /// Numbers of the robots in the instance.
    robots: Vec<usize>,
    /// Per end: where it is, and the direction in which its stretch is left there (zero: any).
    ends: Vec<(Point, Vector)>,
    inner_s: Vec<f64>,
    /// Per end: the ends whose price is known.
    near: Vec<Vec<(u32, f64)>>,
    /// By end and end: all prices, guessed ones too; empty where there are too many.
    table: Vec<f32>,
    /// Per robot: seconds until it is at an end, and from an end until it is home.
    out_s: Vec<Vec<f64>>,
    home_s: Vec<Vec<f64>>,
    /// Per robot and end: whether the two above are ways, no guesses.
    known: Vec<Vec<[bool; 2]>>,
}

impl<'a> Links<'a> {
    pub(crate) fn new(
        transfers: &mut Transfers<'_, 'a>,
        robots: &[usize],
        stretches: &[Stretch],
        effort: u32,
    ) -> Self {
        let instance = transfers.space().instance();
        let ends: Vec<(Point, Vector)> =
            (0..2 * stretches.len() as u32).map(|end| stretches[end as usize / 2].leaves_at(end)).collect();
        let inner_s = stretches.iter().map(|stretch| stretch.inner_s).collect();
        let count = robots.len();
        let mut links = Self {
            instance,
            robots: robots.to_vec(),
            near: vec![Vec::new(); ends.len()],
            out_s: vec![vec![0.0; ends.len()]; count],
            home_s: vec![vec![0.0; ends.len()]; count],
            known: vec![vec![[false; 2]; ends.len()]; count],
            table: Vec::new(),
            inner_s,
            ends,
        };
        links.search_near(transfers, NEAR[usize::from(effort > 0)]);
        links.fill_table();
        (0..count).for_each(|robot| links.guess_depot(transfers, robot, effort > 0));
        links
    }

    pub(crate) fn stretches(&self) -> usize {
        self.inner_s.len()
    }

    pub(crate) fn robots(&self) -> usize {
        self.out_s.len()
    }

    pub(crate) fn inner_s(&self, end: u32) -> f64 {
        self.inner_s[end as usize / 2]
    }

    fn start(&self, robot: usize) -> &'a Start {
        &self.instance.starts[self.robots[robot]]
    }

    /// Seconds before a robot begins.
    pub(crate) fn available_in_s(&self, robot: usize) -> f64 {
        self.start(robot).available_in_s
    }

    /// From a robot's start to an end, ready to drive its stretch.
    pub(crate) fn out_s(&self, robot: usize, end: u32) -> f64 {
        self.out_s[robot][end as usize]
    }

    /// From an end, its stretch driven, to where the robot's time ends.
    pub(crate) fn home_s(&self, robot: usize, end: u32) -> f64 {
        self.home_s[robot][end as usize]
    }

    /// From leaving a stretch at one end to being ready to drive another from its end.
    pub(crate) fn link_s(&self, from: u32, to: u32) -> f64 {
        if !self.table.is_empty() {
            return f64::from(self.table[from as usize * self.ends.len() + to as usize]);
        }
        let known = self.near[from as usize].iter().find(|&&(end, _)| end == to);
        known.map_or_else(|| self.guess_s(from, to), |&(_, link_s)| link_s)
    }

    /// Ends near an end, nearest first.
    pub(crate) fn near(&self, end: u32) -> impl Iterator<Item = u32> + '_ {
        self.near[end as usize].iter().map(|&(end, _)| end)
    }

    /// Seconds of a robot with a route.
    pub(crate) fn route_s(&self, robot: usize, route: &Ends) -> f64 {
        let (Some(&first), Some(&last)) = (route.first(), route.last()) else { return 0.0 };
        let inner_s: f64 = route.iter().map(|&end| self.inner_s(end)).sum();
        let links_s: f64 = route.windows(2).map(|pair| self.link_s(pair[0] ^ 1, pair[1])).sum();
        self.available_in_s(robot)
            + self.out_s(robot, first)
            + inner_s
            + links_s
            + self.home_s(robot, last ^ 1)
    }

    fn fill_table(&mut self) {
        let ends = self.ends.len() as u32;
        if self.ends.len() <= TABLE_ENDS {
            let pairs = (0..ends).flat_map(|from| (0..ends).map(move |to| (from, to)));
            self.table = pairs.map(|(from, to)| self.guess_s(from, to) as f32).collect();
            for from in 0..self.ends.len() {
                for &(to, link_s) in &self.near[from] {
                    self.table[from * self.ends.len() + to as usize] = link_s as f32;
                }
            }
        }
    }

    /// Through the air, but longer; turns by their cosines. What is not among the near ends is farther than they are.
    fn guess_s(&self, from: u32, to: u32) -> f64 {
        let ((a, out), (b, other)) = (&self.ends[from as usize], &self.ends[to as usize]);
        let way = b - a;
        let length_m = way.norm();
        let motion = &self.instance.motion;
        let turn_s = |out: &Vector, way: Vector| {
            let cosine = if length_m > 1e-9 { out.dot(&way) / length_m } else { 1.0 };
            if *out == Vector::zeros() { 0.0 } else { motion.turn_s(FRAC_PI_2 * (1.0 - cosine)) }
        };
        let straight_s = length_m / motion.speed_m_per_s + turn_s(out, way) + turn_s(other, -way);
        let farthest_s = |end: u32| self.near[end as usize].last().map_or(0.0, |&(_, link_s)| link_s);
        DETOUR * straight_s.max(farthest_s(from)).max(farthest_s(to))
    }

    fn search_near(&mut self, transfers: &mut Transfers<'_, 'a>, most: usize) {
        let points = self.ends.iter().map(|&(point, _)| point).collect();
        let targets = Targets::new(transfers.space(), points);
        let limit_m = REACH_TOOLS * self.instance.floor.tool_width_m();
        for end in 0..self.ends.len() {
            let others = |other: usize| other / 2 != end / 2;
            let found = transfers.ways_to_nearest(self.ends[end].0, &targets, others, limit_m, most);
            for (other, way) in found {
                self.know(end as u32, other as u32, &way);
            }
        }
    }

    /// Notes the price of a way, which is the same in both directions.
    fn know(&mut self, from: u32, to: u32, way: &Way) {
        let into_rad = heading_rad(-self.ends[to as usize].1);
        let link_s = way.time_s(self.instance, heading_rad(self.ends[from as usize].1), into_rad);
        for (one, other) in [(from, to), (to, from)] {
            if !self.table.is_empty() {
                self.table[one as usize * self.ends.len() + other as usize] = link_s as f32;
            }
            let list = &mut self.near[one as usize];
            if !list.iter().any(|&(end, _)| end == other) {
                let at = list.partition_point(|&(_, known_s)| known_s <= link_s);
                list.insert(at, (other, link_s));
            }
        }
    }

    /// By distances over the ground where there is time for them, else by those through the air.
    fn guess_depot(&mut self, transfers: &mut Transfers<'_, 'a>, robot: usize, over_ground: bool) {
        let start = self.instance.place(self.start(robot));
        let field = over_ground.then(|| transfers.field(&[(start, 0.0)]));
        for end in 0..self.ends.len() {
            let way = Way::new(self.instance, vec![start, self.ends[end].0]);
            let place = transfers.space().nearest_place(self.ends[end].0);
            let ground_m = field.as_ref().and_then(|field| field.distance_m(place?));
            let length_m = ground_m.unwrap_or(DETOUR * way.length_m).max(way.length_m);
            let more_s = (length_m - way.length_m) / self.instance.motion.speed_m_per_s;
            self.note_depot(robot, end, &way, more_s);
        }
    }

    fn note_depot(&mut self, robot: usize, end: usize, way: &Way, more_s: f64) {
        let instance = self.instance;
        let leaving_rad = heading_rad(self.ends[end].1);
        let into_rad = heading_rad(-self.ends[end].1);
        let back = way.reversed();
        self.out_s[robot][end] = way.time_s(instance, self.start(robot).heading_rad, into_rad) + more_s;
        if instance.mode == Mode::CoverAndReturn {
            self.home_s[robot][end] = back.time_s(instance, leaving_rad, None) + more_s;
        }
    }

    /// Prices the links of routes that were guessed; how many.
    pub(crate) fn price(&mut self, transfers: &mut Transfers<'_, 'a>, routes: &[Ends]) -> usize {
        let mut priced = 0;
        for (robot, route) in routes.iter().enumerate() {
            let (Some(&first), Some(&last)) = (route.first(), route.last()) else { continue };
            priced += self.price_depot(transfers, robot, first, 0);
            priced += self.price_depot(transfers, robot, last ^ 1, 1);
            for pair in route.windows(2) {
                let (from, to) = (pair[0] ^ 1, pair[1]);
                let known = self.near[from as usize].iter().any(|&(end, _)| end == to);
                let way = if known { None } else { self.way(transfers, from, to) };
                if let Some(way) = way {
                    self.know(from, to, &way);
                    priced += 1;
                }
            }
        }
        priced
    }

    fn way(&self, transfers: &mut Transfers<'_, 'a>, from: u32, to: u32) -> Option<Way> {
        transfers.way(self.ends[from as usize].0, self.ends[to as usize].0)
    }

    fn price_depot(
        &mut self,
        transfers: &mut Transfers<'_, 'a>,
        robot: usize,
        end: u32,
        purpose: usize,
    ) -> usize {
        let end = end as usize;
        let known = &mut self.known[robot][end];
        if std::mem::replace(&mut known[purpose], true) || known[1 - purpose] {
            return 0;
        }
        let start = self.instance.place(self.start(robot));
        let Some(way) = transfers.way(start, self.ends[end].0) else { return 0 };
        self.note_depot(robot, end, &way, 0.0);
        1
    }
}

fn heading_rad(direction: Vector) -> Option<f64> {
    (direction != Vector::zeros()).then(|| direction.y.atan2(direction.x))
}
