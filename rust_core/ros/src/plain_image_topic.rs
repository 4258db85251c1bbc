//! Images on a topic of their own, without a CameraInfo: that of the depths beside a picture.

use std::io;
use std::sync::Arc;

use rcs_messages::Image;

use crate::publisher::Publisher;
use crate::tcpros::{Change, Observer};
use crate::{NodeError, RosNode};

/// An image that is still queued for a subscriber is dropped for the next.
const QUEUE_SIZE: usize = 1;

/// Publishes images until it is dropped.
pub struct PlainImagePublisher {
    image: Publisher<Image>,
}

impl RosNode {
    /// Publishes images on `topic`. `on_change` is called with the name of every node that subscribes or leaves, on the
    /// thread of its connection.
    ///
    /// # Errors
    /// [`NodeError::Name`].
    pub fn plain_image_publisher(
        &self,
        topic: &str,
        on_change: impl Fn(Change, &str) + Send + Sync + 'static,
    ) -> Result<PlainImagePublisher, NodeError> {
        let observer: Observer = Arc::new(on_change);
        Ok(PlainImagePublisher {
            image: Publisher::new(self.network(), &self.resolve(topic)?, QUEUE_SIZE, false, &observer),
        })
    }
}

impl PlainImagePublisher {
    /// The topic's whole name, after remapping.
    pub fn topic(&self) -> &str {
        self.image.topic()
    }

    /// Whether another node subscribes.
    pub fn is_watched(&self) -> bool {
        !self.image.subscriber_names().is_empty()
    }

    /// Sends an image. Never waits, and copies no pixels of [`Image::sharing`].
    ///
    /// # Errors
    /// `InvalidInput` for an image of more than 4 GB.
    pub fn publish(&self, image: &Image) -> io::Result<()> {
        let (beginning, pixels) = image.parts();
        self.image.send_parts(&beginning, pixels)
    }
}
