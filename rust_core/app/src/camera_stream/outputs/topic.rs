//! A camera's pictures on an image topic, with the CameraInfo beside it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;

use rcs_ros::image_topic::{ImagePublisher, PublishError};
use rcs_ros::RosNode;

use super::{Frame, Output, OutputError};

/// The whole names of the image's and the CameraInfo's topic.
pub type TopicNames = [String; 2];

/// Publishes a camera's pictures.
pub struct TopicOutput {
    publisher: ImagePublisher,
    /// Somebody subscribed and has not received a picture yet.
    new_subscriber: Arc<AtomicBool>,
}

impl TopicOutput {
    /// Advertises an image topic and its CameraInfo. A new subscriber wakes the node's thread.
    ///
    /// # Errors
    /// When rosrust cannot advertise one of the two.
    pub fn advertise(ros: &RosNode, topic: &str) -> Result<Self, PublishError> {
        let new_subscriber = Arc::new(AtomicBool::new(false));
        let (flag, events) = (Arc::clone(&new_subscriber), Arc::clone(ros.events()));
        let on_subscriber = move |_: &str| {
            flag.store(true, Ordering::Release);
            events.wake();
        };
        Ok(Self { publisher: ImagePublisher::new(topic, on_subscriber)?, new_subscriber })
    }

    /// The image topic's whole name.
    pub fn topic(&self) -> &str {
        self.publisher.topic()
    }

    /// The whole names of both topics.
    pub fn names(&self) -> TopicNames {
        [self.publisher.topic(), self.publisher.info_topic()].map(str::to_owned)
    }

    /// How many other nodes subscribe to either topic.
    pub fn subscriber_count(&self) -> usize {
        self.publisher.subscriber_count()
    }

    fn shares_topic(&self, other: &Self) -> bool {
        let others = other.names();
        self.names().iter().any(|topic| others.contains(topic))
    }
}

impl Output for TopicOutput {
    fn send(&mut self, frame: &Frame) -> Result<(), OutputError> {
        Ok(self.publisher.publish(&frame.picture, &frame.info, frame.stamp)?)
    }

    fn is_watched(&self) -> bool {
        self.subscriber_count() > 0
    }

    fn take_new_watcher(&mut self) -> bool {
        self.new_subscriber.swap(false, Ordering::AcqRel)
    }
}

/// Keeps one output for each of the `wanted` names and closes all others. One that shares a topic with a closed one is
/// closed, too, to be advertised again: rosrust ends a topic with the first of its publishers.
pub fn retain(outputs: &mut Vec<TopicOutput>, mut wanted: Vec<&TopicNames>) {
    let mut is_wanted = |output: &TopicOutput| {
        let found = wanted.iter().position(|names| **names == output.names());
        found.map(|index| wanted.swap_remove(index)).is_some()
    };
    let (mut kept, mut closed): (Vec<_>, Vec<_>) = outputs.drain(..).partition(|output| is_wanted(output));
    while let Some(index) = kept.iter().position(|output| closed.iter().any(|other| output.shares_topic(other))) {
        closed.push(kept.remove(index));
    }
    *outputs = kept;
}
