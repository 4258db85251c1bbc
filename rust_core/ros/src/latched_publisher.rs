//! A latched topic: late subscribers get its last message.

use crate::image_topic::{advertise, send_error, PublishError};
use crate::listeners::tune_listeners;
use crate::RosNode;
use rcs_messages::Message;

/// Publishes a latched topic until it is dropped.
pub struct LatchedPublisher<T: Message> {
    publisher: rosrust::Publisher<T>,
    topic: String,
}

impl RosNode {
    /// Publishes `topic`, latched. Up to `queue_size` messages wait for rosrust's writing thread.
    ///
    /// # Errors
    /// [`PublishError`] if the topic cannot be published.
    pub fn latched_publisher<T: Message>(
        &self,
        topic: &str,
        queue_size: usize,
    ) -> Result<LatchedPublisher<T>, PublishError> {
        let mut publisher = advertise::<T>(topic, queue_size)?;
        publisher.set_latching(true);
        tune_listeners();
        let topic = self.resolve(topic).unwrap_or_else(|_| topic.to_owned());
        Ok(LatchedPublisher { publisher, topic })
    }
}

impl<T: Message> LatchedPublisher<T> {
    /// The topic's whole name, after remapping.
    pub fn topic(&self) -> &str {
        &self.topic
    }

    /// Sends a message, which replaces the latched one. Never waits. rosrust fills in a header's sequence number
    /// and stamp if they are zero.
    ///
    /// # Errors
    /// [`PublishError`] if the message cannot be sent.
    pub fn send(&self, message: T) -> Result<(), PublishError> {
        self.publisher.send(message).map_err(|error| send_error(&self.topic, &error))
    }
}
