//! The projector as a screen: a full-screen window on its monitor, or a topic that another program shows on it.

use std::sync::Arc;

use anyhow::Context;
use rcs_messages::std_msgs::Header;
use rcs_messages::Image;
use rcs_ros::{NodeError, Publisher, RosNode};
use rcs_scan::Screen;
use rcs_window::{PictureSink, ReceivedPicture, ScreenPicture};

/// A window that covers the projector's monitor pixel for pixel.
pub(super) struct WindowScreen {
    pub(super) sink: PictureSink,
    pub(super) monitor: String,
    /// The monitor's width and height, pixels, and so those of all pictures.
    pub(super) size_px: [u32; 2],
}

impl Screen for WindowScreen {
    fn name(&self) -> String {
        format!("monitor {}", self.monitor)
    }

    fn show(&mut self, picture: Vec<u8>) -> anyhow::Result<()> {
        let [width_px, height_px] = self.size_px;
        let picture = ScreenPicture::from_received(&ReceivedPicture {
            width_px,
            height_px,
            step_bytes: width_px,
            encoding: "mono8",
            is_bigendian: false,
            data: &picture,
        })?;
        self.sink.show(picture);
        Ok(())
    }
}

/// A topic of pictures. It is latched, so that a subscriber may come later.
pub(super) struct TopicScreen {
    publisher: Publisher<Image>,
    size_px: [u32; 2],
    frames: u32,
}

impl TopicScreen {
    /// Publishes the topic.
    ///
    /// # Errors
    /// [`NodeError`] if the name is none.
    pub(super) fn new(node: &RosNode, topic: &str, size_px: [u32; 2]) -> Result<Self, NodeError> {
        Ok(Self { publisher: node.latched_publisher(topic, 1)?, size_px, frames: 0 })
    }
}

impl Screen for TopicScreen {
    fn name(&self) -> String {
        format!("topic {}", self.publisher.topic())
    }

    fn show(&mut self, picture: Vec<u8>) -> anyhow::Result<()> {
        let stamp = rcs_ros::node_time().map(|time| time.stamp).unwrap_or_default();
        let header = Header { seq: self.frames, stamp, ..Header::default() };
        self.frames = self.frames.wrapping_add(1);
        let image = Image::new(header, self.size_px, "mono8", self.size_px[0], Arc::new(picture));
        self.publisher.send(image).context("the picture is too large")
    }
}
