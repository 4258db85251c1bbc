//! The subscriptions of a config, for the node and for `check --live`.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use rcs_displays::TopicRequest;
use rcs_messages::MessageKind;
use rcs_ros::{NodeEvent, Publishing, RosNode, TopicSubscription};
use rcs_transforms::Time;

use crate::safety::ages::TopicSource;
use crate::scene::lazy_streams::{LazyStreams, StreamKey, StreamState};
use crate::scene::SceneState;

/// The subscribed topics, and their names in the config.
#[derive(Default)]
pub(crate) struct Subscriptions {
    subscribed: HashMap<StreamKey, TopicSubscription>,
    names: HashMap<StreamKey, Vec<String>>,
    lazy: LazyStreams,
}

impl Subscriptions {
    /// Subscribes to the requested topics and to nothing else. A subscription that is kept keeps its connections.
    pub(crate) fn update(&mut self, ros: &RosNode, requests: Vec<TopicRequest>) {
        self.names.clear();
        let mut queue_sizes: HashMap<StreamKey, usize> = HashMap::new();
        // In the config's order.
        let mut wanted: Vec<(StreamKey, String)> = Vec::new();
        for request in requests {
            let key: StreamKey = match ros.resolve(&request.topic) {
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
        self.lazy.retain(|key| queue_sizes.contains_key(key));
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

    /// Pauses streams that nobody watches, and resumes them as soon as somebody does; see [`LazyStreams`]. Returns
    /// `true` if any is paused from now on.
    pub(crate) fn pause_streams(&mut self, is_watched: bool, scene: &SceneState) -> bool {
        let Self { subscribed, names, lazy } = self;
        let may_pause = |key: &StreamKey| {
            let is_replaced = |name: &String| scene.is_replaced_by_newest(name, key.1);
            subscribed.get(key).is_some_and(|subscription| !subscription.is_latched())
                && names.get(key).is_some_and(|names| names.iter().all(is_replaced))
        };
        let changes = lazy.update(is_watched, Instant::now(), may_pause);
        for (keys, is_paused) in [(&changes.pause, true), (&changes.resume, false)] {
            for (key, subscription) in keys.iter().filter_map(|key| Some((key, subscribed.get(key)?))) {
                log::debug!(
                    "{}: {}",
                    key.0,
                    if is_paused { "not received while nobody watches" } else { "received again" }
                );
                subscription.set_paused(is_paused);
            }
        }
        !changes.pause.is_empty()
    }

    /// Longest time that frames wait for resumed streams; `None` if they need not wait.
    pub(crate) fn awaited(&self, now: Instant) -> Option<Duration> {
        self.lazy.awaited_for(now)
    }

    /// `true` if a topic, by its name in the config, is paused because nobody watches.
    pub(crate) fn is_paused(&self, topic: &str) -> bool {
        let is_it = |(_, names): &(&StreamKey, &Vec<String>)| names.iter().any(|name| name == topic);
        self.names.iter().filter(is_it).any(|(key, _)| self.lazy.state(key) == StreamState::Paused)
    }

    /// The config's names of a topic.
    fn names(&self, topic: &Arc<str>, kind: MessageKind) -> &[String] {
        self.names.get(&(Arc::clone(topic), kind)).map(Vec::as_slice).unwrap_or_default()
    }

    /// The publishers of a topic of this type, by its name in the config; `None` where it is not subscribed to.
    pub(crate) fn source(&self, name: &str, kind: MessageKind) -> Option<TopicSource> {
        let has_name = |key: &&StreamKey| key.1 == kind && self.names(&key.0, kind).iter().any(|known| known == name);
        let key = self.names.keys().find(has_name)?;
        let (subscription, state) = (self.subscribed.get(key)?, self.lazy.state(key));
        // No publisher holds the data from before a pause: they may have been replaced meanwhile.
        let is_current = state == StreamState::Received;
        let publishing = if is_current { subscription.publishing() } else { Publishing::default() };
        Some(TopicSource { topic: key.0.to_string(), publishing })
    }

    /// Applies an event to the scene. `now` is ROS time.
    pub(crate) fn apply(&mut self, event: NodeEvent, scene: &mut SceneState, now: Time) {
        match event {
            NodeEvent::Message { topic, message, received, .. } => {
                self.lazy.note_message(&(Arc::clone(&topic), message.kind()), received);
                for name in self.names(&topic, message.kind()) {
                    scene.take_received(name, &message, Some(received), now);
                }
            }
            NodeEvent::Transforms { message, is_static, authority, .. } => {
                scene.take_transforms(&message, is_static, &authority);
            }
            NodeEvent::Parameter { name, text } => scene.take_parameter(&name, text.as_ref(), now),
            NodeEvent::PublisherLeft { topic } => {
                for name in MessageKind::ALL.iter().flat_map(|kind| self.names(&topic, *kind)) {
                    scene.publisher_left(name);
                }
            }
            NodeEvent::TimeJumpedBack { .. } => scene.reset(),
        }
    }
}
