//! Small worlds for tests.

use crate::{Scenario, ScenarioFile, World};
use protocol::v1;
use std::fmt::Write;
use std::sync::Arc;
use terrain::GridMap;

/// A scenario on a drawing with 1 m a character, robots `r1`, `r2`, … at `starts`, and a station at the first.
pub(crate) fn scenario(drawing: &str, starts: &[(f64, f64)]) -> Arc<Scenario> {
    let mut text = "[mission]\nmap = \"none.map\"\n".to_owned();
    for (number, (x, y)) in starts.iter().enumerate() {
        write!(text, "[[robots]]\nid = \"r{}\"\nx_m = {x:?}\ny_m = {y:?}\n", number + 1).unwrap();
    }
    let (x, y) = starts[0];
    write!(text, "[[stations]]\nid = \"s1\"\nx_m = {x:?}\ny_m = {y:?}\n").unwrap();
    let file: ScenarioFile = toml::from_str(&text).unwrap();
    Arc::new(Scenario::on_map(file, GridMap::from_drawing(drawing, 1.0).unwrap()).unwrap())
}

pub(crate) fn world(drawing: &str, starts: &[(f64, f64)]) -> World {
    World::new(&scenario(drawing, starts), 1)
}

/// Lets a robot drive with its tool on, under a grant that holds.
pub(crate) fn drive(world: &mut World, robot: usize, speed: f64, turn: f64, seconds: f64) {
    for _ in 0..(seconds * 50.0) as usize {
        let setpoint = v1::Setpoint {
            speed_m_per_s: speed,
            angular_speed_rad_per_s: turn,
            tool_active: true,
            term: 1,
            epoch: 1,
            boot_id: 7,
            valid_until_ns: u64::MAX,
            ..v1::Setpoint::default()
        };
        world.setpoint(robot, &setpoint);
        world.step();
    }
}
