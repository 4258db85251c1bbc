//! One subscribed topic: one rosrust subscriber for all listeners of the process.
//!
//! rosrust unregisters a topic from the master as soon as any of its subscribers is dropped, so there is only ever one.
//! A listener that is added later gets the latched messages, as a new subscriber does from roscpp.

use crate::node::Shared;
use crate::{lock, EventSender, NodeError};
use rcs_messages::{AnyMessage, Message, MessageKind, MessageVisitor, Serialized};
use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex, TryLockError, Weak};
use std::time::{Duration, Instant};

/// How many messages wait between rosrust's threads; the listeners have queues of their own behind that.
const RECEIVE_QUEUE_SIZE: usize = 1000;
/// For the big messages, each of which may be megabytes.
const BIG_RECEIVE_QUEUE_SIZE: usize = 2;
/// How often one topic's undecodable messages are logged.
const WARN_PERIOD: Duration = Duration::from_secs(5);

/// Called with the topic's name and a message.
type Listener = Box<dyn Fn(&Arc<str>, &Received<'_>) + Send + Sync>;

/// A message as listeners get it.
pub(crate) struct Received<'a> {
    pub(crate) message: &'a AnyMessage,
    /// The publisher's name.
    pub(crate) publisher: &'a Arc<str>,
    /// When rosrust handed its bytes over; for a latched message, when the listener was added.
    pub(crate) at: Instant,
}

pub(crate) struct Topic {
    name: Arc<str>,
    /// The name before remapping, for rosrust remaps it itself.
    given_name: String,
    kind: MessageKind,
    own_name: String,
    subscriber: Mutex<Option<rosrust::Subscriber>>,
    receiver: Arc<Receiver>,
}

/// What rosrust's threads need of a topic.
struct Receiver {
    name: Arc<str>,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    listeners: BTreeMap<u64, Arc<Listener>>,
    next_listener: u64,
    /// The last message of each latching publisher; none before it has sent one.
    latched: HashMap<Arc<str>, Option<AnyMessage>>,
    warned: Option<Instant>,
}

impl Topic {
    pub(crate) fn new(name: &str, given_name: &str, kind: MessageKind, own_name: &str) -> Self {
        let name: Arc<str> = name.into();
        Self {
            name: Arc::clone(&name),
            given_name: given_name.to_owned(),
            kind,
            own_name: own_name.to_owned(),
            subscriber: Mutex::default(),
            receiver: Arc::new(Receiver { name, state: Mutex::default() }),
        }
    }

    pub(crate) fn name(&self) -> &Arc<str> {
        &self.name
    }

    pub(crate) fn check_kind(&self, wanted: MessageKind) -> Result<(), NodeError> {
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
    pub(crate) fn add_listener(&self, listener: Listener) -> u64 {
        let (mut state, at) = (lock(&self.receiver.state), Instant::now());
        for (publisher, message) in &state.latched {
            if let Some(message) = message {
                listener(&self.name, &Received { message, publisher, at });
            }
        }
        let id = state.next_listener;
        state.next_listener += 1;
        state.listeners.insert(id, Arc::new(listener));
        id
    }

    /// Removes a listener; true if none is left.
    fn remove_listener(&self, id: u64) -> bool {
        let mut state = lock(&self.receiver.state);
        state.listeners.remove(&id);
        state.listeners.is_empty()
    }

    /// Whether it is being subscribed to or unsubscribed right now.
    pub(crate) fn is_busy(&self) -> bool {
        matches!(self.subscriber.try_lock(), Err(TryLockError::WouldBlock))
    }

    /// Whether it is subscribed to, or being subscribed to.
    pub(crate) fn is_open(&self) -> bool {
        match self.subscriber.try_lock() {
            Ok(subscriber) => subscriber.is_some(),
            Err(_) => true,
        }
    }

    /// Subscribes, unless it is subscribed to already.
    pub(crate) fn open(&self) -> Result<(), NodeError> {
        let mut subscriber = lock(&self.subscriber);
        if subscriber.is_none() {
            *subscriber = Some(self.subscribe()?);
        }
        Ok(())
    }

    /// Unsubscribes.
    pub(crate) fn close(&self) {
        // Dropped without the lock: it waits for the master.
        let subscriber = lock(&self.subscriber).take();
        drop(subscriber);
    }

    fn subscribe(&self) -> Result<rosrust::Subscriber, NodeError> {
        let queue_size = match self.kind {
            MessageKind::PointCloud2 | MessageKind::Image => BIG_RECEIVE_QUEUE_SIZE,
            _ => RECEIVE_QUEUE_SIZE,
        };
        let (kind, own_name) = (self.kind, self.own_name.clone());
        let (of_messages, of_connections) = (Arc::clone(&self.receiver), Arc::clone(&self.receiver));
        let on_message = move |bytes, publisher: &str| {
            // A node that publishes what it subscribes to does not listen to itself.
            if publisher != own_name {
                of_messages.take(kind, bytes, publisher);
            }
        };
        let on_connect = move |header| of_connections.connected(&header);
        kind.visit(Subscribe { topic: &self.given_name, queue_size, on_message, on_connect })
            .map_err(|error| NodeError::ros(format!("cannot subscribe to {}", self.name), &error))
    }
}

/// Subscribes to a topic of the visited type on the running rosrust node.
struct Subscribe<'a, M, C> {
    topic: &'a str,
    queue_size: usize,
    /// Gets each message's bytes and the publisher's name, on a thread of the subscription.
    on_message: M,
    /// Gets the header of each new connection, on a thread of the subscription.
    on_connect: C,
}

