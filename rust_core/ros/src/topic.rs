//! Subscribed topics: one subscription for all listeners of a topic.
//!
//! A listener that is added later gets the latched messages, as a new subscriber from roscpp.

use crate::error::NodeError;
use crate::events::EventSender;
use crate::network::Network;
use crate::registrar::{Entry, Registrar};
use crate::tcpros::{Handler, Source, Subscription, Wanted};
use rcs_messages::{AnyMessage, Message, MessageKind, MessageVisitor};
use rcs_process::lock;
use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex, Weak};
use std::time::Instant;

/// Called with the topic's name and a message.
pub(crate) type MessageCallback = Box<dyn Fn(&Arc<str>, &Received<'_>) + Send + Sync>;

/// A message for listeners.
pub(crate) struct Received<'a> {
    pub(crate) message: &'a AnyMessage,
    /// Name of the publisher.
    pub(crate) publisher: &'a Arc<str>,
    /// Time of reception; for a latched message, when the listener was added.
    pub(crate) at: Instant,
}

/// A subscribed topic, registered until it is dropped.
struct Topic {
    name: Arc<str>,
    kind: MessageKind,
    receiver: Arc<Receiver>,
    subscription: Arc<Subscription>,
    network: Arc<Network>,
}

/// State of a topic for the threads that read from publishers.
struct Receiver {
    name: Arc<str>,
    kind: MessageKind,
    registrar: Arc<Registrar>,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    listeners: BTreeMap<u64, Arc<MessageCallback>>,
    next_listener: u64,
    /// Name of each connected latching publisher, and its last message.
    latched: HashMap<u64, (Arc<str>, Option<AnyMessage>)>,
    /// Connection of the last message.
    last_sender: Option<u64>,
    /// Name of each connected publisher.
    connected: HashMap<u64, Arc<str>>,
}

/// The type, checksum and definition of the visited type.
struct Describe;

impl MessageVisitor for Describe {
    type Output = [String; 3];

    fn visit<T: Message>(self) -> Self::Output {
        [T::msg_type(), T::md5sum(), T::msg_definition()]
    }
}

impl Topic {
    /// Subscribes to a topic by its whole name, without listeners.
    fn new(name: &str, kind: MessageKind, network: &Arc<Network>) -> Self {
        let name: Arc<str> = name.into();
        let registrar = Arc::clone(network.registrar());
        let receiver = Arc::new(Receiver { name: Arc::clone(&name), kind, registrar, state: Mutex::default() });
        let [ros_type, md5sum, definition] = kind.visit(Describe);
        let node_name = network.registrar().master().node_name.clone();
        let number = Entry::next_number();
        let wanted = Wanted { topic: Arc::clone(&name), ros_type, md5sum, definition, node_name, number };
        let subscription = Arc::new(Subscription::new(wanted, Arc::<Receiver>::clone(&receiver)));
        network.registrar().subscribe(&subscription);
        Self { name, kind, receiver, subscription, network: Arc::clone(network) }
    }

    fn check_kind(&self, wanted: MessageKind) -> Result<(), NodeError> {
        if wanted == self.kind {
            return Ok(());
        }
        Err(NodeError::TypeMismatch {
            topic: self.name.to_string(),
            subscribed: self.kind.ros_type(),
            wanted: wanted.ros_type(),
        })
    }

    /// Adds a listener and calls it with the latched messages.
    fn add_listener(&self, listener: MessageCallback) -> u64 {
        let (mut state, at) = (lock(&self.receiver.state), Instant::now());
        for (publisher, message) in state.latched.values() {
            if let Some(message) = message {
                listener(&self.name, &Received { message, publisher, at });
            }
        }
        let id = state.next_listener;
        state.next_listener += 1;
        state.listeners.insert(id, Arc::new(listener));
        id
    }

    /// Removes a listener; `true` if none is left.
    fn remove_listener(&self, id: u64) -> bool {
        let mut state = lock(&self.receiver.state);
        state.listeners.remove(&id);
        state.listeners.is_empty()
    }
}

impl Drop for Topic {
    fn drop(&mut self) {
        self.network.registrar().unsubscribe(&self.subscription);
    }
}

impl Handler for Receiver {
    fn contact_failed(&self, uri: &str, reason: &str) {
        self.registrar.contact_failed(&self.name, uri, reason);
    }

    fn connection_failed(&self) {
        self.registrar.subscribe_again(&self.name);
    }

    fn contacted(&self, uri: &str) {
        self.registrar.contacted(uri);
    }

    fn connected(&self, source: &Source) {
        let mut state = lock(&self.state);
        state.connected.insert(source.connection, Arc::clone(&source.name));
        if source.is_latching {
            state.latched.insert(source.connection, (Arc::clone(&source.name), None));
        }
    }

