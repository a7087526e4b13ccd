//! People who walk about: from one place they can see to the next, at their own speed, and out again.
//!
//! They look where they go: they wait rather than step into the way of a robot, and go elsewhere when it stays.
//! Careless ones do not wait, and walk up to a robot until they touch it.

use crate::random_streams::stream;
use protocol::{Timestamp, v1};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;
use std::time::Duration;
use terrain::{GridMap, Point, Segment, Vector};

/// Room that a person takes, metres.
pub(crate) const PERSON_RADIUS_M: f64 = 0.25;
/// A person who finds the way taken waits so long, then goes elsewhere.
const PATIENCE: Duration = Duration::from_secs(3);
/// Somebody who looks keeps so far from the way of a robot, metres.
const ASIDE_M: f64 = 0.1;
/// Standing still between two walks.
const REST: Duration = Duration::from_secs(1);

/// One person.
#[derive(Debug, Clone)]
pub(crate) struct Person {
    pub(crate) id: String,
    pub(crate) position: Point,
    pub(crate) until: Option<Timestamp>,
    speed_m_per_s: f64,
    careless: bool,
    goal: Point,
    rests_until: Timestamp,
    blocked_since: Option<Timestamp>,
    rng: ChaCha8Rng,
}

/// How somebody walks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Walk {
    pub(crate) speed_m_per_s: f64,
    pub(crate) careless: bool,
    pub(crate) until: Option<Timestamp>,
}

/// A robot as a person sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SeenRobot {
    pub(crate) position: Point,
    /// Body, and what it needs to stop.
    pub(crate) room_m: f64,
    pub(crate) body_radius_m: f64,
    /// Direction in which it drives, of length 1; zero when it stands.
    pub(crate) ahead: Vector,
}

impl SeenRobot {
    /// Whether a step leads into the way ahead of it.
    fn is_cut_off_by(&self, from: Point, to: Point) -> bool {
        let aside_m = |at: Point| self.ahead.perp(&(at - self.position)).abs();
        let ahead_m = self.ahead.dot(&(to - self.position));
        let near_m = self.body_radius_m + PERSON_RADIUS_M;
        let in_front = ahead_m > 0.0 && ahead_m < near_m + self.room_m;
        in_front && aside_m(to) < near_m + ASIDE_M && aside_m(to) < aside_m(from)
    }

    fn gap_m(&self, person: Point) -> f64 {
        (person - self.position).norm() - self.body_radius_m - PERSON_RADIUS_M
    }
}

impl Person {
    pub(crate) fn new(id: String, seed: u64, position: Point, walk: Walk) -> Self {
        let rng = stream(seed, "person", &id);
        Self {
            id,
            position,
            until: walk.until,
            speed_m_per_s: walk.speed_m_per_s,
            careless: walk.careless,
            goal: position,
            rests_until: Timestamp::ZERO,
            blocked_since: None,
            rng,
        }
    }

    /// Walks for one step; returns the number of the robot that was walked into, if any.
    pub(crate) fn step(
        &mut self,
        now: Timestamp,
        step_s: f64,
        map: &GridMap,
        robots: impl Iterator<Item = (usize, SeenRobot)>,
    ) -> Option<usize> {
        if now < self.rests_until {
            return None;
        }
        let to_go = self.goal - self.position;
        if to_go.norm() < 1e-3 {
            self.choose_goal(now, map);
            return None;
        }
        let step = to_go * (self.speed_m_per_s * step_s / to_go.norm()).min(1.0);
        let next = self.position + step;
        let mut in_the_way = false;
        for (number, robot) in robots {
            let (before_m, after_m) = (robot.gap_m(self.position), robot.gap_m(next));
            let nearer = after_m < before_m;
            if nearer && after_m < 0.0 && self.careless {
                self.give_up(now);
                return Some(number);
            }
            let steps_in = nearer && after_m < robot.room_m || robot.is_cut_off_by(self.position, next);
            in_the_way |= steps_in && !self.careless;
        }
        self.walk_or_wait(now, next, in_the_way);
        None
    }

