//! A topic that is not latched: who subscribes later gets nothing of what was sent before, such as commands.

use crate::publisher::Publisher;
use crate::{NodeError, RosNode};
use rcs_messages::Message;
use std::io;

/// Publishes a topic until it is dropped.
pub struct TopicPublisher<T: Message>(Publisher<T>);

impl RosNode {
    /// Publishes `topic`, not latched. Up to `queue_size` messages wait for a slow subscriber.
    ///
    /// # Errors
    /// [`NodeError::Name`].
    pub fn publisher<T: Message>(&self, topic: &str, queue_size: usize) -> Result<TopicPublisher<T>, NodeError> {
        Ok(TopicPublisher(Publisher::unobserved(self.network(), &self.resolve(topic)?, queue_size, false)))
    }
}

impl<T: Message> TopicPublisher<T> {
    /// The topic's whole name, after remapping.
    pub fn topic(&self) -> &str {
        self.0.topic()
    }

    /// Sends a message as it is. Never waits.
    ///
    /// # Errors
    /// `InvalidInput` for a message of more than 4 GB.
    pub fn send(&self, message: &T) -> io::Result<()> {
        self.0.send(message)
    }
}
