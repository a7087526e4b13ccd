//! The search: runs of stretches are taken out and put back where they cost least.

use super::{Ends, links::Links};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

/// Power of the mean of the robots' times.
const POWER: i32 = 12;
/// How much the mean of all times counts beside it.
const EVERYBODY: f64 = 0.1;
/// Stretches taken out at once, at most, and those of one run.
const REMOVED: usize = 14;
const RUN: usize = 8;
/// Near ends beside which a stretch may be put.
const BESIDE: usize = 8;
/// One in so many places is passed over, so that the same ruin is not always mended in the same way.
const BLINK: u32 = 60;
/// Temperature at the begin of a search, and how much lower it is in the end, as a share of the objective.
const WARM: f64 = 2e-3;
const COLD: f64 = 1e-2;

/// Routes that are being changed.
pub(super) struct Search<'l, 'a> {
    links: &'l Links<'a>,
    burden: &'l [f64],
    rng: ChaCha8Rng,
    now: State,
    best: State,
}

#[derive(Debug, Clone)]
struct State {
    routes: Vec<Ends>,
    /// Per stretch: the robot that drives it, if any.
    driver: Vec<Option<u16>>,
    time_s: Vec<f64>,
    objective_s: f64,
}

/// Where a stretch may be put: before the place `at` of a route, entered at an end.
#[derive(Debug, Clone, Copy)]
struct Slot {
    robot: usize,
    at: usize,
    end: u32,
    more_s: f64,
}

impl<'l, 'a> Search<'l, 'a> {
    pub(super) fn new(links: &'l Links<'a>, burden: &'l [f64], routes: Vec<Ends>, seed: u64) -> Self {
        let time_s: Vec<f64> = routes
            .iter()
            .enumerate()
            .map(|(robot, route)| burden[robot] * links.route_s(robot, route))
            .collect();
        let objective_s = power_mean_s(&time_s);
        let mut driver = vec![None; links.stretches()];
        for (robot, route) in routes.iter().enumerate() {
            for &end in route {
                driver[end as usize / 2] = Some(robot as u16);
            }
        }
        let now = State { routes, driver, time_s, objective_s };
        Self { links, burden, rng: ChaCha8Rng::seed_from_u64(seed), best: now.clone(), now }
    }

    /// `steps` changes; `warmth` scales the temperature.
    pub(super) fn run(&mut self, steps: u64, warmth: f64) {
        for step in 0..steps {
            let share = step as f64 / steps as f64;
            let temperature_s = self.best.objective_s * WARM * warmth * COLD.powf(share);
            self.step(temperature_s);
        }
    }

    /// What is made small: seconds.
    pub(super) fn objective_s(&self) -> f64 {
        self.now.objective_s
    }

    pub(super) fn into_best(self) -> Vec<Ends> {
        self.best.routes
    }

    fn step(&mut self, temperature_s: f64) {
        let before = self.now.clone();
        let mut removed = self.ruin();
        self.order(&mut removed);
        for stretch in removed {
            self.put(stretch);
        }
        self.now.objective_s = power_mean_s(&self.now.time_s);
        let change_s = self.now.objective_s - before.objective_s;
        if change_s > 0.0 && self.rng.random::<f64>() >= (-change_s / temperature_s).exp() {
            self.now = before;
        } else if self.now.objective_s < self.best.objective_s - 1e-9 {
            // What is summed up step by step drifts.
            self.recount();
            self.best = self.now.clone();
        }
    }

    fn recount(&mut self) {
        for robot in 0..self.now.routes.len() {
            self.now.time_s[robot] = self.burden[robot] * self.links.route_s(robot, &self.now.routes[robot]);
        }
        self.now.objective_s = power_mean_s(&self.now.time_s);
    }

    /// Takes runs out of the routes near a random stretch.
    fn ruin(&mut self) -> Vec<u32> {
        let seed = self.seed();
        let count = self.rng.random_range(1..=REMOVED);
        let run = self.rng.random_range(1..=RUN);
        let mut removed: Vec<u32> = Vec::new();
        let mut robots_done: Vec<usize> = Vec::new();
        let near = self.links.near(2 * seed).chain(self.links.near(2 * seed + 1)).map(|end| end / 2);
        let around: Vec<u32> = std::iter::once(seed).chain(near).collect();
        for stretch in around {
            if removed.len() >= count || removed.contains(&stretch) {
                continue;
            }
            let Some((robot, at)) = self.find(stretch) else { continue };
            if robots_done.iter().filter(|&&done| done == robot).count() < 2 {
                robots_done.push(robot);
                self.take_run(robot, at, run.min(count - removed.len()), &mut removed);
            }
        }
        removed
    }

    /// A stretch to begin with: half of them of the robot that is done last.
    fn seed(&mut self) -> u32 {
        let last =
            (0..self.now.time_s.len()).max_by(|&a, &b| self.now.time_s[a].total_cmp(&self.now.time_s[b]));
        if let Some(route) = last.map(|robot| &self.now.routes[robot]).filter(|route| !route.is_empty())
            && self.rng.random_range(0..2_u32) == 0
        {
            return route[self.rng.random_range(0..route.len())] / 2;
        }
        self.rng.random_range(0..self.links.stretches() as u32)
    }

