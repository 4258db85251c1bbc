//! Subscriptions to depth cameras. The type of a topic is the publisher's, so each is subscribed to once somebody
//! publishes it.

use rcs_messages::MessageKind;
use rcs_ros::image_topic::camera_info_topic;
use rcs_ros::{NodeError, RosNode, TopicSubscription};

use super::grid::raw_topic;

/// Types of messages that have a surface.
const KINDS: [MessageKind; 3] = [MessageKind::Image, MessageKind::CompressedImage, MessageKind::PointCloud2];

/// The subscriptions to the topics of depth cameras.
#[derive(Default)]
pub(crate) struct SurfaceTopics(Vec<SurfaceTopic>);

struct SurfaceTopic {
    /// The topic as it was given: a subscription remaps it.
    given: String,
    whole: String,
    /// Its messages, and the CameraInfo of depth images; none while nobody publishes or watches.
    subscriptions: Vec<TopicSubscription>,
    /// Why it cannot be subscribed to.
    error: Option<String>,
}

/// The topic of the CameraInfo of a depth image, as image_transport has it: beside the whole name.
pub(super) fn info_topic(topic: &str) -> String {
    camera_info_topic(raw_topic(topic))
}

impl SurfaceTopics {
    /// Adds a topic. Returns its whole name.
    ///
    /// # Errors
    /// A name that ROS does not allow.
    pub(in crate::safety) fn add(&mut self, ros: &RosNode, given: &str) -> Result<String, NodeError> {
        let whole = ros.resolve(given)?;
        if !self.0.iter().any(|topic| topic.whole == whole) {
            let (given, whole) = (given.to_owned(), whole.clone());
            self.0.push(SurfaceTopic { given, whole, subscriptions: Vec::new(), error: None });
        }
        Ok(whole)
    }

    /// Subscribes to the topics that have a publisher by now, and to none while nobody watches. A paused subscription
    /// would keep a topic that a display shares from being paused.
    pub(crate) fn update(&mut self, ros: &RosNode, is_watched: bool) {
        for topic in &mut self.0 {
            if !is_watched {
                topic.subscriptions.clear();
            } else if topic.subscriptions.is_empty() {
                topic.subscribe_or_log(ros);
            }
        }
    }
}

impl SurfaceTopic {
    fn subscribe_or_log(&mut self, ros: &RosNode) {
        match self.subscribe(ros) {
            Ok(subscriptions) => (self.subscriptions, self.error) = (subscriptions, None),
            Err(error) => {
                if self.error.as_ref() != Some(&error) {
                    log::error!("surface on {}: {error}", self.whole);
                }
                self.error = Some(error);
            }
        }
    }

    /// Subscribes if somebody publishes the topic. Its own messages are the first.
    fn subscribe(&self, ros: &RosNode) -> Result<Vec<TopicSubscription>, String> {
        let publications = ros.publications();
        let published = publications.as_ref().and_then(|all| all.get(&self.whole));
        let Some(published) = published.filter(|published| published.ros_type != "*") else { return Ok(Vec::new()) };
        let kind = MessageKind::from_ros_type(&published.ros_type).filter(|kind| KINDS.contains(kind));
        let kind = kind.ok_or_else(|| {
            format!("{} has no surface: use a depth image or an organised PointCloud2", published.ros_type)
        })?;
        let info = (kind != MessageKind::PointCloud2).then(|| (info_topic(&self.whole), MessageKind::CameraInfo));
        let wanted = std::iter::once((self.given.clone(), kind)).chain(info);
        wanted.map(|(topic, kind)| ros.subscribe(&topic, kind, 1).map_err(|error| error.to_string())).collect()
    }
}
