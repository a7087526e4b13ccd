//! Contacts between bodies, and of bodies with walls, obstacles and people: swept along each step, in closed
//! form for discs, so that nothing slips through between two truths.

use crate::verify::truth::Step;
use protocol::v1;
use std::collections::{BTreeMap, BTreeSet};
use terrain::{GridMap, Point, Segment, Vector};

/// Touching is no contact, and rounding is none either.
const SLACK_M: f64 = 0.001;
/// A robot that stands is not to blame for whoever walks into it.
const STANDING_M_PER_S: f64 = 0.05;

/// One contact, from its first moment.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Contact {
    pub(crate) robot: String,
    pub(crate) other: String,
    pub(crate) place: Point,
    pub(crate) kind: ContactKind,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ContactKind {
    Robot,
    Wall,
    Obstacle,
    Person,
}

/// Contacts that last, so that each is told once, and the smallest distance seen.
#[derive(Debug)]
pub(crate) struct Contacts {
    lasting: BTreeSet<(String, String)>,
    excused: BTreeSet<(String, String)>,
    obstacles_before: BTreeMap<String, v1::ObstacleTruth>,
    pub(crate) smallest_gap_m: f64,
}

impl Default for Contacts {
    fn default() -> Self {
        Self {
            lasting: BTreeSet::new(),
            excused: BTreeSet::new(),
            obstacles_before: BTreeMap::new(),
            smallest_gap_m: f64::INFINITY,
        }
    }
}

impl Contacts {
    /// The contacts that begin in this step of the world.
    pub(crate) fn begin(
        &mut self,
        steps: &[Step<'_>],
        obstacles: &[v1::ObstacleTruth],
        map: &GridMap,
        radius_m: impl Fn(&str) -> f64,
    ) -> Vec<Contact> {
        let on_floor: Vec<&Step<'_>> = steps.iter().filter(|step| step.now.on_floor).collect();
        let mut touching = Vec::new();
        for (at, step) in on_floor.iter().enumerate() {
            let radius = radius_m(step.robot);
            for other in &on_floor[at + 1..] {
                let gap_m = disc_distance(step, other) - radius - radius_m(other.robot);
                self.smallest_gap_m = self.smallest_gap_m.min(gap_m);
                if gap_m < -SLACK_M {
                    touching.push(contact(step, other.robot, ContactKind::Robot));
                }
            }
            if !map.capsule_is_free(step.segment(), radius - SLACK_M) {
                touching.push(contact(step, "wall", ContactKind::Wall));
            }
            touching.extend(self.touched_obstacles(step, obstacles, radius));
        }
        self.obstacles_before = obstacles.iter().map(|now| (now.obstacle_id.clone(), now.clone())).collect();
        self.new_ones(touching)
    }

    fn touched_obstacles(
        &mut self,
        step: &Step<'_>,
        obstacles: &[v1::ObstacleTruth],
        radius_m: f64,
    ) -> Vec<Contact> {
        let mut touched = Vec::new();
        for obstacle in obstacles {
            let before = self.obstacles_before.get(&obstacle.obstacle_id);
            let distance_m = obstacle_distance(step, before, obstacle);
            let key = (step.robot.to_owned(), obstacle.obstacle_id.clone());
            if distance_m >= radius_m - SLACK_M {
                self.excused.remove(&key);
            } else if obstacle.person {
                if is_moving(step) {
                    touched.push(contact(step, &obstacle.obstacle_id, ContactKind::Person));
                }
            } else if before.is_none() {
                self.excused.insert(key);
            } else if !self.excused.contains(&key) {
                touched.push(contact(step, &obstacle.obstacle_id, ContactKind::Obstacle));
            }
        }
        touched
    }

    fn new_ones(&mut self, touching: Vec<Contact>) -> Vec<Contact> {
        let key = |contact: &Contact| (contact.robot.clone(), contact.other.clone());
        let before = std::mem::replace(&mut self.lasting, touching.iter().map(key).collect());
        touching.into_iter().filter(|contact| !before.contains(&key(contact))).collect()
    }
}

fn contact(step: &Step<'_>, other: &str, kind: ContactKind) -> Contact {
    Contact { robot: step.robot.to_owned(), other: other.to_owned(), place: step.to, kind }
}

fn is_moving(step: &Step<'_>) -> bool {
    let before = step.before.map_or(0.0, |before| before.speed_m_per_s.abs());
    step.now.speed_m_per_s.abs().max(before) > STANDING_M_PER_S
}

/// Smallest distance of two centres while both move evenly: that of a point to the line of the difference.
fn disc_distance(a: &Step<'_>, b: &Step<'_>) -> f64 {
    let apart = |from: Point, to: Point| Point::from(to - from);
    Segment::new(apart(a.from, b.from), apart(a.to, b.to)).distance_to_point(Point::origin())
}

/// Smallest distance of a body's centre to an obstacle during a step, seen from the obstacle.
fn obstacle_distance(step: &Step<'_>, before: Option<&v1::ObstacleTruth>, now: &v1::ObstacleTruth) -> f64 {
    let there = centre(now);
    let way = match before {
        Some(before) => Segment::new(step.from - centre(before), step.to - there),
        None => Segment::new(step.to - there, step.to - there),
    };
    if now.radius_m > 0.0 {
        return (way.distance_to_point(Point::origin()) - now.radius_m).max(0.0);
    }
    distance_to_box(way, now.half_x_m, now.half_y_m)
}

fn centre(obstacle: &v1::ObstacleTruth) -> Vector {
    obstacle.centre.map_or_else(Vector::zeros, |centre| Vector::new(centre.x_m, centre.y_m))
}

fn distance_to_box(way: Segment, half_x_m: f64, half_y_m: f64) -> f64 {
    let corner = |x: f64, y: f64| Point::new(x * half_x_m, y * half_y_m);
    let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    if way.from.x.abs() <= half_x_m && way.from.y.abs() <= half_y_m {
        return 0.0;
    }
    (0..4)
        .map(|side| way.distance(&Segment::new(corners[side], corners[(side + 1) % 4])))
        .fold(f64::INFINITY, f64::min)
}
