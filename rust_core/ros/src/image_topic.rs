//! A camera's image topic with its CameraInfo, as image_transport's camera publishers send them.
//!
//! The CameraInfo goes out on the sibling topic `camera_info`: the image topic's name with another last part. Both have
//! the same stamp, sequence number and frame. The topic `compressed` below the image topic is for encoded images.

use std::collections::BTreeSet;
use std::io;
use std::sync::Arc;

use rcs_messages::sensor_msgs::{CameraInfo, CompressedImage};
use rcs_messages::std_msgs::Header;
use rcs_messages::{Image as ImageMessage, SharedBytes, Time};
use rcs_scene::Image;

use crate::error::NodeError;
use crate::node::RosNode;
use crate::publisher::Publisher;
use crate::tcpros::Change;

/// An image that is still queued for a subscriber is dropped for the next.
const QUEUE_SIZE: usize = 1;

/// Publishes a camera's images until it is dropped, which unregisters its topics.
pub struct ImagePublisher {
    image: Publisher<ImageMessage>,
    info: Publisher<CameraInfo>,
    compressed: Arc<Publisher<CompressedImage>>,
    next_seq: u32,
}

/// The topic of the CameraInfo that belongs to an image topic.
pub fn camera_info_topic(image_topic: &str) -> String {
    sibling_topic(image_topic, "camera_info")
}

/// The topic of this name beside an image topic.
pub fn sibling_topic(image_topic: &str, name: &str) -> String {
    match image_topic.trim_end_matches('/').rsplit_once('/') {
        Some((parent, _)) => format!("{parent}/{name}"),
        None => name.to_owned(),
    }
}

impl RosNode {
    /// Publishes images on `topic` and their CameraInfo on its sibling, and calls `on_change` with the name of every
    /// other node that subscribes to one of the topics or leaves, on the thread of its connection.
    ///
    /// # Errors
    /// [`NodeError::Name`].
    pub fn image_publisher(
        &self,
        topic: &str,
        on_change: impl Fn(Change, &str) + Send + Sync + 'static,
    ) -> Result<ImagePublisher, NodeError> {
        let observer = self.observer(on_change);
        // image_transport takes the sibling of the name as it was given, and remaps the two separately.
        let (topic, info_topic) = (self.resolve(topic)?, self.resolve(&camera_info_topic(topic))?);
        let image = self.open_publisher(&topic, QUEUE_SIZE, false, &observer);
        let info = self.open_publisher(&info_topic, QUEUE_SIZE, false, &observer);
        // Below the name after remapping, as image_transport has it.
        let compressed_topic = self.resolve(&format!("{topic}/compressed"))?;
        let compressed = Arc::new(self.open_publisher(&compressed_topic, QUEUE_SIZE, false, &observer));
        Ok(ImagePublisher { image, info, compressed, next_seq: 0 })
    }
}

impl ImagePublisher {
    /// The image topic's whole name, after remapping.
    pub fn topic(&self) -> &str {
        self.image.topic()
    }

    /// The CameraInfo topic's whole name, after remapping.
    pub fn info_topic(&self) -> &str {
        self.info.topic()
    }

    /// The topic of encoded images.
    pub fn compressed(&self) -> &Arc<Publisher<CompressedImage>> {
        &self.compressed
    }

    /// Number of other nodes that subscribe to any of the topics.
    pub fn subscriber_count(&self) -> usize {
        let mut names: BTreeSet<String> = self.image.subscriber_names();
        names.extend(self.info.subscriber_names());
        names.extend(self.compressed.subscriber_names());
        names.len()
    }

    /// Sends an image and the CameraInfo it was drawn with, both with `stamp` and the CameraInfo's frame. Never waits
    /// and copies no pixels. Returns the image's header.
    ///
    /// # Errors
    /// `InvalidInput` for more than 4 GB, or for a buffer of another size than its rows need. The topic is named.
    pub fn publish(&mut self, image: &Arc<Image>, info: &CameraInfo, stamp: Time) -> io::Result<Header> {
        let header = Header { seq: self.next_seq, stamp, frame_id: info.header.frame_id.clone() };
        self.next_seq = self.next_seq.wrapping_add(1);
        self.image.send_image(&self.message(image, header.clone())?)?;
        self.info.send_unchanged(&CameraInfo { header: header.clone(), ..info.clone() })?;
        Ok(header)
    }

    /// An image's message, which shares its pixels.
    fn message(&self, image: &Arc<Image>, header: Header) -> io::Result<ImageMessage> {
        let (step_bytes, len, height_px) = (image.step(), image.data.len(), image.height_px);
        match u32::try_from(step_bytes) {
            Ok(step) if len == step_bytes * height_px as usize && u32::try_from(len).is_ok() => {
                let pixels: SharedBytes = Arc::<Image>::clone(image);
                let size_px = [image.width_px, height_px];
                Ok(ImageMessage::sharing(header, size_px, image.encoding.name(), step, pixels))
            }
            _ => Err(io::Error::new(
                io::ErrorKind::InvalidInput,
                format!("{}: {len} bytes of pixels for {height_px} rows of {step_bytes} bytes", self.topic()),
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_camera_info_is_beside_the_image() {
        assert_eq!(camera_info_topic("/rviz1/camera1/image"), "/rviz1/camera1/camera_info");
        assert_eq!(camera_info_topic("/image"), "/camera_info");
        assert_eq!(camera_info_topic("camera/image"), "camera/camera_info");
        assert_eq!(camera_info_topic("image"), "camera_info");
    }
}
