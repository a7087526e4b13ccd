//! People come onto the floor and walk about.

use super::{FaultKind, between, for_a_while, how_long, number};
use crate::{
    people::{Gait, PERSON_RADIUS_M, Person, Walk},
    random_streams::stream,
    scenario::Scenario,
    world::World,
};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use terrain::Point;

/// People come onto the floor and walk about.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct People {
    /// How many.
    pub count: u32,
    /// How they walk.
    #[serde(default)]
    pub walk: WalkKind,
    /// How fast they walk, m/s.
    #[serde(default = "default_speed")]
    pub speed_m_per_s: f64,
    /// Whether they walk on without looking for robots.
    #[serde(default)]
    pub careless: bool,
    /// How long they stay, seconds; left out: for ever.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub for_s: Option<f64>,
}

/// How people walk.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WalkKind {
    /// From one place in sight to the next.
    #[default]
    ToPlaces,
    /// Straight on until they meet something, then in another direction.
    UntilContact,
}

impl WalkKind {
    fn gait(self) -> Gait {
        match self {
            Self::ToPlaces => Gait::TO_PLACES,
            Self::UntilContact => Gait::until_contact(),
        }
    }
}

fn default_speed() -> f64 {
    0.8
}

impl FaultKind for People {
    fn target(&self) -> String {
        "floor".to_owned()
    }

    fn check(&self, _scenario: &Scenario) -> Result<(), String> {
        number("count", f64::from(self.count), 1.0, 1000.0)?;
        number("speed_m_per_s", self.speed_m_per_s, 0.05, 5.0)?;
        for_a_while(self.for_s)
    }

    fn inject(&self, world: &mut World) -> Option<String> {
        let walk = Walk {
            gait: self.walk.gait(),
            speed_m_per_s: self.speed_m_per_s,
            careless: self.careless,
            until: world.after(self.for_s),
        };
        for _ in 0..self.count {
            world.person_count += 1;
            let id = format!("person-{}", world.person_count);
            if let Some(at) = world.place_for_person(&id) {
                world.people.push(Person::new(id, world.seed, at, walk));
            }
        }
        Some(format!("{} people walk about {}", self.count, how_long(self.for_s)))
    }

    fn random(rng: &mut ChaCha8Rng, _scenario: &Scenario) -> Self {
        Self {
            count: rng.random_range(1..=3),
            walk: if rng.random_bool(0.5) { WalkKind::ToPlaces } else { WalkKind::UntilContact },
            speed_m_per_s: between(rng, 0.3, 1.2),
            careless: false,
            for_s: Some(between(rng, 10.0, 90.0)),
        }
    }
}

impl World {
    /// A free place well away from robots, if one is found.
    fn place_for_person(&self, id: &str) -> Option<Point> {
        let mut rng = stream(self.seed, "person's place", id);
        let lattice = self.scenario.floor.lattice();
        (0..200)
            .map(|_| lattice.center(lattice.cell(rng.random_range(0..lattice.len()))))
            .find(|&at| self.is_free_for_person(at))
    }

    /// Whether somebody can come onto the floor here: well away from robots, and in nobody's place.
    pub(super) fn is_free_for_person(&self, at: Point) -> bool {
        let away_m = self.body_radius_m() + PERSON_RADIUS_M + 1.0;
        self.scenario.map.disc_is_free(at, PERSON_RADIUS_M)
            && self.bodies.iter().all(|body| !body.on_floor || (body.position() - at).norm() > away_m)
            && self.people.iter().all(|other| (other.position - at).norm() >= 2.0 * PERSON_RADIUS_M)
            && self.obstacles.iter().all(|other| other.shape.distance_m(at) > PERSON_RADIUS_M)
    }
}
