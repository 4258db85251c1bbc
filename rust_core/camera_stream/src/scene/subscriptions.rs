//! The subscriptions of a config, for the node and for `check --live`.

use std::collections::hash_map::{Entry, HashMap};
use std::time::{Duration, Instant};

use rcs_displays::TopicRequest;
use rcs_messages::MessageKind;
use rcs_ros::{NodeEvent, Publishing, RosNode, TopicSubscription};
use rcs_transforms::Time;

use crate::safety::ages::TopicSource;
use crate::scene::lazy_streams::{LazyStreams, StreamKey, StreamState};
use crate::scene::SceneState;

/// The routes of received messages to the scene, and the parameters that it follows.
#[derive(Default)]
pub(crate) struct Subscriptions {
    routes: HashMap<StreamKey, Route>,
    lazy: LazyStreams,
    /// Followed parameters.
    parameters: Vec<String>,
}

/// A subscribed topic, and its names in the config.
struct Route {
    subscription: TopicSubscription,
    names: Vec<String>,
    queue_size: usize,
}

impl Subscriptions {
    /// Subscribes to the topics of a scene and to nothing else, and follows its parameters. A subscription that is kept
    /// keeps its connections.
    pub(crate) fn update(&mut self, ros: &RosNode, scene: &SceneState) {
        let known = std::mem::replace(&mut self.parameters, scene.parameters());
        let new = self.parameters.iter().filter(|name| !known.contains(name));
        ros.follow_parameters(new.cloned().collect());
        let resolve = |request: TopicRequest| match ros.resolve(&request.topic) {
            Ok(topic) => Some(((topic.into(), request.kind), request)),
            Err(error) => {
                log::error!("{error}");
                None
            }
        };
        let wanted: Vec<(StreamKey, TopicRequest)> = scene.topics().into_iter().filter_map(resolve).collect();
        let is_wanted = |key: &StreamKey| wanted.iter().any(|(wanted, _)| wanted == key);
        // First, as the same topic may be requested with another type.
        self.routes.retain(|key, _| is_wanted(key));
        self.lazy.retain(is_wanted);
        self.routes.values_mut().for_each(|route| (route.names, route.queue_size) = (Vec::new(), 0));
        for (key, TopicRequest { topic, kind, queue_size }) in wanted {
            let route = match self.routes.entry(key) {
                Entry::Occupied(known) => known.into_mut(),
                // By the name in the config: remapping must not be applied twice.
                Entry::Vacant(new) => match ros.subscribe(&topic, kind, queue_size) {
                    Ok(subscription) => new.insert(Route { subscription, names: Vec::new(), queue_size: 0 }),
                    Err(error) => {
                        log::error!("{error}");
                        continue;
                    }
                },
            };
            route.queue_size = route.queue_size.max(queue_size);
            route.subscription.set_queue_size(route.queue_size);
            route.names.push(topic);
        }
    }

    /// Pauses streams that nobody watches, and resumes them as soon as somebody does; see [`LazyStreams`]. Returns
    /// `true` if any is paused from now on.
    pub(crate) fn pause_streams(&mut self, is_watched: bool, scene: &SceneState) -> bool {
        let routes = &self.routes;
        let may_pause = |key: &StreamKey| {
            let is_replaced = |name: &String| scene.is_replaced_by_newest(name, key.1);
            routes.get(key).is_some_and(|route| !route.subscription.is_latched() && route.names.iter().all(is_replaced))
        };
        let changes = self.lazy.update(is_watched, Instant::now(), may_pause);
        for (keys, is_paused) in [(&changes.pause, true), (&changes.resume, false)] {
            for (key, route) in keys.iter().filter_map(|key| Some((key, routes.get(key)?))) {
                let what = if is_paused { "not received while nobody watches" } else { "received again" };
                log::debug!("{}: {what}", key.0);
                route.subscription.set_paused(is_paused);
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
        let is_it = |(_, route): &(&StreamKey, &Route)| route.names.iter().any(|name| name == topic);
        self.routes.iter().filter(is_it).any(|(key, _)| self.lazy.state(key) == StreamState::Paused)
    }

    /// The publishers of a topic of this type, by its name in the config; `None` where it is not subscribed to.
    pub(crate) fn source(&self, name: &str, kind: MessageKind) -> Option<TopicSource> {
        let is_it =
            |(key, route): &(&StreamKey, &Route)| key.1 == kind && route.names.iter().any(|known| known == name);
        let (key, route) = self.routes.iter().find(is_it)?;
        // No publisher holds the data from before a pause: they may have been replaced meanwhile.
        let is_current = self.lazy.state(key) == StreamState::Received;
        let publishing = if is_current { route.subscription.publishing() } else { Publishing::default() };
        Some(TopicSource { topic: key.0.to_string(), publishing })
    }

    /// Applies an event to the scene. `now` is ROS time.
    pub(crate) fn apply(&mut self, event: NodeEvent, scene: &mut SceneState, now: Time) {
        match event {
            NodeEvent::Message { topic, message, received, .. } => {
                let key = (topic, message.kind());
                self.lazy.note_message(&key, received);
                for name in self.routes.get(&key).into_iter().flat_map(|route| &route.names) {
                    scene.take_received(name, &message, Some(received), now);
                }
            }
            NodeEvent::Transforms { message, is_static, authority, .. } => {
                scene.take_transforms(&message, is_static, &authority);
            }
            NodeEvent::Parameter { name, text } => scene.take_parameter(&name, text.as_ref(), now),
            NodeEvent::PublisherLeft { topic } => {
                let of_topic = self.routes.iter().filter(|(key, _)| key.0 == topic);
                of_topic.flat_map(|(_, route)| &route.names).for_each(|name| scene.publisher_left(name));
            }
            NodeEvent::TimeJumpedBack { .. } => scene.reset(),
        }
    }
}
