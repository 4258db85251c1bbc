//! A latched topic: late subscribers get its last message.

use crate::publisher::Publisher;
use crate::{NodeError, RosClock, RosNode};
use rcs_messages::Message;
use std::io;
use std::sync::atomic::AtomicUsize;
use std::sync::Arc;

/// Publishes a latched topic until it is dropped.
pub struct LatchedPublisher<T: Message> {
    publisher: Publisher<T>,
    clock: Arc<dyn rosrust::Clock>,
    next_seq: Arc<AtomicUsize>,
}

impl RosNode {
    /// Publishes `topic`, latched. Up to `queue_size` messages wait for a slow subscriber.
    ///
    /// # Errors
    /// [`NodeError::Name`].
    pub fn latched_publisher<T: Message>(
        &self,
        topic: &str,
        queue_size: usize,
    ) -> Result<LatchedPublisher<T>, NodeError> {
        let publisher = Publisher::unobserved(self.network(), &self.resolve(topic)?, queue_size, true);
        let clock: Arc<RosClock> = Arc::clone(self.clock());
        Ok(LatchedPublisher { publisher, clock, next_seq: Arc::default() })
    }
}

impl<T: Message> LatchedPublisher<T> {
    /// The topic's whole name, after remapping.
    pub fn topic(&self) -> &str {
        self.publisher.topic()
    }

    /// Sends a message, which replaces the latched one. Never waits. A header's sequence number and stamp are filled in
    /// if they are zero.
    ///
    /// # Errors
    /// `InvalidInput` for a message of more than 4 GB.
    pub fn send(&self, mut message: T) -> io::Result<()> {
        message.set_header(&self.clock, &self.next_seq);
        self.publisher.send(&message)
    }
}