    fn walk_or_wait(&mut self, now: Timestamp, next: Point, in_the_way: bool) {
        if !in_the_way {
            self.position = next;
            self.blocked_since = None;
        } else if now.since(*self.blocked_since.get_or_insert(now)) > PATIENCE {
            self.give_up(now);
        }
    }

    fn give_up(&mut self, now: Timestamp) {
        self.goal = self.position;
        self.blocked_since = None;
        self.rests_until = now + REST;
    }

    /// A place in sight, up to 8 m away.
    fn choose_goal(&mut self, now: Timestamp, map: &GridMap) {
        for _ in 0..8 {
            let angle = self.rng.random::<f64>() * TAU;
            let way = Vector::new(angle.cos(), angle.sin()) * (1.0 + 7.0 * self.rng.random::<f64>());
            let goal = self.position + way;
            if map.capsule_is_free(Segment::new(self.position, goal), PERSON_RADIUS_M) {
                self.goal = goal;
                return;
            }
        }
        self.rests_until = now + REST;
    }

    pub(crate) fn truth(&self) -> v1::ObstacleTruth {
        v1::ObstacleTruth {
            obstacle_id: self.id.clone(),
            centre: Some(v1::Point { x_m: self.position.x, y_m: self.position.y }),
            half_x_m: 0.0,
            half_y_m: 0.0,
            radius_m: PERSON_RADIUS_M,
            person: true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hall() -> GridMap {
        GridMap::from_drawing(&["............"; 12].join("\n"), 1.0).unwrap()
    }

    fn person(careless: bool) -> Person {
        let walk = Walk { speed_m_per_s: 1.0, careless, until: None };
        Person::new("p1".to_owned(), 3, Point::new(2.0, 2.0), walk)
    }

    fn walk(person: &mut Person, robot: Point, seconds: u64) -> Option<usize> {
        let seen = SeenRobot { position: robot, room_m: 0.4, body_radius_m: 0.2, ahead: Vector::zeros() };
        (0..seconds * 50).find_map(|tick| {
            let now = Timestamp::from_nanos(tick * 20_000_000);
            person.step(now, 0.02, &hall(), [(0, seen)].into_iter())
        })
    }

    #[test]
    fn a_person_walks_about_and_never_into_a_wall() {
        let mut person = person(false);
        let start = person.position;
        assert_eq!(walk(&mut person, Point::new(11.0, 11.0), 60), None);
        assert_ne!(person.position, start);
        assert!(hall().disc_is_free(person.position, PERSON_RADIUS_M));
    }

    #[test]
    fn one_who_looks_keeps_away_from_robots_and_a_careless_one_does_not() {
        let robot = Point::new(3.5, 2.0);
        let (mut looks, mut careless) = (person(false), person(true));
        assert_eq!(walk(&mut looks, robot, 300), None);
        looks.goal = robot;
        assert_eq!(walk(&mut careless, robot, 900), Some(0));
    }

    #[test]
    fn one_who_looks_does_not_cut_a_robot_off() {
        let robot = SeenRobot {
            position: Point::new(2.0, 2.0),
            room_m: 1.0,
            body_radius_m: 0.2,
            ahead: Vector::new(1.0, 0.0),
        };
        let step = |x, y| (Point::new(x, y), Point::new(x + 0.01, y - 0.005));
        let cuts_off = |(from, to)| robot.is_cut_off_by(from, to);
        assert!(cuts_off(step(3.0, 2.5)));
        assert!(!cuts_off(step(3.0, 2.8)), "far enough aside");
        assert!(!cuts_off(step(3.6, 2.5)), "far enough ahead");
        assert!(!cuts_off(step(1.9, 2.5)), "behind");
        assert!(!cuts_off(step(3.0, 1.8)), "on the way out");
    }
}
