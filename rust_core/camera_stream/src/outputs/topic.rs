//! A camera's pictures on an image topic, with the CameraInfo beside it and compressed pictures below it, and the
//! depths on the topic `depth` beside both.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;

use rcs_messages::dynamic_reconfigure::Config as Values;
use rcs_messages::std_msgs::Header;
use rcs_messages::Image;
use rcs_ros::image_topic::{sibling_topic, ImagePublisher};
use rcs_ros::{Change, NodeError, Publisher, RosNode};

use super::compressed::CompressedOutput;
use super::{Frame, Output, OutputError};

/// The whole names of the image's and the CameraInfo's topic.
pub type TopicNames = [String; 2];

/// Publishes a camera's pictures.
pub struct TopicOutput {
    publisher: ImagePublisher,
    compressed: CompressedOutput,
    /// None where the pictures' own topic has that name.
    depth: Option<Publisher<Image>>,
    /// Somebody subscribed and has not received a picture yet.
    new_subscriber: Arc<AtomicBool>,
}

impl TopicOutput {
    /// Advertises an image topic and its CameraInfo. A new subscriber wakes the node's thread.
    ///
    /// # Errors
    /// [`NodeError::Name`].
    pub fn advertise(ros: &RosNode, topic: &str) -> Result<Self, NodeError> {
        let new_subscriber = Arc::new(AtomicBool::new(false));
        let on_change = || {
            let (flag, events) = (Arc::clone(&new_subscriber), Arc::clone(ros.events()));
            move |change: Change, _: &str| {
                if change == Change::Joined {
                    flag.store(true, Ordering::Release);
                    events.wake();
                }
            }
        };
        let publisher = ros.image_publisher(topic, on_change())?;
        let compressed = CompressedOutput::start(ros, publisher.compressed());
        let depth: Publisher<Image> = ros.observed_publisher(&sibling_topic(topic, "depth"), 1, on_change())?;
        let is_free = depth.topic() != publisher.topic();
        if !is_free {
            log::warn!("depths are not published: the pictures themselves are on {}", publisher.topic());
        }
        Ok(Self { publisher, compressed, depth: is_free.then_some(depth), new_subscriber })
    }

    /// The image topic's whole name.
    pub fn topic(&self) -> &str {
        self.publisher.topic()
    }

    /// The whole names of both topics.
    pub fn names(&self) -> TopicNames {
        [self.publisher.topic(), self.publisher.info_topic()].map(str::to_owned)
    }

    /// Takes over what has come from the parameter server.
    pub fn poll_settings(&mut self, ros: &RosNode) {
        self.compressed.poll_settings(ros);
    }

    /// Whether dynamic_reconfigure's server of this name has its settings.
    pub fn has_parameters(&self, server: &str) -> bool {
        self.compressed.serves(server)
    }

    /// Takes a user's settings of the compressed pictures. Returns those that apply from now on.
    pub fn reconfigure(&mut self, ros: &RosNode, request: &Values) -> Values {
        self.compressed.reconfigure(ros, request)
    }

    /// Whether another node subscribes to the depths.
    pub fn wants_depth(&self) -> bool {
        self.depth.as_ref().is_some_and(Publisher::is_watched)
    }

    /// How many other nodes subscribe to the pictures, compressed ones included, or the CameraInfo.
    pub fn subscriber_count(&self) -> usize {
        self.publisher.subscriber_count()
    }
}

impl Output for TopicOutput {
    fn send(&mut self, frame: &Frame) -> Result<(), OutputError> {
        let header = self.publisher.publish(&frame.picture, &frame.info, frame.stamp)?;
        self.compressed.offer(&frame.picture, header);
        let publisher = self.depth.as_ref().filter(|publisher| publisher.is_watched());
        if let (Some(depth), Some(publisher)) = (&frame.depth, publisher) {
            let header = Header { seq: 0, stamp: frame.stamp, frame_id: frame.info.header.frame_id.clone() };
            publisher.send_image(&depth.message(header))?;
        }
        Ok(())
    }

    fn is_watched(&self) -> bool {
        self.subscriber_count() > 0 || self.wants_depth()
    }

    fn take_new_watcher(&mut self) -> bool {
        self.new_subscriber.swap(false, Ordering::AcqRel)
    }
}

/// Keeps one output for each of the `wanted` names and closes all others.
pub fn retain(outputs: &mut Vec<TopicOutput>, mut wanted: Vec<&TopicNames>) {
    outputs.retain(|output| {
        let found = wanted.iter().position(|names| **names == output.names());
        found.map(|index| wanted.swap_remove(index)).is_some()
    });
}
