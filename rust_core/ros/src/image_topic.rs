//! A camera's picture on an image topic, with its CameraInfo beside it, as image_transport's camera publishers send
//! them.
//!
//! The CameraInfo goes out on the sibling topic `camera_info`: the image topic's name with another last part. Both have
//! the same stamp, sequence number and frame. A picture's pixels are shared by all subscribers and never copied.
//!
//! Below the image topic is `compressed`, for whoever has encoded pictures ([`CompressedPublisher`]).

use crate::publisher::Publisher;
use crate::tcpros::{Change, Observer};
use crate::{NodeError, RosNode};
use rcs_messages::sensor_msgs::{CameraInfo, CompressedImage};
use rcs_messages::std_msgs::Header;
use rcs_messages::{Image, SharedBytes, Time};
use rcs_scene::Picture;
use std::collections::BTreeSet;
use std::sync::Arc;

/// A frame that is still queued for a subscriber is dropped for the next.
const QUEUE_SIZE: usize = 1;

/// Why a picture cannot be sent.
#[derive(Debug, thiserror::Error)]
pub enum SendError {
    /// The picture's bytes are not as many as its rows need.
    #[error("{topic}: {len} bytes of pixels for {height_px} rows of {step_bytes} bytes")]
    Size {
        /// The topic.
        topic: String,
        /// Bytes of the buffer.
        len: usize,
        /// Rows.
        height_px: u32,
        /// Bytes of a row.
        step_bytes: usize,
    },
    /// It has more bytes than a message can have.
    #[error("cannot send on {topic}: {error}")]
    TooLong {
        /// The topic.
        topic: String,
        /// What is too long.
        error: std::io::Error,
    },
}

/// Publishes a camera's pictures until it is dropped, which unregisters both topics.
pub struct ImagePublisher {
    image: Publisher<Image>,
    info: Publisher<CameraInfo>,
    compressed: Arc<CompressedPublisher>,
    next_seq: u32,
}

/// Publishes a camera's encoded pictures, on any thread.
pub struct CompressedPublisher(Publisher<CompressedImage>);

impl CompressedPublisher {
    /// The topic's whole name.
    pub fn topic(&self) -> &str {
        self.0.topic()
    }

    /// Whether another node subscribes.
    pub fn is_watched(&self) -> bool {
        !self.0.subscriber_names().is_empty()
    }

    /// Sends an encoded picture. Never waits, and copies no data.
    ///
    /// # Errors
    /// [`SendError`].
    pub fn publish(&self, header: Header, format: &str, data: Vec<u8>) -> Result<(), SendError> {
        let too_long = |error| SendError::TooLong { topic: self.topic().to_owned(), error };
        let len = u32::try_from(data.len()).map_err(|_| too_long(std::io::ErrorKind::InvalidInput.into()))?;
        let empty = CompressedImage { header, format: format.to_owned(), data: Vec::new() };
        let mut beginning = rcs_messages::encode(&empty);
        // The last field is the length of the data.
        beginning.truncate(beginning.len() - 4);
        beginning.extend_from_slice(&len.to_le_bytes());
        self.0.send_parts(&beginning, Arc::new(data)).map_err(too_long)
    }
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
    /// Publishes pictures on `topic` and their CameraInfo on its sibling.
    ///
    /// `on_change` is called with the name of every node that subscribes to one of its topics or leaves, on the thread
    /// of its connection.
    ///
    /// # Errors
    /// [`NodeError::Name`].
    pub fn image_publisher(
        &self,
        topic: &str,
        on_change: impl Fn(Change, &str) + Send + Sync + 'static,
    ) -> Result<ImagePublisher, NodeError> {
        let own_name = self.name().to_owned();
        let observer: Observer = Arc::new(move |change, name| {
            // Its own config may well subscribe to the topic that the CameraInfo is published on.
            if name != own_name {
                on_change(change, name);
            }
        });
        // image_transport takes the sibling of the name as it was given, and remaps the two separately.
        let (topic, info_topic) = (self.resolve(topic)?, self.resolve(&camera_info_topic(topic))?);
        let image = Publisher::new(self.network(), &topic, QUEUE_SIZE, false, &observer);
        let info = Publisher::new(self.network(), &info_topic, QUEUE_SIZE, false, &observer);
        // Below the name after remapping, as image_transport has it.
        let compressed_topic = self.resolve(&format!("{topic}/compressed"))?;
        let compressed = Publisher::new(self.network(), &compressed_topic, QUEUE_SIZE, false, &observer);
        Ok(ImagePublisher { image, info, compressed: Arc::new(CompressedPublisher(compressed)), next_seq: 0 })
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

    /// The topic of encoded pictures.
    pub fn compressed(&self) -> &Arc<CompressedPublisher> {
        &self.compressed
    }

    /// How many nodes subscribe to the image, to encoded ones or to the CameraInfo, this node itself not counted.
    pub fn subscriber_count(&self) -> usize {
        let mut names: BTreeSet<String> = self.image.subscriber_names();
        names.extend(self.info.subscriber_names());
        names.extend(self.compressed.0.subscriber_names());
        names.len()
    }

    /// Sends a picture and the CameraInfo it was drawn with, both with `stamp` and the CameraInfo's frame. Never waits
    /// and copies no pixels. Returns the picture's header.
    ///
    /// # Errors
    /// [`SendError`].
    pub fn publish(&mut self, picture: &Arc<Picture>, info: &CameraInfo, stamp: Time) -> Result<Header, SendError> {
        let header = Header { seq: self.next_seq, stamp, frame_id: info.header.frame_id.clone() };
        self.next_seq = self.next_seq.wrapping_add(1);
        let too_long = |topic: &str, error| SendError::TooLong { topic: topic.to_owned(), error };
        let (beginning, pixels) = self.image(picture, header.clone())?.parts();
        self.image.send_parts(&beginning, pixels).map_err(|error| too_long(self.topic(), error))?;
        let info = CameraInfo { header: header.clone(), ..info.clone() };
        self.info.send(&info).map_err(|error| too_long(self.info_topic(), error))?;
        Ok(header)
    }

    /// A picture's message, which shares its pixels.
    fn image(&self, picture: &Arc<Picture>, header: Header) -> Result<Image, SendError> {
        let (step_bytes, len, height_px) = (picture.step(), picture.data.len(), picture.height_px);
        match u32::try_from(step_bytes) {
            Ok(step) if len == step_bytes * height_px as usize && u32::try_from(len).is_ok() => {
                let pixels: SharedBytes = Arc::<Picture>::clone(picture);
                let size_px = [picture.width_px, height_px];
                Ok(Image::sharing(header, size_px, picture.encoding.name(), step, pixels))
            }
            _ => Err(SendError::Size { topic: self.topic().to_owned(), len, height_px, step_bytes }),
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
