//! The subscriptions of a config, for the node and for `check --live`, and what arrives on them.

use std::collections::HashMap;
use std::sync::Arc;

use rcs_displays::TopicRequest;
use rcs_messages::MessageKind;
use rcs_ros::{NodeEvent, Publishing, RosNode, TopicSubscription};
use rcs_transforms::Time;

use crate::camera_stream::stage::Stage;

/// A topic by its whole name and type.
type Key = (Arc<str>, MessageKind);

/// Where the data of a subscribed topic come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Source {
    /// The topic's whole name.
    pub(crate) topic: String,
    /// Who is connected.
    pub(crate) publishing: Publishing,
}

/// What is subscribed to, and the names that the config has for it.
#[derive(Default)]
pub(crate) struct Subscriptions {
    subscribed: HashMap<Key, TopicSubscription>,
    names: HashMap<Key, Vec<String>>,
}

impl Subscriptions {
    /// Subscribes to what is requested and to nothing else. A subscription that is kept keeps its connections.
    pub(crate) fn update(&mut self, ros: &RosNode, requests: Vec<TopicRequest>) {
        self.names.clear();
        let mut queue_sizes: HashMap<Key, usize> = HashMap::new();
        // In the config's order.
        let mut wanted: Vec<(Key, String)> = Vec::new();
        for request in requests {
            let key: Key = match ros.resolve(&request.topic) {
                Ok(topic) => (topic.into(), request.kind),
                Err(error) => {
                    log::error!("{error}");
                    continue;
                }
            };
            let queue_size = queue_sizes.entry(key.clone()).or_default();
            *queue_size = (*queue_size).max(request.queue_size);
            self.names.entry(key.clone()).or_default().push(request.topic.clone());
            wanted.push((key, request.topic));
        }
        // First, as the same topic may be requested with another type.
        self.subscribed.retain(|key, _| queue_sizes.contains_key(key));
        for (key, given_name) in wanted {
            let queue_size = queue_sizes.get(&key).copied().unwrap_or(1);
            if let Some(subscription) = self.subscribed.get(&key) {
                subscription.set_queue_size(queue_size);
                continue;
            }
            // By the name in the config: remapping must not be applied twice.
            match ros.subscribe(&given_name, key.1, queue_size) {
                Ok(subscription) => drop(self.subscribed.insert(key, subscription)),
                Err(error) => log::error!("{error}"),
            }
        }
    }

    /// The config's names of a topic.
    fn names(&self, topic: &Arc<str>, kind: MessageKind) -> &[String] {
        self.names.get(&(Arc::clone(topic), kind)).map(Vec::as_slice).unwrap_or_default()
    }

    /// Who publishes a topic of this type at present, by its name in the config; none where it is not subscribed to.
    pub(crate) fn source(&self, name: &str, kind: MessageKind) -> Option<Source> {
        let has_name = |key: &&Key| key.1 == kind && self.names(&key.0, kind).iter().any(|known| known == name);
        let key = self.names.keys().find(has_name)?;
        let publishing = self.subscribed.get(key)?.publishing();
        Some(Source { topic: key.0.to_string(), publishing })
    }

    /// Applies an event to the stage, if it is one that changes the scene: a message, transforms, a parameter, a
    /// publisher that left, time that jumped back. `now` is ROS time.
    pub(crate) fn apply(&self, event: NodeEvent, stage: &mut Stage, now: Time) {
        match event {
            NodeEvent::Message { topic, message, received, .. } => {
                for name in self.names(&topic, message.kind()) {
                    stage.take_received(name, &message, Some(received), now);
                }
            }
            NodeEvent::Transforms { message, is_static, authority, .. } => {
                stage.take_transforms(&message, is_static, &authority);
            }
            NodeEvent::Parameter { name, text } => stage.take_parameter(&name, text.as_ref(), now),
            NodeEvent::PublisherLeft { topic } => {
                for name in MessageKind::ALL.iter().flat_map(|kind| self.names(&topic, *kind)) {
                    stage.publisher_left(name);
                }
            }
            NodeEvent::TimeJumpedBack { .. } => stage.reset(),
        }
    }
}
