//! A camera's image topic, with the CameraInfo beside it, compressed images below it, and beside it the topics `depth`,
//! `shown` and `confirmed`.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;
use std::time::Instant;

use anyhow::Result;
use rcs_messages::dynamic_reconfigure::Config as Values;
use rcs_messages::std_msgs::Header;
use rcs_messages::Image;
use rcs_ros::image_topic::{sibling_topic, ImagePublisher};
use rcs_ros::settings::NamedValues;
use rcs_ros::{Change, NodeError, Publisher, ReconfigureServer, RosNode};

use super::compressed::CompressedOutput;
use super::confirmed_image::confirmed_image;
use super::shown::{self, ShownPublisher};
use super::{Output, OutputFrame};

/// The whole names of the image's and the CameraInfo's topic.
pub(crate) type TopicNames = [String; 2];

/// Publishes a camera's images on topics.
pub(crate) struct TopicOutput {
    publisher: ImagePublisher,
    compressed: CompressedOutput,
    /// `None` where the image topic has that name.
    depth: Option<Publisher<Image>>,
    /// `None` where the image topic has that name.
    shown: Option<ShownPublisher>,
    /// `None` where the image topic has that name.
    confirmed: Option<Publisher<Image>>,
    /// `true` if somebody subscribed and has not received an image yet.
    new_subscriber: Arc<AtomicBool>,
}

impl TopicOutput {
    /// Advertises an image topic and its CameraInfo. A new subscriber wakes the node's thread.
    ///
    /// # Errors
    /// [`NodeError::Name`].
    pub(crate) fn advertise(ros: &RosNode, topic: &str) -> Result<Self, NodeError> {
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
        let shown: ShownPublisher = Arc::new(ros.publisher(&sibling_topic(topic, "shown"), shown::QUEUE_SIZE)?);
        let shown = Some(shown).filter(|shown| shown.topic() != publisher.topic());
        let confirmed: Publisher<Image> = ros.observed_publisher(&sibling_topic(topic, "confirmed"), 1, on_change())?;
        let confirmed = Some(confirmed).filter(|confirmed| confirmed.topic() != publisher.topic());
        Ok(Self { publisher, compressed, depth: is_free.then_some(depth), shown, confirmed, new_subscriber })
    }

    pub(crate) fn topic(&self) -> &str {
        self.publisher.topic()
    }

    pub(crate) fn names(&self) -> TopicNames {
        [self.publisher.topic(), self.publisher.info_topic()].map(str::to_owned)
    }

    /// Takes over settings that have come from the parameter server.
    pub(crate) fn poll_settings(&mut self, ros: &RosNode) {
        self.compressed.poll_settings(ros);
    }

    /// dynamic_reconfigure's server with its settings.
    pub(crate) fn server(&self) -> Option<&ReconfigureServer> {
        self.compressed.server()
    }

    /// Takes a user's settings of the compressed images. Returns those that apply from now on.
    pub(crate) fn reconfigure(&mut self, ros: &RosNode, request: &NamedValues) -> Option<Values> {
        self.compressed.reconfigure(ros, request)
    }

    pub(crate) fn wants_depth(&self) -> bool {
        self.depth.as_ref().is_some_and(Publisher::is_watched)
    }

    /// The topic of records of what was shown, if somebody subscribes to it.
    pub(crate) fn shown(&self) -> Option<&ShownPublisher> {
        self.shown.as_ref().filter(|shown| shown.is_watched())
    }

    /// Number of nodes that subscribe to the images, compressed ones included, or the CameraInfo.
    pub(crate) fn subscriber_count(&self) -> usize {
        self.publisher.subscriber_count()
    }
}

impl Output for TopicOutput {
    fn send(&mut self, frame: &OutputFrame) -> Result<()> {
        let image = frame.image.content(Instant::now());
        let header = self.publisher.publish(&image, &frame.info, frame.stamp)?;
        self.compressed.offer(&frame.image, header);
        let publisher = self.depth.as_ref().filter(|publisher| publisher.is_watched());
        if let (Some(depth), Some(publisher)) = (&frame.depth, publisher) {
            let header = Header { seq: 0, stamp: frame.stamp, frame_id: frame.info.header.frame_id.clone() };
            publisher.send_image(&depth.message(header))?;
        }
        if let Some(publisher) = self.confirmed.as_ref().filter(|publisher| publisher.is_watched()) {
            let header = Header { seq: 0, stamp: frame.stamp, frame_id: frame.info.header.frame_id.clone() };
            let post = frame.image.grant().map(|grant| &**grant.post());
            confirmed_image(post, frame.image.size_px(), header).map(|mask| publisher.send_image(&mask)).transpose()?;
        }
        Ok(())
    }

    fn is_watched(&self) -> bool {
        let confirmed = self.confirmed.as_ref().is_some_and(Publisher::is_watched);
        self.subscriber_count() > 0 || self.wants_depth() || confirmed
    }

    fn take_new_watcher(&mut self) -> bool {
        self.new_subscriber.swap(false, Ordering::AcqRel)
    }
}

/// Keeps one output for each of the `wanted` names and closes all others.
pub(crate) fn retain(outputs: &mut Vec<TopicOutput>, mut wanted: Vec<&TopicNames>) {
    outputs.retain(|output| {
        let found = wanted.iter().position(|names| **names == output.names());
        found.map(|index| wanted.swap_remove(index)).is_some()
    });
}
