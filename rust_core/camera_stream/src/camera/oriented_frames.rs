//! The frames of turned images, on `/tf_static`: consumers of their CameraInfo look them up.

use std::collections::BTreeMap;

use rcs_messages::geometry_msgs::TransformStamped;
use rcs_messages::tf2_msgs::TFMessage;
use rcs_render::Orientation;
use rcs_ros::{Publisher, RosNode};

use crate::camera::oriented_info::turned_frame;

/// Publishes the frames; the topic is advertised with the first one.
#[derive(Default)]
pub(crate) struct OrientedFrames {
    /// By their names.
    known: BTreeMap<String, TransformStamped>,
    publisher: Option<Publisher<TFMessage>>,
}

impl OrientedFrames {
    /// Publishes the frame of images with this orientation, if it has one that is new.
    pub(crate) fn add(&mut self, ros: &RosNode, camera_frame: &str, orientation: Orientation) {
        let Some(mut placed) = turned_frame(camera_frame, orientation) else { return };
        if self.known.contains_key(&placed.child_frame_id) {
            return;
        }
        placed.header.stamp = ros.now();
        log::info!("static frame {} in {}", placed.child_frame_id, placed.header.frame_id);
        self.known.insert(placed.child_frame_id.clone(), placed);
        if self.publisher.is_none() {
            self.publisher = ros.latched_publisher("/tf_static", 1).map_err(|error| log::error!("{error}")).ok();
        }
        // A latched topic has one message: all of the frames.
        let transforms = self.known.values().cloned().collect();
        let sent = self.publisher.as_ref().map(|publisher| publisher.send(TFMessage { transforms }));
        if let Some(Err(error)) = sent {
            log::error!("/tf_static: {error}");
        }
    }
}
