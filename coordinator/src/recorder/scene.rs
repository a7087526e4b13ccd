//! What stands and moves on the floor, as bodies with labels: robots, stations, zones.
//!
//! A robot's body is fixed in the robot's own frame, so the viewer moves it with `/tf`; it is written again only
//! when its label changes. What is gone is deleted, or its ghost would stay.

use super::log_file::{LogFile, RecordError, TopicId};
use super::palette::{self, Rgba};
use super::viewer::{MAP_FRAME, base_frame, pose_at};
use foxglove::messages::scene_entity_deletion::Type as Deletion;
use foxglove::messages::{
    ArrowPrimitive, CubePrimitive, CylinderPrimitive, Pose, SceneEntity, SceneEntityDeletion, SceneUpdate,
    TextPrimitive, Vector3,
};
use protocol::{Timestamp, v1};
use std::collections::BTreeMap;
use std::io::Write;
use std::time::Duration;

const INTERVAL: Duration = Duration::from_millis(200);
const BODY_HEIGHT_M: f64 = 0.3;
const ZONE_HEIGHT_M: f64 = 0.1;
const CHARGE_STEP_PERCENT: f64 = 5.0;

/// The scene as it was last written.
pub(super) struct Scene {
    topic: TopicId,
    cell_m: f64,
    shown: BTreeMap<String, SceneEntity>,
    due: Timestamp,
}

impl Scene {
    pub(super) fn new<W: Write>(file: &mut LogFile<W>, cell_m: f64) -> Result<Self, RecordError> {
        let topic = file.add_drawn_topic::<SceneUpdate>("/fleet/scene")?;
        Ok(Self { topic, cell_m, shown: BTreeMap::new(), due: Timestamp::ZERO })
    }

    /// Writes what changed since the last time, if it is time.
    pub(super) fn draw_if_due<W: Write>(
        &mut self,
        file: &mut LogFile<W>,
        status: &v1::FleetStatus,
        colour: impl FnMut(&str) -> Rgba,
    ) -> Result<(), RecordError> {
        if file.now() < self.due {
            return Ok(());
        }
        let wanted = self.entities(status, colour);
        let mut update = SceneUpdate { deletions: self.deletions(file, &wanted), entities: Vec::new() };
        for (id, entity) in &wanted {
            if self.shown.get(id) != Some(entity) {
                update.entities.push(SceneEntity { timestamp: Some(file.stamp()), ..entity.clone() });
            }
        }
        self.shown = wanted;
        if update.entities.is_empty() && update.deletions.is_empty() {
            return Ok(());
        }
        self.due = file.now() + INTERVAL;
        file.write(self.topic, &update)
    }

    fn deletions<W: Write>(
        &self,
        file: &LogFile<W>,
        wanted: &BTreeMap<String, SceneEntity>,
    ) -> Vec<SceneEntityDeletion> {
        let deletion = |id: &String| SceneEntityDeletion {
            timestamp: Some(file.stamp()),
            r#type: Deletion::MatchingId as i32,
            id: id.clone(),
        };
        self.shown.keys().filter(|id| !wanted.contains_key(*id)).map(deletion).collect()
    }

    fn entities(
        &self,
        status: &v1::FleetStatus,
        mut colour: impl FnMut(&str) -> Rgba,
    ) -> BTreeMap<String, SceneEntity> {
        let is_there =
            |robot: &&v1::RobotStatus| robot.role != v1::RobotRole::RoleLost as i32 && robot.pose.is_some();
        let robots = status.robots.iter().filter(is_there).map(|robot| {
            let rgba = colour(&robot.serial_number);
            robot_entity(robot, rgba)
        });
        let stations = status.stations.iter().map(station_entity);
        let zones = status.zones.iter().map(|zone| zone_entity(zone, self.cell_m));
        robots.chain(stations).chain(zones).map(|entity| (entity.id.clone(), entity)).collect()
    }
}

