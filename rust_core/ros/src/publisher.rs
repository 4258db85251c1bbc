//! Publishing a topic of the node.

use std::collections::BTreeSet;
use std::io;
use std::marker::PhantomData;
use std::sync::Arc;

use rcs_messages::{encode, Message, SharedBytes};

use crate::network::Network;
use crate::registrar::Entry;
use crate::tcpros::{Description, Frame, Observer, Publication};

/// Publishes a topic until it is dropped. Several publishers of one topic share its subscribers.
pub(crate) struct Publisher<T> {
    network: Arc<Network>,
    publication: Arc<Publication>,
    observer: u64,
    messages: PhantomData<fn(T)>,
}

impl<T: Message> Publisher<T> {
    /// Publishes a topic by its whole name. `observer` is called for each subscriber that comes and goes.
    pub(crate) fn new(
        network: &Arc<Network>,
        topic: &str,
        queue_size: usize,
        is_latching: bool,
        observer: &Observer,
    ) -> Self {
        let description = Description {
            topic: topic.to_owned(),
            ros_type: T::msg_type(),
            md5sum: T::md5sum(),
            definition: T::msg_definition(),
            is_latching,
            queue_size: queue_size.max(1),
            number: Entry::next_number(),
        };
        let (publication, observer) = network.publish(description, observer);
        Self { network: Arc::clone(network), publication, observer, messages: PhantomData }
    }

    /// As [`new`](Self::new), for publishers whose subscribers do not matter.
    pub(crate) fn unobserved(network: &Arc<Network>, topic: &str, queue_size: usize, is_latching: bool) -> Self {
        let ignore: Observer = Arc::new(|_, _| {});
        Self::new(network, topic, queue_size, is_latching, &ignore)
    }

    /// The topic's whole name, after remapping.
    pub(crate) fn topic(&self) -> &str {
        &self.publication.description().topic
    }

    /// The names of the nodes that subscribe, this node not among them.
    pub(crate) fn subscriber_names(&self) -> BTreeSet<String> {
        let own = &self.network.registrar().master().node_name;
        let names = self.publication.subscribers().into_iter().map(|subscriber| subscriber.name.clone());
        names.filter(|name| name != own).collect()
    }

    /// Sends a message. Never waits.
    ///
    /// # Errors
    /// `InvalidInput` for a message of more than 4 GB.
    pub(crate) fn send(&self, message: &T) -> io::Result<()> {
        self.send_parts(&encode(message), Arc::new([]))
    }

    /// Sends a message that is encoded already, in two parts of which the second is shared and not copied.
    ///
    /// # Errors
    /// `InvalidInput` for a message of more than 4 GB.
    pub(crate) fn send_parts(&self, beginning: &[u8], rest: SharedBytes) -> io::Result<()> {
        self.publication.send(&Frame::new(beginning, rest)?);
        Ok(())
    }
}

impl<T> Drop for Publisher<T> {
    fn drop(&mut self) {
        self.network.unpublish(&self.publication, self.observer);
    }
}

/// The registration of a publication.
pub(crate) fn entry(description: &Description) -> Entry {
    let Description { topic, ros_type, number, .. } = description;
    Entry::Publisher { topic: topic.clone(), ros_type: ros_type.clone(), number: *number }
}
