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
    /// How many messages may wait to be taken; at least 1.
    pub queue_size: usize,
}

impl TopicRequest {
    /// A request; its queue size is [`bounded`]. `None` without a topic.
    pub(crate) fn new(topic: &str, kind: MessageKind, queue_size: u32) -> Option<Self> {
        let queue_size = bounded(queue_size);
        (!topic.is_empty()).then(|| Self { topic: topic.to_owned(), kind, queue_size })
    }
}

/// How many messages wait for a queue size of the config; that of 0, without a limit in rviz, is a large one.
pub(crate) fn bounded(queue_size: u32) -> usize {
    if queue_size == 0 {
        1000
    } else {
        queue_size as usize
    }
}

/// One display of a config.
pub(crate) trait Display: Send {
    /// What it subscribes to.
    fn topics(&self) -> Vec<TopicRequest> {
        Vec::new()
    }

    /// Takes a message of one of its topics.
    fn take(&mut self, _message: &AnyMessage, _world: &World<'_>) {}

    /// Takes a message of the topic that it asked for by this name, where it matters which that is.
    fn take_from(&mut self, _topic: &str, message: &AnyMessage, world: &World<'_>) {
        self.take(message, world);
    }

    /// Whether a message of this stamp that it took waits to be shown: for its frame, or for one that belongs to it.
    fn is_waiting(&self, _stamp: Time) -> bool {
        false
    }

    /// A publisher of one of its topics is gone.
    fn publisher_left(&mut self, _topic: &str) {}

    /// Whether each message of its topics replaces all that earlier ones made, so that it misses nothing that it would
    /// still show while it receives none.
    fn is_replaced_by_newest(&self) -> bool {
        false
    }

    /// Shows nothing until the next message: those that it has are old.
    fn forget_shown(&mut self) {}

    /// The ROS parameters that it reads, by their names in the config.
    fn parameters(&self) -> Vec<String> {
        Vec::new()
    }

    /// Takes the text of one of its parameters; `None` while it is not set.
    fn take_parameter(&mut self, _name: &str, _text: Option<&Arc<str>>, _world: &World<'_>) {}

    /// Brings what it shows up to date: places messages whose frames are known now, drops expired ones, follows
    /// moved frames. Returns whether its drawables changed.
    fn update(&mut self, world: &World<'_>) -> bool;

    /// What it shows.
    fn drawables(&self) -> &[Drawable];

    /// The next time at which it changes by itself (something grows too old).
    fn next_change(&self) -> Option<Time> {
        None
    }

    /// Forgets all messages: the time jumped back, or the fixed frame changed.
    fn reset(&mut self) {}

    /// Its statuses.
    fn statuses(&self) -> &Statuses;
}
