//! The contract of a display.

use std::sync::Arc;

use rcs_messages::{AnyMessage, MessageKind};
use rcs_scene::Drawable;
use rcs_transforms::Time;

use crate::{Statuses, World};

/// A topic that a display subscribes to.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct TopicRequest {
    /// The name as the config has it, not resolved or remapped.
    pub topic: String,
    /// The type of its messages.
    pub kind: MessageKind,
    /// Queue size of the subscription, at least 1.
    pub queue_size: usize,
}

impl TopicRequest {
    /// A request with a [`bounded`] queue size; `None` without a topic.
    pub(crate) fn new(topic: &str, kind: MessageKind, queue_size: u32) -> Option<Self> {
        let queue_size = bounded(queue_size);
        (!topic.is_empty()).then(|| Self { topic: topic.to_owned(), kind, queue_size })
    }
}

/// Queue size of a setting; 0, unlimited in rviz, is a large one.
pub(crate) fn bounded(queue_size: u32) -> usize {
    if queue_size == 0 {
        1000
    } else {
        queue_size as usize
    }
}

/// One display of a config.
pub(crate) trait Display: Send {
    /// Topics that it subscribes to.
    fn topics(&self) -> Vec<TopicRequest> {
        Vec::new()
    }

    /// Takes a message of one of its topics.
    fn take(&mut self, _message: &AnyMessage, _world: &World<'_>) {}

    /// Takes a message of the topic that it asked for by this name, where it matters which that is.
    fn take_from(&mut self, _topic: &str, message: &AnyMessage, world: &World<'_>) {
        self.take(message, world);
    }

    /// `true` if a taken message of this stamp waits: for its frame, or for another message that belongs to it.
    fn is_waiting(&self, _stamp: Time) -> bool {
        false
    }

    /// Reacts to the loss of a publisher of one of its topics.
    fn publisher_left(&mut self, _topic: &str) {}

    /// `true` if each message of its topics replaces the drawables of all earlier ones, so that messages may be
    /// skipped.
    fn is_replaced_by_newest(&self) -> bool {
        false
    }

    /// ROS parameters that it reads, by their names in the config.
    fn parameters(&self) -> Vec<String> {
        Vec::new()
    }

    /// Takes the text of one of its parameters; `None` while it is unset.
    fn take_parameter(&mut self, _name: &str, _text: Option<&Arc<str>>, _world: &World<'_>) {}

    /// Updates the drawables: places messages whose frames are known now, removes expired ones, follows moved frames.
    /// Returns whether the drawables changed.
    fn update(&mut self, world: &World<'_>) -> bool;

    fn drawables(&self) -> &[Drawable];

    /// Time of the next change without a message (something expires).
    fn next_change(&self) -> Option<Time> {
        None
    }

    /// Removes all messages: the time jumped back, or the fixed frame changed.
    fn reset(&mut self) {}

    fn statuses(&self) -> &Statuses;
}
