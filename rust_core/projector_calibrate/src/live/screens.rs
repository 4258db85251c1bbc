//! The projector as a screen: a full-screen window on its monitor, or a topic that another program shows on it.

use std::sync::Arc;

use anyhow::Context;
use rcs_messages::std_msgs::Header;
use rcs_messages::Image as ImageMessage;
use rcs_ros::{NodeError, Publisher, RosNode};
use rcs_scan::ProjectorScreen;
use rcs_scene::{Encoding, Image};
use rcs_window::{ImageSink, ScreenImage};

/// A window that covers the projector's monitor pixel for pixel.
pub(super) struct WindowScreen {
    pub(super) sink: ImageSink,
    pub(super) monitor: String,
    /// Width and height of the monitor and of all images, pixels.
    pub(super) size_px: [u32; 2],
}

impl ProjectorScreen for WindowScreen {
    fn name(&self) -> String {
        format!("monitor {}", self.monitor)
    }

    fn show(&mut self, image: Vec<u8>) -> anyhow::Result<()> {
        self.sink.show(ScreenImage::from_image(&grey(self.size_px, image))?);
        Ok(())
    }
}

/// A topic of images. It is latched, so that a subscriber may come later.
pub(crate) struct ImageTopic {
    publisher: Publisher<ImageMessage>,
    frame_id: String,
    next_seq: u32,
}

impl ImageTopic {
    /// Publishes the topic.
    ///
    /// # Errors
    /// [`NodeError`] for an invalid name.
    pub(crate) fn new(node: &RosNode, topic: &str, frame_id: String) -> Result<Self, NodeError> {
        Ok(Self { publisher: node.latched_publisher(topic, 1)?, frame_id, next_seq: 0 })
    }

    /// Publishes an image.
    ///
    /// # Errors
    /// An image that is too large.
    pub(super) fn send(&mut self, image: Image) -> anyhow::Result<()> {
        let stamp = rcs_ros::node_time().map(|time| time.stamp).unwrap_or_default();
        let header = Header { seq: self.next_seq, stamp, frame_id: self.frame_id.clone() };
        self.next_seq = self.next_seq.wrapping_add(1);
        let (size_px, step) = ([image.width_px, image.height_px], image.step() as u32);
        let image = ImageMessage::new(header, size_px, image.encoding.name(), step, Arc::new(image.data));
        self.publisher.send(image).with_context(|| format!("cannot publish {}", self.publisher.topic()))
    }
}

/// The topic as the projector's screen.
pub(crate) struct TopicScreen {
    pub(crate) topic: ImageTopic,
    /// Width and height of all images, pixels.
    pub(crate) size_px: [u32; 2],
}

impl ProjectorScreen for TopicScreen {
    fn name(&self) -> String {
        format!("topic {}", self.topic.publisher.topic())
    }

    fn show(&mut self, image: Vec<u8>) -> anyhow::Result<()> {
        self.topic.send(grey(self.size_px, image))
    }
}

fn grey([width_px, height_px]: [u32; 2], data: Vec<u8>) -> Image {
    Image { width_px, height_px, encoding: Encoding::Mono8, data }
}
