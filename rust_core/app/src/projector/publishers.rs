//! The projector's latched topics.

use rcs_files::projector::{ProjectorFile, StaticFrame};
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::tf2_msgs::TFMessage;
use rcs_messages::Time;
use rcs_ros::{Publisher, RosNode};

use super::DEFAULT_TOPIC;

/// Publishers of both topics.
pub(super) struct Publishers {
    camera_info: Publisher<CameraInfo>,
    tf_static: Option<Publisher<TFMessage>>,
    /// Stamp of the last messages.
    stamp: Time,
}

impl Publishers {
    /// Opens `topic` or the file's, and `/tf_static` if the file has frames.
    pub(super) fn open(node: &RosNode, file: &ProjectorFile, topic: Option<&String>) -> anyhow::Result<Self> {
        let topic = topic.or(file.camera_info_topic.as_ref());
        let topic = topic.map_or(DEFAULT_TOPIC, String::as_str);
        let camera_info = node.latched_publisher(topic, 1)?;
        let (info, topic) = (&file.camera_info, camera_info.topic());
        log::info!("{}x{} pixels in frame {} on {topic}", info.width, info.height, info.header.frame_id);
        for frame in &file.frames {
            log::info!("static frame {} in {}", frame.child, frame.parent);
        }
        let tf_static = if file.frames.is_empty() { None } else { Some(node.latched_publisher("/tf_static", 1)?) };
        Ok(Self { camera_info, tf_static, stamp: Time::default() })
    }

    /// `true` if the last stamp was zero, because simulated time had not started, and now has.
    pub(super) fn has_zero_stamp(&self, node: &RosNode) -> bool {
        self.stamp == Time::default() && node.now() != self.stamp
    }

    /// Publishes both messages with the present time.
    pub(super) fn publish(&mut self, node: &RosNode, info: &CameraInfo, frames: &[StaticFrame]) -> anyhow::Result<()> {
        self.publish_frames(node, frames)?;
        let mut info = info.clone();
        info.header.stamp = self.stamp;
        self.camera_info.send(info)?;
        Ok(())
    }

    /// Publishes the frames with the present time.
    pub(super) fn publish_frames(&mut self, node: &RosNode, frames: &[StaticFrame]) -> anyhow::Result<()> {
        self.stamp = node.now();
        if let Some(tf_static) = &self.tf_static {
            let transforms = frames.iter().map(|frame| frame.to_message(self.stamp)).collect();
            tf_static.send(TFMessage { transforms })?;
        }
        Ok(())
    }
}
