//! The topics that the node listens to.

use std::collections::HashMap;
use std::sync::Arc;

use rcs_displays::TopicRequest;
use rcs_messages::MessageKind;
use rcs_ros::{RosNode, TopicSubscription};

/// A topic by its whole name and type.
type Key = (Arc<str>, MessageKind);

/// What the node listens to, and what the config calls it.
#[derive(Default)]
pub(super) struct Subscriptions {
    subscribed: HashMap<Key, TopicSubscription>,
    names: HashMap<Key, Vec<String>>,
}

impl Subscriptions {
    /// Goes over to what is wanted. A subscription that is wanted still stays as it is, its connections included.
    pub(super) fn follow(&mut self, ros: &RosNode, requests: Vec<TopicRequest>) {
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
        // First, for the same topic may be wanted with another type.
        self.subscribed.retain(|key, _| queue_sizes.contains_key(key));
        for (key, given_name) in wanted {
            let queue_size = queue_sizes.get(&key).copied().unwrap_or(1);
            if let Some(subscription) = self.subscribed.get(&key) {
                subscription.set_queue_size(queue_size);
                continue;
            }
            // By the name that the config has: remapping is not to be done twice.
            match ros.subscribe(&given_name, key.1, queue_size) {
                Ok(subscription) => drop(self.subscribed.insert(key, subscription)),
                Err(error) => log::error!("{error}"),
            }
        }
    }

    /// The config's names of a topic.
    pub(super) fn names(&self, topic: &Arc<str>, kind: MessageKind) -> &[String] {
        self.names.get(&(Arc::clone(topic), kind)).map(Vec::as_slice).unwrap_or_default()
    }
}
