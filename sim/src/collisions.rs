//! What is solid stops a body: walls, other bodies, obstacles, people. Each touch is reported once.

use crate::{
    contact::{Touch, least_distance_m, midpoint},
    people::PERSON_RADIUS_M,
    world::World,
};
use protocol::v1;
use terrain::{Point, Segment};

/// Two that touched have parted when there is so much between them, metres.
const PARTED_M: f64 = 0.02;
/// A body that would come this near is stopped; so a stopped body never overlaps, metres.
const SKIN_M: f64 = 1e-6;

impl World {
    /// Stops every body that would enter something solid in this step.
    pub(crate) fn stop_at_solid_things(&mut self) {
        for robot in 0..self.bodies.len() {
            let way = self.bodies[robot].way();
            if way.from != way.to {
                self.stop_at_walls(robot, way);
                self.stop_at_obstacles(robot, way);
                self.stop_at_people(robot, way);
            }
        }
        // A body that is stopped may now stand where another was let in: look again until nobody is.
        while self.stop_at_bodies() {}
        self.forget_parted();
    }

    fn stop_at_walls(&mut self, robot: usize, way: Segment) {
        let radius_m = self.body_radius_m();
        if self.walls.at_least_m(way.from) > radius_m + way.length()
            || self.scenario.map.capsule_is_free(way, radius_m - SKIN_M)
        {
            return;
        }
        let deeper = way.length() > 0.0;
        if deeper {
            self.bodies[robot].bump();
            self.report(Touch::Wall(robot), robot, "wall", way.to, false);
        }
    }

    fn stop_at_obstacles(&mut self, robot: usize, way: Segment) {
        let radius_m = self.body_radius_m();
        for number in 0..self.obstacles.len() {
            let shape = self.obstacles[number].shape;
            let near = (shape.centre() - way.from).norm() < shape.reach_m() + radius_m + way.length();
            if near
                && shape.distance_to_way_m(way) < radius_m + SKIN_M
                && shape.distance_m(way.to) <= shape.distance_m(way.from)
            {
                self.bodies[robot].bump();
                let id = self.obstacles[number].id.clone();
                self.report(Touch::Obstacle(robot, number), robot, &id, way.to, false);
            }
        }
    }

    fn stop_at_people(&mut self, robot: usize, way: Segment) {
        let apart_m = self.body_radius_m() + PERSON_RADIUS_M;
        for number in 0..self.people.len() {
            let person = self.people[number].position;
            let nearer = (way.to - person).norm() < (way.from - person).norm();
            if nearer && way.distance_to_point(person) < apart_m {
                self.bodies[robot].bump();
                let id = self.people[number].id.clone();
                self.report(Touch::Person(robot, number), robot, &id, midpoint(way.from, person), false);
            }
        }
    }

    /// Stops bodies that would touch each other; whether any was.
    fn stop_at_bodies(&mut self) -> bool {
        let apart_m = 2.0 * self.body_radius_m();
        let mut any = false;
        for a in 0..self.bodies.len() {
            if !self.bodies[a].on_floor {
                continue;
            }
            let way_a = self.bodies[a].way();
            let moves = way_a.from != way_a.to;
            for b in a + 1..self.bodies.len() {
                let way_b = self.bodies[b].way();
                let reach_m = apart_m + 0.5;
                let nothing_moves = !moves && way_b.from == way_b.to;
                if nothing_moves
                    || !self.bodies[b].on_floor
                    || (way_a.from - way_b.from).norm_squared() > reach_m * reach_m
                {
                    continue;
                }
                let least_m = least_distance_m(way_a, way_b);
                if least_m < apart_m + SKIN_M && least_m < (way_a.from - way_b.from).norm() - 1e-12 {
                    self.collide(a, b);
                    any = true;
                    break;
                }
            }
        }
        any
    }

    fn collide(&mut self, a: usize, b: usize) {
        let (at_a, at_b) = (self.bodies[a].position(), self.bodies[b].position());
        self.bodies[a].bump();
        self.bodies[b].bump();
        let other = self.bodies[b].id.clone();
        self.report(Touch::Robots(a, b), a, &other, midpoint(at_a, at_b), false);
    }

    fn report(&mut self, touch: Touch, robot: usize, other: &str, at: Point, person_walked_into: bool) {
        if self.touches.begin(touch) {
            self.contacts.push(v1::Contact {
                timestamp_ns: self.now.as_nanos(),
                serial_number: self.bodies[robot].id.clone(),
                other: other.to_owned(),
                position: Some(v1::Point { x_m: at.x, y_m: at.y }),
                person_walked_into,
            });
        }
    }

    /// A person walked up to a robot until they touched.
    pub(crate) fn person_touches(&mut self, person: usize, robot: usize) {
        let at = midpoint(self.people[person].position, self.bodies[robot].position());
        let id = self.people[person].id.clone();
        let stood = self.bodies[robot].speed_m_per_s.abs() < 0.05;
        self.report(Touch::Person(robot, person), robot, &id, at, stood);
    }

    fn forget_parted(&mut self) {
        if self.touches.is_empty() {
            return;
        }
        let mut touches = std::mem::take(&mut self.touches);
        touches.part(|touch| self.gap_m(touch) < PARTED_M);
        self.touches = touches;
    }

    fn gap_m(&self, touch: &Touch) -> f64 {
        let radius_m = self.body_radius_m();
        let at = |robot: usize| self.bodies[robot].position();
        match *touch {
            Touch::Robots(a, b) => (at(a) - at(b)).norm() - 2.0 * radius_m,
            Touch::Wall(a) if self.scenario.map.disc_is_free(at(a), radius_m + PARTED_M) => PARTED_M,
            Touch::Wall(_) => 0.0,
            Touch::Obstacle(a, number) => self
                .obstacles
                .get(number)
                .map_or(f64::INFINITY, |other| other.shape.distance_m(at(a)) - radius_m),
            Touch::Person(a, number) => self
                .people
                .get(number)
                .map_or(f64::INFINITY, |other| (other.position - at(a)).norm() - radius_m - PERSON_RADIUS_M),
        }
    }

    /// Whether a body can be set down here without touching anything; `but` is not looked at.
    pub(crate) fn is_free_for_body(&self, at: Point, but: Option<usize>) -> bool {
        let radius_m = self.body_radius_m();
        let apart_m = 2.0 * radius_m + 0.1;
        let others =
            self.bodies.iter().enumerate().filter(|&(other, body)| Some(other) != but && body.on_floor);
        self.scenario.map.disc_is_free(at, radius_m)
            && others.into_iter().all(|(_, body)| (body.position() - at).norm() > apart_m)
            && self.obstacles.iter().all(|obstacle| obstacle.shape.distance_m(at) > radius_m + 0.05)
            && self
                .people
                .iter()
                .all(|person| (person.position - at).norm() > radius_m + PERSON_RADIUS_M + 0.05)
    }
}