impl<M, C> MessageVisitor for Subscribe<'_, M, C>
where
    M: Fn(Vec<u8>, &str) + Send + 'static,
    C: Fn(HashMap<String, String>) + Send + 'static,
{
    type Output = rosrust::api::error::Result<rosrust::Subscriber>;

    fn visit<T: Message>(self) -> Self::Output {
        let Self { topic, queue_size, on_message, on_connect } = self;
        let on_message = move |message: Serialized<T>, publisher: &str| on_message(message.bytes, publisher);
        rosrust::subscribe_with_ids_and_headers(topic, queue_size, on_message, on_connect)
    }
}

impl Receiver {
    fn connected(&self, header: &HashMap<String, String>) {
        let publisher: Arc<str> = header.get("callerid").map_or("", String::as_str).into();
        let latching = header.get("latching").is_some_and(|value| value == "1");
        let mut state = lock(&self.state);
        if latching {
            state.latched.entry(publisher).or_default();
        } else {
            state.latched.remove(&publisher);
        }
    }

    fn take(&self, kind: MessageKind, bytes: Vec<u8>, publisher: &str) {
        let at = Instant::now();
        let publisher: Arc<str> = publisher.into();
        let decoded = kind.decode_owned(bytes);
        let mut state = lock(&self.state);
        match decoded {
            Ok(message) => {
                if let Some(latched) = state.latched.get_mut(&publisher) {
                    *latched = Some(message.clone());
                }
                for listener in state.listeners.values() {
                    listener(&self.name, &Received { message: &message, publisher: &publisher, at });
                }
            }
            Err(error) => {
                if state.warned.is_none_or(|last| last.elapsed() >= WARN_PERIOD) {
                    log::warn!("{}: message of {publisher} dropped: {error}", self.name);
                    state.warned = Some(Instant::now());
                }
            }
        }
    }
}

/// Keeps a topic subscribed until it is dropped.
pub struct TopicSubscription {
    topic: Arc<Topic>,
    listener: u64,
    sender: Option<EventSender>,
    node: Weak<Shared>,
}

impl TopicSubscription {
    pub(crate) fn new(topic: Arc<Topic>, listener: u64, sender: Option<EventSender>, node: &Arc<Shared>) -> Self {
        Self { topic, listener, sender, node: Arc::downgrade(node) }
    }

    /// The topic's whole name, after remapping: the one that its events carry.
    pub fn topic(&self) -> &Arc<str> {
        &self.topic.name
    }

    /// How many of its messages the event queue holds from now on (0: any number).
    pub fn set_queue_size(&self, queue_size: usize) {
        if let Some(sender) = &self.sender {
            sender.set_queue_size(queue_size);
        }
    }
}

impl Drop for TopicSubscription {
    /// Drops its queued messages, and unsubscribes if there is no other listener.
    fn drop(&mut self) {
        let unused = self.topic.remove_listener(self.listener);
        let Some(node) = self.node.upgrade() else {
            return;
        };
        if let Some(sender) = &self.sender {
            sender.drop_queued();
        }
        if unused {
            self.topic.close();
            let mut topics = node.topics();
            if topics.get(&*self.topic.name).is_some_and(|topic| Arc::ptr_eq(topic, &self.topic)) {
                topics.remove(&*self.topic.name);
            }
        }
    }
}