    fn find(&self, stretch: u32) -> Option<(usize, usize)> {
        let robot = usize::from(self.now.driver[stretch as usize]?);
        let at = self.now.routes[robot].iter().position(|&end| end / 2 == stretch);
        Some((robot, at.expect("a stretch is on the route of its driver")))
    }

    fn take_run(&mut self, robot: usize, at: usize, run: usize, removed: &mut Vec<u32>) {
        let route = &mut self.now.routes[robot];
        let run = run.min(route.len());
        let first = at - self.rng.random_range(0..run).min(at);
        let first = first.min(route.len() - run);
        for end in route.drain(first..first + run) {
            self.now.driver[end as usize / 2] = None;
            removed.push(end / 2);
        }
        self.now.time_s[robot] = self.burden[robot] * self.links.route_s(robot, &self.now.routes[robot]);
    }

    fn order(&mut self, removed: &mut [u32]) {
        match self.rng.random_range(0..3_u32) {
            0 => removed.reverse(),
            1 => removed.sort_by(|&a, &b| self.links.inner_s(2 * b).total_cmp(&self.links.inner_s(2 * a))),
            _ => {
                for index in (1..removed.len()).rev() {
                    removed.swap(index, self.rng.random_range(0..=index));
                }
            }
        }
    }

    /// Puts a stretch where it costs least.
    fn put(&mut self, stretch: u32) {
        let unit_s = self.now.time_s.iter().copied().fold(1.0, f64::max);
        let mut best: Option<(f64, Slot)> = None;
        for slot in self.slots(stretch) {
            if best.is_some() && self.rng.random_range(0..BLINK) == 0 {
                continue;
            }
            let (before_s, burden) = (self.now.time_s[slot.robot], self.burden[slot.robot]);
            let after_s = before_s + burden * slot.more_s;
            let price = powered(after_s / unit_s) - powered(before_s / unit_s);
            if best.is_none_or(|(least, _)| price < least) {
                best = Some((price, slot));
            }
        }
        let (_, slot) = best.expect("a stretch can be put at an end of any route");
        self.now.routes[slot.robot].insert(slot.at, slot.end);
        self.now.driver[stretch as usize] = Some(slot.robot as u16);
        self.now.time_s[slot.robot] += self.burden[slot.robot] * slot.more_s;
    }

    /// Beside near stretches, and at both ends of all routes.
    fn slots(&self, stretch: u32) -> Vec<Slot> {
        let mut places: Vec<(usize, usize)> = Vec::new();
        for end in [2 * stretch, 2 * stretch + 1] {
            for near in self.links.near(end).take(BESIDE) {
                let Some((robot, at)) = self.find(near / 2) else { continue };
                places.extend([(robot, at), (robot, at + 1)]);
            }
        }
        for (robot, route) in self.now.routes.iter().enumerate() {
            places.extend([(robot, 0), (robot, route.len())]);
        }
        places.sort_unstable();
        places.dedup();
        let slot = |(robot, at): (usize, usize), end: u32| Slot {
            robot,
            at,
            end,
            more_s: self.more_s(robot, at, end),
        };
        places.iter().flat_map(|&place| [slot(place, 2 * stretch), slot(place, 2 * stretch + 1)]).collect()
    }

    /// Seconds that a stretch, entered at an end, adds before the place `at` of a route.
    fn more_s(&self, robot: usize, at: usize, end: u32) -> f64 {
        let (links, route) = (self.links, &self.now.routes[robot]);
        let (before, after) = (at.checked_sub(1).map(|at| route[at] ^ 1), route.get(at).copied());
        let into_s =
            |end: u32| before.map_or_else(|| links.out_s(robot, end), |from| links.link_s(from, end));
        let onward_s =
            |from: u32| after.map_or_else(|| links.home_s(robot, from), |to| links.link_s(from, to));
        let without_s = match (before, after) {
            (None, None) => -links.available_in_s(robot),
            (Some(from), _) => onward_s(from),
            (None, Some(to)) => into_s(to),
        };
        into_s(end) + links.inner_s(end) + onward_s(end ^ 1) - without_s
    }
}

/// What a robot's time counts, as a share of the longest.
fn powered(time: f64) -> f64 {
    time.powi(POWER) + EVERYBODY * time
}

fn power_mean_s(time_s: &[f64]) -> f64 {
    let most_s = time_s.iter().copied().fold(1e-9, f64::max);
    let powers: f64 = time_s.iter().map(|time_s| (time_s / most_s).powi(POWER)).sum();
    let mean_s = time_s.iter().sum::<f64>() / time_s.len() as f64;
    most_s * (powers / time_s.len() as f64).powf(1.0 / f64::from(POWER)) + EVERYBODY * mean_s
}
