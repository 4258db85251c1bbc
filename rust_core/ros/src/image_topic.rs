//! A camera's picture on an image topic, with its CameraInfo beside it, as image_transport's camera publishers send
//! them.
//!
//! The CameraInfo goes out on the sibling topic `camera_info`: the image topic's name with another last part. Both have
//! the same stamp, sequence number and frame.
//!
//! Sending never blocks: rosrust queues one frame for its writing thread and drops the older one. That thread writes to
//! the subscribers one after the other, so a stopped one would block all others; [`crate::listeners`] sets a time
//! limit.

use crate::listeners::tune_listeners;
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::std_msgs::Header;
use rcs_messages::{Image, Serialized, SharedBytes, Time};
use rcs_scene::Picture;
use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;
use std::time::Duration;

/// How often new subscribers are polled for. Each poll wakes a core, also when nothing else happens.
const POLL_PERIOD: Duration = Duration::from_millis(50);
/// A frame that is still queued for the writing thread is dropped for the next.
const QUEUE_SIZE: usize = 1;

/// Why something cannot be published.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PublishError {
    /// The topic cannot be published.
    #[error("cannot publish {topic}: {reason}")]
    Advertise {
        /// The topic.
        topic: String,
        /// rosrust's reason.
        reason: String,
    },
    /// A message could not be sent.
    #[error("cannot send on {topic}: {reason}")]
    Send {
        /// The topic.
        topic: String,
        /// rosrust's reason.
        reason: String,
    },
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
}

/// Publishes a camera's pictures until it is dropped, which unregisters both topics.
pub struct ImagePublisher {
    image: rosrust::Publisher<Image>,
    info: rosrust::Publisher<Serialized<CameraInfo>>,
    topic: String,
    info_topic: String,
    next_seq: u32,
    ended: Arc<AtomicBool>,
}

/// The topic of the CameraInfo that belongs to an image topic.
pub fn camera_info_topic(image_topic: &str) -> String {
    match image_topic.trim_end_matches('/').rsplit_once('/') {
        Some((parent, _)) => format!("{parent}/camera_info"),
        None => "camera_info".to_owned(),
    }
}

impl ImagePublisher {
    /// Publishes on `topic` and its sibling, on the running rosrust node.
    ///
    /// `on_subscriber` is called with the name of every node that newly subscribes to either, on a separate thread,
    /// within some fifty milliseconds.
    ///
    /// # Errors
    /// [`PublishError::Advertise`].
    pub fn new(topic: &str, on_subscriber: impl Fn(&str) + Send + 'static) -> Result<Self, PublishError> {
        let image = advertise::<Image>(topic, QUEUE_SIZE)?;
        // image_transport takes the sibling of the name as it was given, and remaps the two separately.
        let info_topic = camera_info_topic(topic);
        let info = advertise::<Serialized<CameraInfo>>(&info_topic, QUEUE_SIZE)?;
        tune_listeners();
        let publisher = Self {
            topic: resolved(topic),
            info_topic: resolved(&info_topic),
            image,
            info,
            next_seq: 0,
            ended: Arc::default(),
        };
        publisher.watch_subscribers(on_subscriber);
        Ok(publisher)
    }

    /// The image topic's whole name, after remapping.
    pub fn topic(&self) -> &str {
        &self.topic
    }

    /// The CameraInfo topic's whole name, after remapping.
    pub fn info_topic(&self) -> &str {
        &self.info_topic
    }

    /// How many nodes subscribe to the image or to the CameraInfo, this node itself not counted: its own config may
    /// well subscribe to the topic that the CameraInfo is published on.
    pub fn subscriber_count(&self) -> usize {
        let mut names: BTreeSet<String> = self.image.subscriber_names().into_iter().collect();
        names.extend(self.info.subscriber_names());
        names.remove(&rosrust::name());
        names.len()
    }

    /// Sends a picture and the CameraInfo it was drawn with, both with `stamp` and the CameraInfo's frame. Never waits;
    /// the pixels are copied once, into the message.
    ///
    /// # Errors
    /// [`PublishError::Size`] or [`PublishError::Send`].
    pub fn publish(&mut self, picture: &Arc<Picture>, info: &CameraInfo, stamp: Time) -> Result<(), PublishError> {
        let (step, height_px) = (picture.step(), picture.height_px);
        let step_bytes = u32::try_from(step).ok().filter(|_| picture.data.len() == step * height_px as usize);
        let Some(step_bytes) = step_bytes else {
            return Err(PublishError::Size {
                topic: self.topic.clone(),
                len: picture.data.len(),
                height_px,
                step_bytes: step,
            });
        };
        let header = Header { seq: self.next_seq, stamp, frame_id: info.header.frame_id.clone() };
        self.next_seq = self.next_seq.wrapping_add(1);
        let (size_px, encoding) = ([picture.width_px, height_px], picture.encoding.name());
        let pixels: SharedBytes = Arc::<Picture>::clone(picture);
        let image = Image::sharing(header.clone(), size_px, encoding, step_bytes, pixels);
        let info = CameraInfo { header, ..info.clone() };
        // As it is: rosrust would put its own sequence number into a message that it knows.
        let info = Serialized::new(rcs_messages::encode(&info));
        self.image.send(image).map_err(|error| send_error(&self.topic, &error))?;
        self.info.send(info).map_err(|error| send_error(&self.info_topic, &error))
    }

    fn watch_subscribers(&self, on_subscriber: impl Fn(&str) + Send + 'static) {
        let (image, info, ended) = (self.image.clone(), self.info.clone(), Arc::downgrade(&self.ended));
        let watching = move || {
            let own_name = rosrust::name();
            let mut known = BTreeSet::new();
            while ended.upgrade().is_some_and(|ended| !ended.load(Ordering::Acquire)) {
                let names = image.subscriber_names().into_iter().map(|name| (name, true));
                let names = names.chain(info.subscriber_names().into_iter().map(|name| (name, false)));
                let now: BTreeSet<(String, bool)> = names.filter(|(name, _)| *name != own_name).collect();
                for (name, _) in now.difference(&known) {
                    on_subscriber(name);
                }
                known = now;
                std::thread::sleep(POLL_PERIOD);
            }
        };
        let spawned = std::thread::Builder::new().name("image-subscribers".to_owned()).spawn(watching);
        if let Err(error) = spawned {
            log::warn!("{}: new subscribers are not noticed at once: {error}", self.topic);
        }
    }
}

impl Drop for ImagePublisher {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Release);
    }
}

pub(crate) fn advertise<T: rosrust::Message>(
    topic: &str,
    queue_size: usize,
) -> Result<rosrust::Publisher<T>, PublishError> {
    rosrust::publish(topic, queue_size)
        .map_err(|error| PublishError::Advertise { topic: topic.to_owned(), reason: reasons(&error) })
}

pub(crate) fn send_error(topic: &str, error: &rosrust::api::error::Error) -> PublishError {
    PublishError::Send { topic: topic.to_owned(), reason: reasons(error) }
}

fn reasons(error: &rosrust::api::error::Error) -> String {
    error.iter().map(ToString::to_string).collect::<Vec<_>>().join(": ")
}

/// The whole name of a topic, as rosrust makes it.
fn resolved(topic: &str) -> String {
    rosrust::param(topic).map_or_else(|| topic.to_owned(), |param| param.name().to_owned())
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
