//! Publishing a topic of the node.

use std::collections::BTreeSet;
use std::io;
use std::marker::PhantomData;
use std::sync::atomic::AtomicUsize;
use std::sync::Arc;

use rcs_messages::diagnostic_msgs::DiagnosticArray;
use rcs_messages::sensor_msgs::CompressedImage;
use rcs_messages::std_msgs::Header;
use rcs_messages::{encode, Image, Message, SharedBytes};

use crate::clock::RosClock;
use crate::error::NodeError;
use crate::network::Network;
use crate::node::RosNode;
use crate::registrar::Entry;
use crate::tcpros::{Change, Description, EncodedMessage, Observer, Publication};

/// Queue size of `/diagnostics`.
const DIAGNOSTICS_QUEUE_SIZE: usize = 4;

/// Publishes a topic until it is dropped. Several publishers of one topic share its subscribers.
///
/// No method waits; the oldest message in a slow subscriber's queue is dropped. Errors name the topic.
pub struct Publisher<T> {
    network: Arc<Network>,
    publication: Arc<Publication>,
    observer: u64,
    clock: Arc<dyn rosrust::Clock>,
    next_seq: Arc<AtomicUsize>,
    messages: PhantomData<fn(T)>,
}

impl RosNode {
    /// Publishes a topic with a queue of `queue_size` messages for each subscriber.
    ///
    /// # Errors
    /// [`NodeError::Name`].
    pub fn publisher<T: Message>(&self, topic: &str, queue_size: usize) -> Result<Publisher<T>, NodeError> {
        Ok(self.open_publisher(&self.resolve(topic)?, queue_size, false, &self.observer(|_, _| {})))
    }

    /// Publishes a latched topic: late subscribers get its last message.
    ///
    /// # Errors
    /// [`NodeError::Name`].
    pub fn latched_publisher<T: Message>(&self, topic: &str, queue_size: usize) -> Result<Publisher<T>, NodeError> {
        Ok(self.open_publisher(&self.resolve(topic)?, queue_size, true, &self.observer(|_, _| {})))
    }

    /// Publishes a topic and calls `on_change` with the name of every other node that subscribes or leaves, on the
    /// thread of its connection.
    ///
    /// # Errors
    /// [`NodeError::Name`].
    pub fn observed_publisher<T: Message>(
        &self,
        topic: &str,
        queue_size: usize,
        on_change: impl Fn(Change, &str) + Send + Sync + 'static,
    ) -> Result<Publisher<T>, NodeError> {
        Ok(self.open_publisher(&self.resolve(topic)?, queue_size, false, &self.observer(on_change)))
    }

    /// Publishes the node's status on `/diagnostics`, for rqt_robot_monitor and diagnostic_aggregator.
    ///
    /// # Errors
    /// [`NodeError::Name`], if it is remapped to no name.
    pub fn diagnostics_publisher(&self) -> Result<Publisher<DiagnosticArray>, NodeError> {
        self.publisher("/diagnostics", DIAGNOSTICS_QUEUE_SIZE)
    }

    /// An observer of all subscribers but this node: its own config may well subscribe to what it publishes.
    pub(crate) fn observer(&self, on_change: impl Fn(Change, &str) + Send + Sync + 'static) -> Observer {
        let own_name = self.name().to_owned();
        Arc::new(move |change, name| {
            if name != own_name {
                on_change(change, name);
            }
        })
    }

    /// Publishes a topic by its whole name.
    pub(crate) fn open_publisher<T: Message>(
        &self,
        topic: &str,
        queue_size: usize,
        is_latching: bool,
        observer: &Observer,
    ) -> Publisher<T> {
        let description = Description {
            topic: topic.to_owned(),
            ros_type: T::msg_type(),
            md5sum: T::md5sum(),
            definition: T::msg_definition(),
            is_latching,
            queue_size: queue_size.max(1),
            number: Entry::next_number(),
        };
        let network = Arc::clone(self.network());
        let (publication, observer) = network.publish(description, observer);
        let clock: Arc<RosClock> = Arc::clone(self.clock());
        Publisher { network, publication, observer, clock, next_seq: Arc::default(), messages: PhantomData }
    }
}

impl<T: Message> Publisher<T> {
    /// The topic's whole name, after remapping.
    pub fn topic(&self) -> &str {
        &self.publication.description().topic
    }

    /// `true` if another node subscribes.
    pub fn is_watched(&self) -> bool {
        !self.subscriber_names().is_empty()
    }

    /// The names of the other nodes that subscribe.
    pub(crate) fn subscriber_names(&self) -> BTreeSet<String> {
        let own = &self.network.registrar().master().node_name;
        let names = self.publication.subscribers().into_iter().map(|subscriber| subscriber.name.clone());
        names.filter(|name| name != own).collect()
    }

    /// Sends a message. In a header of a generated type, a sequence number and a stamp of zero are filled in; the types
    /// that `rcs_messages` defines itself go out as they are.
    ///
    /// # Errors
    /// `InvalidInput` for a message of more than 4 GB.
    pub fn send(&self, mut message: T) -> io::Result<()> {
        message.set_header(&self.clock, &self.next_seq);
        self.send_unchanged(&message)
    }

    /// Sends a message with its header as it is.
    pub(crate) fn send_unchanged(&self, message: &T) -> io::Result<()> {
        self.send_parts(&encode(message), Arc::new([]))
    }

    /// Sends an encoded message in two parts, of which the second is shared and not copied.
    fn send_parts(&self, beginning: &[u8], rest: SharedBytes) -> io::Result<()> {
        let frame = EncodedMessage::new(beginning, rest)
            .map_err(|error| io::Error::new(error.kind(), format!("cannot send on {}: {error}", self.topic())))?;
        self.publication.send(&frame);
        Ok(())
    }
}

impl Publisher<Image> {
    /// Sends an image without copying the pixels of [`Image::sharing`].
    ///
    /// # Errors
    /// As [`send`](Self::send).
    pub fn send_image(&self, image: &Image) -> io::Result<()> {
        let (beginning, pixels) = image.parts();
        self.send_parts(&beginning, pixels)
    }
}

impl Publisher<CompressedImage> {
    /// Sends an encoded image without copying its data.
    ///
    /// # Errors
    /// As [`send`](Self::send).
    pub fn send_compressed(&self, header: Header, format: &str, data: Vec<u8>) -> io::Result<()> {
        let empty = CompressedImage { header, format: format.to_owned(), data: Vec::new() };
        let mut beginning = encode(&empty);
        // The last field is the length of the data. One that 32 bits do not hold is refused with the whole message.
        beginning.truncate(beginning.len() - 4);
        beginning.extend_from_slice(&(data.len() as u32).to_le_bytes());
        self.send_parts(&beginning, Arc::new(data))
    }
}

impl<T> Drop for Publisher<T> {
    fn drop(&mut self) {
        self.network.unpublish(&self.publication, self.observer);
    }
}
