//! Something solid is put on the floor: for ever or for a while. Nobody puts a pallet on a robot, or so near in
//! front of one that it could not stop: it waits until the place is free.

use super::{FaultKind, between, for_a_while, how_long, now_and_then, number};
use crate::{
    obstacle::{Obstacle, Shape},
    people::PERSON_RADIUS_M,
    scenario::Scenario,
    world::World,
};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Something solid is put on the floor: a disc (`radius_m`), or a rectangle (`width_m` along x, `height_m` along y).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Block {
    /// Its middle, metres.
    pub x_m: f64,
    /// Its middle, metres.
    pub y_m: f64,
    /// Radius of a disc, metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius_m: Option<f64>,
    /// Size of a rectangle along x, metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width_m: Option<f64>,
    /// Size of a rectangle along y, metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height_m: Option<f64>,
    /// How long, seconds; left out: for ever.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub for_s: Option<f64>,
}

impl Block {
    fn shape(&self) -> Option<Shape> {
        let (x_m, y_m) = (self.x_m, self.y_m);
        match (self.radius_m, self.width_m, self.height_m) {
            (Some(radius_m), None, None) => Some(Shape::Disc { x_m, y_m, radius_m }),
            (None, Some(width_m), Some(height_m)) => Some(Shape::Rectangle { x_m, y_m, width_m, height_m }),
            _ => None,
        }
    }
}

impl FaultKind for Block {
    fn target(&self) -> String {
        "floor".to_owned()
    }

    fn check(&self, scenario: &Scenario) -> Result<(), String> {
        let (low, high) = (scenario.map.origin(), scenario.map.corner());
        number("x_m", self.x_m, low.x, high.x)?;
        number("y_m", self.y_m, low.y, high.y)?;
        for (key, size) in [("radius_m", self.radius_m), ("width_m", self.width_m), ("height_m", self.height_m)] {
            size.map_or(Ok(()), |size| number(key, size, 0.01, 1e4))?;
        }
        for_a_while(self.for_s)?;
        let form = "give `radius_m` for a disc, or `width_m` and `height_m` for a rectangle";
        self.shape().map(|_| ()).ok_or_else(|| form.to_owned())
    }

    fn inject(&self, world: &mut World) -> Option<String> {
        world.deliveries.push(Delivery { shape: self.shape().expect("checked"), for_s: self.for_s });
        None
    }

    fn random(rng: &mut ChaCha8Rng, scenario: &Scenario) -> Self {
        let lattice = scenario.floor.lattice();
        let drivable: Vec<usize> = (0..lattice.len()).filter(|&cell| scenario.floor.is_drivable(cell)).collect();
        let at = lattice.center(lattice.cell(drivable[rng.random_range(0..drivable.len())]));
        let disc = rng.random_bool(0.5);
        let (a, b) = (between(rng, 0.2, 1.0), between(rng, 0.2, 1.0));
        Self {
            x_m: at.x,
            y_m: at.y,
            radius_m: disc.then_some(a / 2.0),
            width_m: (!disc).then_some(a),
            height_m: (!disc).then_some(b),
            for_s: now_and_then(rng, 5.0, 60.0),
        }
    }
}

/// Something that waits to be put on the floor.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Delivery {
    shape: Shape,
    for_s: Option<f64>,
}

impl World {
    /// Puts down what finds its place free.
    pub(crate) fn deliver(&mut self) {
        let mut waiting = std::mem::take(&mut self.deliveries);
        waiting.retain(|delivery| !self.put_down(delivery));
        self.deliveries = waiting;
    }

    fn put_down(&mut self, delivery: &Delivery) -> bool {
        let radius_m = self.body_radius_m();
        let shape = delivery.shape;
        let clear_of_robots = self.bodies.iter().filter(|body| body.on_floor).all(|body| {
            let room_m = radius_m + 0.15 + body.stopping_m() + 0.4 * body.speed_m_per_s.abs();
            shape.distance_m(body.position()) > room_m
        });
        let clear_of_people =
            self.people.iter().all(|person| shape.distance_m(person.position) > PERSON_RADIUS_M);
        if !(clear_of_robots && clear_of_people) {
            return false;
        }
        self.obstacle_count += 1;
        let id = format!("b{}", self.obstacle_count);
        let until = self.after(delivery.for_s);
        self.obstacles.push(Obstacle { id: id.clone(), shape, until });
        let at = shape.centre();
        let text = format!("ground is blocked at ({:.2}, {:.2}) m {}", at.x, at.y, how_long(delivery.for_s));
        self.tell("block", &id, &text);
        true
    }
}
