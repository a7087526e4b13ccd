//! People on the floor. How they walk ([`Gait`]):
//!
//! - from one place they can see to the next, with a rest in between, each at their own speed;
//! - straight on until they meet a wall, an obstacle, another person or a robot, then in another direction: the
//!   walkers of the airport in the paper on boustrophedon coverage (see `docs/scenario.md`);
//! - not at all: they stand in a queue, for ever or until it moves, and then walk straight on.
//!
//! They look where they go: they never step into the way of a robot. Careless ones walk up to a robot until they
//! touch it.

use crate::{clearance::Clearance, obstacle::Obstacle, random_streams::stream};
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
/// Goals and directions that are tried before somebody rests instead.
const TRIES: usize = 8;

/// One person.
#[derive(Debug, Clone)]
pub(crate) struct Person {
    pub(crate) id: String,
    pub(crate) position: Point,
    pub(crate) until: Option<Timestamp>,
    speed_m_per_s: f64,
    careless: bool,
    gait: Gait,
    rests_until: Timestamp,
    rng: ChaCha8Rng,
}

/// How somebody walks, and how far they have come with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Gait {
    /// From one place in sight to the next.
    ToPlaces {
        /// The place.
        goal: Option<Point>,
        /// Since when the way there is taken.
        blocked_since: Option<Timestamp>,
    },
    /// Straight on until something is met.
    UntilContact {
        /// Of length 1; zero before the first step.
        direction: Vector,
    },
    /// Stands.
    Stands {
        /// Walks straight on from then on.
        leaves_at: Option<Timestamp>,
    },
}

impl Gait {
    /// From one place in sight to the next.
    pub(crate) const TO_PLACES: Self = Self::ToPlaces { goal: None, blocked_since: None };

    /// Straight on until something is met.
    pub(crate) fn until_contact() -> Self {
        Self::UntilContact { direction: Vector::zeros() }
    }
}

/// How somebody walks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Walk {
    pub(crate) gait: Gait,
    pub(crate) speed_m_per_s: f64,
    pub(crate) careless: bool,
    pub(crate) until: Option<Timestamp>,
}

/// What people see around them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Surroundings<'a> {
    pub(crate) map: &'a GridMap,
    pub(crate) walls: &'a Clearance,
    pub(crate) obstacles: &'a [Obstacle],
    /// All people, and which of them is the one who looks.
    pub(crate) people: &'a [Point],
    pub(crate) own: usize,
    /// The robots on the floor, with their numbers.
    pub(crate) robots: &'a [(usize, SeenRobot)],
}

impl Surroundings<'_> {
    /// Whether a step leads into a wall, an obstacle or another person.
    fn is_solid(&self, from: Point, to: Point) -> bool {
        let wall = self.walls.at_least_m(to) < PERSON_RADIUS_M && !self.map.disc_is_free(to, PERSON_RADIUS_M);
        wall || self.meets_obstacle(from, to) || self.meets_person(from, to)
    }

    fn meets_obstacle(&self, from: Point, to: Point) -> bool {
        self.obstacles.iter().any(|obstacle| {
            let after_m = obstacle.shape.distance_m(to);
            after_m < PERSON_RADIUS_M && after_m <= obstacle.shape.distance_m(from)
        })
    }

    fn meets_person(&self, from: Point, to: Point) -> bool {
        let apart_m2 = (2.0 * PERSON_RADIUS_M).powi(2);
        self.people.iter().enumerate().any(|(number, other)| {
            let after_m2 = (other - to).norm_squared();
            number != self.own && after_m2 < apart_m2 && after_m2 < (other - from).norm_squared()
        })
    }
}

