//! What a viewer draws of one robot: its frame, its pose, the way ahead, and what its range finder sees.
//!
//! States come ten times a second for every robot, so the messages drawn from them are kept and overwritten.

use super::log_file::{LogFile, RecordError, TopicId};
use super::viewer::{MAP_FRAME, base_frame, heading, path, pose_at, pose_in_map, position, transform};
use foxglove::Encode;
use foxglove::messages::{FrameTransforms, LaserScan, PoseInFrame, PosesInFrame};
use protocol::{Timestamp, v1};
use std::io::Write;
use std::time::Duration;

/// A pose is drawn at most ten times a second, with some room for jitter.
const POSE_INTERVAL: Duration = Duration::from_millis(80);
/// A scan is drawn at most five times a second.
const SCAN_INTERVAL: Duration = Duration::from_millis(190);

/// The drawn side of one robot.
pub(super) struct RobotView {
    pose_topic: TopicId,
    path_topic: TopicId,
    scan_topic: TopicId,
    transforms: FrameTransforms,
    pose: PoseInFrame,
    scan: LaserScan,
    pose_due: Timestamp,
    scan_due: Timestamp,
}

impl RobotView {
    pub(super) fn new<W: Write>(file: &mut LogFile<W>, robot: &str) -> Result<Self, RecordError> {
        let (stamp, frame) = (file.stamp(), base_frame(robot));
        let here = v1::Pose::default();
        let topic = |noun: &str| format!("/robots/{robot}/{noun}");
        Ok(Self {
            pose_topic: file.add_drawn_topic::<PoseInFrame>(&topic("pose"))?,
            path_topic: file.add_drawn_topic::<PosesInFrame>(&topic("path"))?,
            scan_topic: file.add_drawn_topic::<LaserScan>(&topic("scan"))?,
            transforms: FrameTransforms { transforms: vec![transform(stamp, MAP_FRAME, &frame, &here)] },
            pose: pose_in_map(stamp, &here),
            scan: LaserScan { frame_id: frame, pose: Some(pose_at(0.0, 0.0, 0.0)), ..LaserScan::default() },
            pose_due: Timestamp::ZERO,
            scan_due: Timestamp::ZERO,
        })
    }

    /// Draws a robot where it says it is.
    pub(super) fn draw_state<W: Write>(
        &mut self,
        file: &mut LogFile<W>,
        tf: TopicId,
        state: &v1::State,
    ) -> Result<(), RecordError> {
        let now = file.now();
        if let Some(pose) = state.pose.as_ref().filter(|_| now >= self.pose_due) {
            self.pose_due = now + POSE_INTERVAL;
            self.draw_pose(file, tf, pose)?;
        }
        if let Some(scan) = state.scan.as_ref().filter(|_| now >= self.scan_due) {
            self.scan_due = now + SCAN_INTERVAL;
            self.draw_scan(file, scan)?;
        }
        Ok(())
    }

    fn draw_pose<W: Write>(
        &mut self,
        file: &mut LogFile<W>,
        tf: TopicId,
        pose: &v1::Pose,
    ) -> Result<(), RecordError> {
        let frame = &mut self.transforms.transforms[0];
        frame.timestamp = Some(file.stamp());
        frame.translation = Some(position(pose.x_m, pose.y_m));
        frame.rotation = Some(heading(pose.theta_rad));
        file.write(tf, &self.transforms)?;
        self.pose.timestamp = Some(file.stamp());
        self.pose.pose = Some(pose_at(pose.x_m, pose.y_m, pose.theta_rad));
        file.write(self.pose_topic, &self.pose)
    }

    fn draw_scan<W: Write>(
        &mut self,
        file: &mut LogFile<W>,
        scan: &v1::RangeScan,
    ) -> Result<(), RecordError> {
        let beams = scan.ranges_m.len().saturating_sub(1) as f64;
        self.scan.timestamp = Some(file.stamp());
        self.scan.start_angle = scan.angle_min_rad;
        self.scan.end_angle = scan.angle_min_rad + beams * scan.angle_increment_rad;
        self.scan.ranges.clear();
        self.scan.ranges.extend(scan.ranges_m.iter().map(|&range| f64::from(range)));
        file.write(self.scan_topic, &self.scan)
    }

    /// Draws the way ahead.
    pub(super) fn draw_order<W: Write>(
        &self,
        file: &mut LogFile<W>,
        order: &v1::Order,
    ) -> Result<(), RecordError> {
        file.write(self.path_topic, &path(file.stamp(), order))
    }
}

impl<W: Write> LogFile<W> {
    /// Adds a topic of a message that viewers know.
    pub(super) fn add_drawn_topic<M: Encode>(&mut self, topic: &str) -> Result<TopicId, RecordError> {
        self.add_topic(topic, &M::get_schema().expect("Foxglove's messages have schemas"))
    }
}
