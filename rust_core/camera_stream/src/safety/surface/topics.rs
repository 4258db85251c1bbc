//! Subscriptions to depth cameras. The type of a topic is the publisher's, so each is subscribed to once somebody
//! publishes it.

use rcs_messages::MessageKind;
use rcs_ros::image_topic::camera_info_topic;
use rcs_ros::{NodeError, RosNode, TopicSubscription};

use super::grid::raw_topic;
use crate::safety::ages::TopicSource;

/// Types of messages that have a surface.
const KINDS: [MessageKind; 3] = [MessageKind::Image, MessageKind::CompressedImage, MessageKind::PointCloud2];

/// The subscriptions to the topics of depth cameras.
#[derive(Default)]
pub(crate) struct SurfaceTopics {
    topics: Vec<SurfaceTopic>,
    is_paused: bool,
}

struct SurfaceTopic {
    /// The topic as it was given: a subscription remaps it.
    given: String,
    whole: String,
    points: Option<TopicSubscription>,
    /// CameraInfo of a depth image.
    info: Option<TopicSubscription>,
    /// Type of the publisher, if it has no surface.
    unsupported: Option<String>,
}

/// The topic of the CameraInfo of a depth image.
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
        if !self.topics.iter().any(|topic| topic.whole == whole) {
            let given = given.to_owned();
            self.topics.push(SurfaceTopic { given, whole: whole.clone(), points: None, info: None, unsupported: None });
        }
        Ok(whole)
    }

    /// Subscribes to the topics that have a publisher by now, and pauses all while nobody watches.
    pub(crate) fn update(&mut self, ros: &RosNode, is_watched: bool) {
        for topic in self.topics.iter_mut().filter(|topic| topic.points.is_none() && is_watched) {
            if let Err(error) = topic.subscribe(ros) {
                if topic.unsupported.as_ref() != Some(&error) {
                    log::error!("surface on {}: {error}", topic.whole);
                }
                topic.unsupported = Some(error);
            }
        }
        if std::mem::replace(&mut self.is_paused, !is_watched) == self.is_paused {
            return;
        }
        for subscription in self.topics.iter().flat_map(|topic| [&topic.points, &topic.info]).flatten() {
            subscription.set_paused(!is_watched);
        }
    }

    /// The publishers of a topic, by its whole name.
    pub(in crate::safety) fn source(&self, topic: &str) -> Option<TopicSource> {
        let found = self.topics.iter().find(|known| known.whole == topic)?;
        Some(TopicSource { topic: topic.to_owned(), publishing: found.points.as_ref()?.publishing() })
    }
}

impl SurfaceTopic {
    /// Subscribes if somebody publishes the topic.
    fn subscribe(&mut self, ros: &RosNode) -> Result<(), String> {
        let publications = ros.publications();
        let Some(published) = publications.as_ref().and_then(|all| all.get(&self.whole)) else { return Ok(()) };
        if published.ros_type == "*" {
            return Ok(());
        }
        let kind = MessageKind::from_ros_type(&published.ros_type).filter(|kind| KINDS.contains(kind));
        let kind = kind.ok_or_else(|| {
            format!("{} has no surface: use a depth image or an organised PointCloud2", published.ros_type)
        })?;
        let subscribe = |topic: &str, kind| ros.subscribe(topic, kind, 1).map_err(|error| error.to_string());
        if kind != MessageKind::PointCloud2 {
            self.info = Some(subscribe(&info_topic(&self.given), MessageKind::CameraInfo)?);
        }
        self.points = Some(subscribe(&self.given, kind)?);
        Ok(())
    }
}
