//! Our values as the Foxglove messages that viewers draw.

use foxglove::messages::{FrameTransform, Pose, PoseInFrame, PosesInFrame, Quaternion, Timestamp, Vector3};
use protocol::v1;

/// The one fixed frame.
pub(super) const MAP_FRAME: &str = "map";

/// Frame that moves with a robot.
pub(super) fn base_frame(robot: &str) -> String {
    format!("{robot}/base_link")
}

pub(super) fn position(x_m: f64, y_m: f64) -> Vector3 {
    Vector3 { x: x_m, y: y_m, z: 0.0 }
}

pub(super) fn heading(theta_rad: f64) -> Quaternion {
    Quaternion { x: 0.0, y: 0.0, z: (theta_rad / 2.0).sin(), w: (theta_rad / 2.0).cos() }
}

pub(super) fn pose_at(x_m: f64, y_m: f64, theta_rad: f64) -> Pose {
    Pose { position: Some(position(x_m, y_m)), orientation: Some(heading(theta_rad)) }
}

pub(super) fn transform(stamp: Timestamp, parent: &str, child: &str, pose: &v1::Pose) -> FrameTransform {
    FrameTransform {
        timestamp: Some(stamp),
        parent_frame_id: parent.to_owned(),
        child_frame_id: child.to_owned(),
        translation: Some(position(pose.x_m, pose.y_m)),
        rotation: Some(heading(pose.theta_rad)),
    }
}

pub(super) fn pose_in_map(stamp: Timestamp, pose: &v1::Pose) -> PoseInFrame {
    PoseInFrame {
        timestamp: Some(stamp),
        frame_id: MAP_FRAME.to_owned(),
        pose: Some(pose_at(pose.x_m, pose.y_m, pose.theta_rad)),
    }
}

/// The way of an order: its corners, each with the heading in which it is left.
pub(super) fn path(stamp: Timestamp, order: &v1::Order) -> PosesInFrame {
    let nodes = &order.nodes;
    let heading_of = |from: &v1::Node, to: &v1::Node| (to.y_m - from.y_m).atan2(to.x_m - from.x_m);
    let mut poses = Vec::new();
    let mut heading_before = f64::NAN;
    for (at, node) in nodes.iter().enumerate() {
        let heading = nodes.get(at + 1).map_or(heading_before, |next| heading_of(node, next));
        let is_corner = at == 0 || at + 1 == nodes.len() || (heading - heading_before).abs() > 1e-6;
        if is_corner {
            poses.push(pose_at(node.x_m, node.y_m, if heading.is_nan() { 0.0 } else { heading }));
        }
        heading_before = heading;
    }
    PosesInFrame { timestamp: Some(stamp), frame_id: MAP_FRAME.to_owned(), poses }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_drawn_by_its_corners() {
        let at = |x_m, y_m| v1::Node { x_m, y_m, ..Default::default() };
        let nodes = vec![at(0.0, 0.0), at(1.0, 0.0), at(2.0, 0.0), at(2.0, 1.0), at(2.0, 2.0)];
        let path = path(Timestamp::new(0, 0), &v1::Order { nodes, ..Default::default() });
        let corners: Vec<_> =
            path.poses.iter().filter_map(|pose| pose.position).map(|corner| (corner.x, corner.y)).collect();
        assert_eq!(corners, [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0)]);
    }
}