fn robot_entity(robot: &v1::RobotStatus, rgba: Rgba) -> SceneEntity {
    let radius_m = robot.body_radius_m;
    let body = CylinderPrimitive {
        pose: Some(at(0.0, 0.0, BODY_HEIGHT_M / 2.0)),
        size: Some(Vector3 { x: 2.0 * radius_m, y: 2.0 * radius_m, z: BODY_HEIGHT_M }),
        bottom_scale: 1.0,
        top_scale: 1.0,
        color: Some(palette::color(rgba)),
    };
    let nose = ArrowPrimitive {
        pose: Some(at(0.0, 0.0, BODY_HEIGHT_M)),
        shaft_length: radius_m * 0.6,
        shaft_diameter: radius_m * 0.2,
        head_length: radius_m * 0.4,
        head_diameter: radius_m * 0.4,
        color: Some(palette::color(palette::WALL)),
    };
    SceneEntity {
        cylinders: vec![body],
        arrows: vec![nose],
        texts: vec![label(robot_label(robot), BODY_HEIGHT_M + 0.3)],
        ..entity(format!("robot/{}", robot.serial_number), &base_frame(&robot.serial_number))
    }
}

fn robot_label(robot: &v1::RobotStatus) -> String {
    let role = robot.role().as_str_name().trim_start_matches("ROLE_").to_lowercase().replace('_', " ");
    let charge = (robot.state_of_charge_percent / CHARGE_STEP_PERCENT).ceil() * CHARGE_STEP_PERCENT;
    format!("{} {role} {charge} %", robot.serial_number)
}

fn station_entity(station: &v1::StationStatus) -> SceneEntity {
    let place = station.position.unwrap_or_default();
    let plate = cube(place.x_m, place.y_m, 0.3, 0.02, palette::STATION);
    let mut text = station.station_id.clone();
    if station.out_of_order {
        text += " out of order";
    }
    if !station.queue.is_empty() {
        text = format!("{text}, waiting: {}", station.queue.join(" "));
    }
    let sign = TextPrimitive { pose: Some(at(place.x_m, place.y_m, 0.5)), ..label(text, 0.5) };
    SceneEntity {
        cubes: vec![plate],
        texts: vec![sign],
        ..entity(format!("station/{}", station.station_id), MAP_FRAME)
    }
}

fn zone_entity(zone: &v1::Zone, cell_m: f64) -> SceneEntity {
    let rgba = match zone.zone_type() {
        v1::ZoneType::ZoneQuarantine => palette::LOST,
        _ => palette::UNREACHABLE,
    };
    let cubes =
        zone.cells.iter().map(|cell| cube(cell.x_m, cell.y_m, cell_m, ZONE_HEIGHT_M, palette::pale(rgba)));
    SceneEntity { cubes: cubes.collect(), ..entity(format!("zone/{}", zone.zone_id), MAP_FRAME) }
}

fn entity(id: String, frame: &str) -> SceneEntity {
    SceneEntity { id, frame_id: frame.to_owned(), frame_locked: true, ..SceneEntity::default() }
}

fn cube(x_m: f64, y_m: f64, side_m: f64, height_m: f64, rgba: Rgba) -> CubePrimitive {
    CubePrimitive {
        pose: Some(at(x_m, y_m, height_m / 2.0)),
        size: Some(Vector3 { x: side_m, y: side_m, z: height_m }),
        color: Some(palette::color(rgba)),
    }
}

fn label(text: String, z_m: f64) -> TextPrimitive {
    TextPrimitive {
        pose: Some(at(0.0, 0.0, z_m)),
        billboard: true,
        font_size: 14.0,
        scale_invariant: true,
        color: Some(palette::color(palette::WALL)),
        text,
    }
}

fn at(x_m: f64, y_m: f64, z_m: f64) -> Pose {
    let mut pose = pose_at(x_m, y_m, 0.0);
    pose.position = Some(Vector3 { x: x_m, y: y_m, z: z_m });
    pose
}
