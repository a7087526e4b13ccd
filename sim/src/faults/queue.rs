//! People queue: they stand one behind the other, for ever, for a while, or until the queue moves; then they walk
//! straight on until they meet something, like the walkers of [`super::People`].

use super::{FaultKind, between, for_a_while, how_long, number};
use crate::{
    people::{Gait, PERSON_RADIUS_M, Person, Walk},
    scenario::Scenario,
    world::World,
};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;
use terrain::{Point, Vector};

/// People queue.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Queue {
    /// How many.
    pub count: u32,
    /// Where the first one stands, metres.
    pub x_m: f64,
    /// Where the first one stands, metres.
    pub y_m: f64,
    /// Where the next ones stand from there, degrees anticlockwise from x.
    #[serde(default)]
    pub theta_deg: f64,
    /// From one to the next, metres.
    #[serde(default = "default_spacing")]
    pub spacing_m: f64,
    /// When the queue moves and its people walk about, seconds from now; left out: never.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub moves_after_s: Option<f64>,
    /// How fast they walk then, m/s.
    #[serde(default = "default_speed")]
    pub speed_m_per_s: f64,
    /// How long they stay, seconds; left out: for ever.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub for_s: Option<f64>,
}

fn default_spacing() -> f64 {
    0.8
}

fn default_speed() -> f64 {
    0.8
}

impl Queue {
    fn places(&self) -> impl Iterator<Item = Point> + use<> {
        let (head, theta_rad) = (Point::new(self.x_m, self.y_m), self.theta_deg.to_radians());
        let step = Vector::new(theta_rad.cos(), theta_rad.sin()) * self.spacing_m;
        (0..self.count).map(move |number| head + step * f64::from(number))
    }

    fn is_on_free_ground(&self, scenario: &Scenario) -> Result<(), String> {
        let in_wall = |at: &Point| !scenario.map.disc_is_free(*at, PERSON_RADIUS_M);
        self.places().enumerate().find(|(_, at)| in_wall(at)).map_or(Ok(()), |(number, at)| {
            Err(format!(
                "person {} of the queue would stand in a wall at ({:.2}, {:.2}) m: change `x_m`, `y_m` or \
                 `theta_deg`, or lower `count`",
                number + 1,
                at.x,
                at.y
            ))
        })
    }
}

impl FaultKind for Queue {
    fn target(&self) -> String {
        "floor".to_owned()
    }

    fn check(&self, scenario: &Scenario) -> Result<(), String> {
        number("count", f64::from(self.count), 1.0, 1000.0)?;
        let (low, high) = (scenario.map.origin(), scenario.map.corner());
        number("x_m", self.x_m, low.x, high.x)?;
        number("y_m", self.y_m, low.y, high.y)?;
        number("theta_deg", self.theta_deg, -360.0, 360.0)?;
        number("spacing_m", self.spacing_m, 2.0 * PERSON_RADIUS_M, 100.0)?;
        number("speed_m_per_s", self.speed_m_per_s, 0.05, 5.0)?;
        self.moves_after_s.map_or(Ok(()), |seconds| number("moves_after_s", seconds, 0.0, 1e6))?;
        for_a_while(self.for_s)?;
        self.is_on_free_ground(scenario)
    }

    fn inject(&self, world: &mut World) -> Option<String> {
        let leaves_at = world.after(self.moves_after_s);
        let walk = Walk {
            gait: Gait::Stands { leaves_at },
            speed_m_per_s: self.speed_m_per_s,
            careless: false,
            until: world.after(self.for_s),
        };
        let mut joined = 0;
        for at in self.places() {
            world.person_count += 1;
            if world.is_free_for_person(at) {
                let id = format!("person-{}", world.person_count);
                world.people.push(Person::new(id, world.seed, at, walk));
                joined += 1;
            }
        }
        let moves = self.moves_after_s.map_or(String::new(), |seconds| format!(", moves after {seconds:.0} s"));
        let (x, y) = (self.x_m, self.y_m);
        Some(format!("{joined} people queue at ({x:.2}, {y:.2}) m {}{moves}", how_long(self.for_s)))
    }

    fn random(rng: &mut ChaCha8Rng, scenario: &Scenario) -> Self {
        let lattice = scenario.floor.lattice();
        let free: Vec<Point> = lattice
            .cells()
            .map(|cell| lattice.center(cell))
            .filter(|&at| scenario.map.disc_is_free(at, PERSON_RADIUS_M))
            .collect();
        let head = free[rng.random_range(0..free.len())];
        let quarter = f64::from(rng.random_range(0..4)) * FRAC_PI_2;
        let mut queue = Self {
            count: rng.random_range(2..=4),
            x_m: head.x,
            y_m: head.y,
            theta_deg: quarter.to_degrees(),
            spacing_m: between(rng, 0.6, 1.0),
            moves_after_s: rng.random_bool(0.5).then(|| between(rng, 5.0, 30.0)),
            speed_m_per_s: between(rng, 0.3, 1.2),
            for_s: Some(between(rng, 10.0, 90.0)),
        };
        while queue.is_on_free_ground(scenario).is_err() {
            queue.count -= 1; // The first one stands on free ground.
        }
        queue
    }
}