    fn disconnected(&self, source: &Source) {
        let mut state = lock(&self.state);
        state.connected.remove(&source.connection);
        state.latched.remove(&source.connection);
    }

    fn message(&self, bytes: Vec<u8>, source: &Source) {
        let at = Instant::now();
        let publisher = &source.name;
        let decoded = self.kind.decode_owned(bytes);
        let mut state = lock(&self.state);
        match decoded {
            Ok(message) => {
                state.last_sender = Some(source.connection);
                if let Some((_, latched)) = state.latched.get_mut(&source.connection) {
                    *latched = Some(message.clone());
                }
                for listener in state.listeners.values() {
                    listener(&self.name, &Received { message: &message, publisher, at });
                }
            }
            Err(error) => log::warn!("{}: message of {publisher} dropped: {error}", self.name),
        }
    }
}

/// Present publishers of a subscribed topic.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Publishing {
    /// A publisher is connected.
    pub is_connected: bool,
    /// The publisher of the last message latches and is connected still.
    pub is_latched: bool,
}

/// The subscribed topics of a node, by their whole names.
#[derive(Default)]
pub(crate) struct Topics(Mutex<BTreeMap<String, Arc<Topic>>>);

impl Topics {
    /// Adds a listener to a topic, which is subscribed to if it is not yet. `sender` is that of the listener, if it
    /// queues the messages.
    ///
    /// # Errors
    /// [`NodeError::TypeMismatch`].
    pub(crate) fn subscribe(
        self: &Arc<Self>,
        network: &Arc<Network>,
        name: String,
        kind: MessageKind,
        sender: Option<EventSender>,
        listener: MessageCallback,
    ) -> Result<TopicSubscription, NodeError> {
        // Locked throughout, because the last listener of the topic may be removed meanwhile.
        let mut topics = lock(&self.0);
        let topic = match topics.get(&name) {
            Some(topic) => Arc::clone(topic),
            None => {
                let topic = Arc::new(Topic::new(&name, kind, network));
                topics.insert(name, Arc::clone(&topic));
                topic
            }
        };
        topic.check_kind(kind)?;
        let listener = topic.add_listener(listener);
        Ok(TopicSubscription { topic, listener, sender, topics: Arc::downgrade(self) })
    }

    /// Unsubscribes from all topics.
    pub(crate) fn clear(&self) {
        lock(&self.0).clear();
    }
}

/// Subscription of a topic until it is dropped.
pub struct TopicSubscription {
    topic: Arc<Topic>,
    listener: u64,
    sender: Option<EventSender>,
    topics: Weak<Topics>,
}

impl TopicSubscription {
    /// Whole name of the topic, after remapping, as in its events.
    pub fn topic(&self) -> &Arc<str> {
        &self.topic.name
    }

    /// The type of its messages.
    pub fn kind(&self) -> MessageKind {
        self.topic.kind
    }

    /// `true` if a connected publisher latches its messages.
    pub fn is_latched(&self) -> bool {
        !lock(&self.topic.receiver.state).latched.is_empty()
    }

    /// Disconnects from publishers until it is called with `false`, and drops queued messages. The node stays
    /// registered. A topic with other listeners is not paused.
    pub fn set_paused(&self, is_paused: bool) {
        let is_shared = lock(&self.topic.receiver.state).listeners.len() > 1;
        self.topic.subscription.set_paused(is_paused && !is_shared);
        if let Some(sender) = self.sender.as_ref().filter(|_| is_paused) {
            sender.drop_queued();
        }
    }

    /// Connected publishers, unlike the master's list, which includes killed ones.
    pub fn publishing(&self) -> Publishing {
        let state = lock(&self.topic.receiver.state);
        let is_latched = state.last_sender.is_some_and(|sender| state.latched.contains_key(&sender));
        Publishing { is_connected: !state.connected.is_empty(), is_latched }
    }

    /// Names of the connected publishers.
    pub fn connected_publishers(&self) -> Vec<Arc<str>> {
        lock(&self.topic.receiver.state).connected.values().cloned().collect()
    }

    /// Sets the queue size of its messages (0: the largest).
    pub fn set_queue_size(&self, queue_size: usize) {
        if let Some(sender) = &self.sender {
            sender.set_queue_size(queue_size);
        }
    }
}

impl Drop for TopicSubscription {
    /// Drops its queued messages, and unsubscribes if there is no other listener.
    fn drop(&mut self) {
        let Some(topics) = self.topics.upgrade() else { return };
        // Locked, or a listener that is added now would have a topic that is no longer subscribed to.
        let mut topics = lock(&topics.0);
        let unused = self.topic.remove_listener(self.listener);
        if let Some(sender) = &self.sender {
            sender.drop_queued();
        }
        if unused && topics.get(&*self.topic.name).is_some_and(|topic| Arc::ptr_eq(topic, &self.topic)) {
            topics.remove(&*self.topic.name);
        }
    }
}