/// What a step leads to.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Step {
    Free,
    /// Somebody who looks would step into the way of a robot.
    InTheWay,
    /// Somebody careless walks into the robot of this number.
    Touches(usize),
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
            gait: walk.gait,
            rests_until: Timestamp::ZERO,
            rng,
        }
    }

    /// Whether it stands in a queue.
    pub(crate) fn stands(&self) -> bool {
        matches!(self.gait, Gait::Stands { .. })
    }

    /// Walks for one step; returns the number of the robot that was walked into, if any.
    pub(crate) fn step(&mut self, now: Timestamp, step_s: f64, around: &Surroundings<'_>) -> Option<usize> {
        if now < self.rests_until {
            return None;
        }
        match self.gait {
            Gait::ToPlaces { goal, .. } => self.step_to_place(now, step_s, goal, around),
            Gait::UntilContact { direction } => self.step_straight_on(now, step_s, direction, around),
            Gait::Stands { leaves_at } => {
                if leaves_at.is_some_and(|at| now >= at) {
                    self.gait = Gait::until_contact();
                }
                None
            }
        }
    }

    fn step_to_place(
        &mut self,
        now: Timestamp,
        step_s: f64,
        goal: Option<Point>,
        around: &Surroundings<'_>,
    ) -> Option<usize> {
        let to_go = goal.map_or(Vector::zeros(), |goal| goal - self.position);
        if to_go.norm() < 1e-3 {
            self.choose_goal(now, around.map);
            return None;
        }
        let next = self.position + to_go * (self.speed_m_per_s * step_s / to_go.norm()).min(1.0);
        match self.look(next, around.robots) {
            Step::Touches(robot) => {
                self.go_elsewhere(now);
                return Some(robot);
            }
            Step::InTheWay => self.wait(now),
            Step::Free => self.walk_on(next),
        }
        None
    }

    fn step_straight_on(
        &mut self,
        now: Timestamp,
        step_s: f64,
        direction: Vector,
        around: &Surroundings<'_>,
    ) -> Option<usize> {
        let stride_m = self.speed_m_per_s * step_s;
        let next = self.position + direction * stride_m;
        let step = self.look(next, around.robots);
        if step == Step::Free && direction != Vector::zeros() && !around.is_solid(self.position, next) {
            self.position = next;
            return None;
        }
        self.turn(now, stride_m, around);
        if let Step::Touches(robot) = step { Some(robot) } else { None }
    }

    /// Chooses another direction in which the next step is free.
    fn turn(&mut self, now: Timestamp, stride_m: f64, around: &Surroundings<'_>) {
        for _ in 0..TRIES {
            let angle = self.rng.random::<f64>() * TAU;
            let direction = Vector::new(angle.cos(), angle.sin());
            let next = self.position + direction * stride_m;
            if self.look(next, around.robots) == Step::Free && !around.is_solid(self.position, next) {
                self.gait = Gait::UntilContact { direction };
                return;
            }
        }
        self.rests_until = now + REST;
    }

    fn look(&self, next: Point, robots: &[(usize, SeenRobot)]) -> Step {
        let mut step = Step::Free;
        for &(number, ref robot) in robots {
            let (before_m, after_m) = (robot.gap_m(self.position), robot.gap_m(next));
            let nearer = after_m < before_m;
            if nearer && after_m < 0.0 && self.careless {
                return Step::Touches(number);
            }
            let steps_in = nearer && after_m < robot.room_m || robot.is_cut_off_by(self.position, next);
            if steps_in && !self.careless {
                step = Step::InTheWay;
            }
        }
        step
    }

    fn walk_on(&mut self, next: Point) {
        self.position = next;
        if let Gait::ToPlaces { blocked_since, .. } = &mut self.gait {
            *blocked_since = None;
        }
    }

    fn wait(&mut self, now: Timestamp) {
        if let Gait::ToPlaces { blocked_since, .. } = &mut self.gait
            && now.since(*blocked_since.get_or_insert(now)) > PATIENCE
        {
            self.go_elsewhere(now);
        }
    }

    fn go_elsewhere(&mut self, now: Timestamp) {
        self.gait = Gait::TO_PLACES;
        self.rests_until = now + REST;
    }

    /// A place in sight, up to 8 m away.
    fn choose_goal(&mut self, now: Timestamp, map: &GridMap) {
        for _ in 0..TRIES {
            let angle = self.rng.random::<f64>() * TAU;
            let way = Vector::new(angle.cos(), angle.sin()) * (1.0 + 7.0 * self.rng.random::<f64>());
            let goal = self.position + way;
            if map.capsule_is_free(Segment::new(self.position, goal), PERSON_RADIUS_M) {
                self.gait = Gait::ToPlaces { goal: Some(goal), blocked_since: None };
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

    const LEFT: Point = Point::new(2.0, 2.0);

    fn hall() -> GridMap {
        GridMap::from_drawing(&["............"; 12].join("\n"), 1.0).unwrap()
    }

    fn person(gait: Gait, careless: bool) -> Person {
        let walk = Walk { gait, speed_m_per_s: 1.0, careless, until: None };
        Person::new("p1".to_owned(), 3, LEFT, walk)
    }

    /// Walks beside a robot at rest, and somebody who stands; calls `see` after each step.
    fn walk(person: &mut Person, robot: Point, seconds: u64, mut see: impl FnMut(&Person)) -> Option<usize> {
        let seen = SeenRobot { position: robot, room_m: 0.4, body_radius_m: 0.2, ahead: Vector::zeros() };
        let (map, other) = (hall(), Point::new(6.0, 6.0));
        let walls = Clearance::new(&map);
        (0..seconds * 50).find_map(|tick| {
            let around = Surroundings {
                map: &map,
                walls: &walls,
                obstacles: &[],
                people: &[person.position, other],
                own: 0,
                robots: &[(0, seen)],
            };
            let touched = person.step(Timestamp::from_nanos(tick * 20_000_000), 0.02, &around);
            see(person);
            touched
        })
    }

    #[test]
    fn a_person_walks_about_and_never_into_a_wall() {
        for gait in [Gait::TO_PLACES, Gait::until_contact()] {
            let mut person = person(gait, false);
            let (map, mut way_m, mut before) = (hall(), 0.0, LEFT);
            let touched = walk(&mut person, Point::new(11.0, 11.0), 60, |person| {
                way_m += (person.position - before).norm();
                before = person.position;
                assert!(map.disc_is_free(person.position, PERSON_RADIUS_M));
            });
            assert_eq!(touched, None);
            assert!(way_m > 20.0, "{way_m}");
        }
    }

    #[test]
    fn one_who_walks_straight_on_turns_only_where_something_is_met() {
        let mut person = person(Gait::until_contact(), false);
        let (mut turns, mut before) = (0, person.gait);
        walk(&mut person, Point::new(3.0, 9.0), 300, |person| {
            if person.gait != before && before != Gait::until_contact() {
                turns += 1;
                let at = person.position;
                let wall_m = at.x.min(at.y).min(12.0 - at.x).min(12.0 - at.y);
                let other_m = (at - Point::new(6.0, 6.0)).norm();
                let robot_m = (at - Point::new(3.0, 9.0)).norm();
                assert!(wall_m < 0.3 || other_m < 0.55 || robot_m < 0.9, "turns at {at}");
            }
            before = person.gait;
        });
        assert!(turns > 20, "{turns}");
    }

    #[test]
    fn one_who_stands_does_so_until_the_queue_moves() {
        let later = Timestamp::from_secs_f64(10.0);
        let mut person = person(Gait::Stands { leaves_at: Some(later) }, false);
        walk(&mut person, Point::new(11.0, 11.0), 9, |person| assert!(person.stands()));
        assert_eq!(person.position, LEFT);
        walk(&mut person, Point::new(11.0, 11.0), 20, |_| {});
        assert!(!person.stands() && person.position != LEFT);
    }

    #[test]
    fn one_who_looks_keeps_away_from_robots_and_a_careless_one_does_not() {
        let robot = Point::new(3.5, 2.0);
        let (to_robot, straight) =
            (Gait::ToPlaces { goal: Some(robot), blocked_since: None }, Gait::until_contact());
        for gait in [to_robot, straight] {
            assert_eq!(walk(&mut person(gait, false), robot, 300, |_| {}), None);
            assert_eq!(walk(&mut person(gait, true), robot, 900, |_| {}), Some(0));
        }
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
