//! A topic that the node publishes, and the handle to publish on it.

use crate::header::Header;
use crate::link::Link;
use crate::node::Inner;
use crate::TypeInfo;
use std::net::TcpStream;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

/// A serialised message in two parts, without the length before them; either may be empty. Cloning shares the bytes.
///
/// Two parts, so that a big body that many messages share (the pixels of an unchanged picture) is never copied.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// The first bytes.
    pub head: Arc<Vec<u8>>,
    /// The bytes after them.
    pub body: Arc<Vec<u8>>,
}

impl Frame {
    /// A message in one part.
    pub fn whole(bytes: Vec<u8>) -> Self {
        Self { head: Arc::new(bytes), body: Arc::default() }
    }

    /// Bytes of both parts.
    pub fn len(&self) -> usize {
        self.head.len() + self.body.len()
    }

    /// Whether the message has no bytes at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

type ConnectHandler = Box<dyn Fn(&str) + Send + Sync>;

/// How a topic is published.
#[derive(Default)]
pub struct PublisherOptions {
    /// Whether a new subscriber gets the last message.
    pub latch: bool,
    /// How many messages wait for a slow subscriber; 0 counts as 1.
    pub queue_size: usize,
    /// Called with the name of each new subscriber, on a thread of its own connection. Must not wait long.
    pub on_connect: Option<ConnectHandler>,
}

pub(crate) struct Publication {
    pub(crate) topic: String,
    pub(crate) type_info: TypeInfo,
    options: PublisherOptions,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    links: Vec<Arc<Link>>,
    last: Option<Frame>,
    closed: bool,
}

impl Publication {
    pub(crate) fn new(topic: String, type_info: TypeInfo, options: PublisherOptions) -> Self {
        Self { topic, type_info, options, state: Mutex::default() }
    }

    /// Serves a subscriber, whose header was read, until the connection ends.
    pub(crate) fn serve(self: &Arc<Self>, node_name: &str, mut stream: TcpStream, request: &Header) {
        let caller_id = request.get("callerid").unwrap_or("unknown");
        if let Err(reason) = request.check_type(&self.type_info) {
            log::warn!("{caller_id} cannot subscribe to {}: {reason}", self.topic);
            // It may be gone already.
            let _ = Header::new([("error", reason.as_str())]).write(&mut stream);
            return;
        }
        let answer = Header::new([
            ("callerid", node_name),
            ("latching", if self.options.latch { "1" } else { "0" }),
            ("md5sum", &self.type_info.md5sum),
            ("message_definition", &self.type_info.definition),
            ("topic", &self.topic),
            ("type", &self.type_info.name),
        ]);
        if answer.write(&mut stream).is_err() || stream.set_read_timeout(None).is_err() {
            return;
        }
        let link = Arc::new(Link::new(caller_id, stream));
        {
            let mut state = self.lock();
            if state.closed {
                return;
            }
            if let (true, Some(frame)) = (self.options.latch, &state.last) {
                link.send(frame, 1);
            }
            state.links.push(Arc::clone(&link));
        }
        let writer = Arc::clone(&link);
        let spawned = std::thread::Builder::new().name("ros-publish".to_owned()).spawn(move || writer.write_frames());
        if spawned.is_ok() {
            if let Some(on_connect) = &self.options.on_connect {
                on_connect(caller_id);
            }
            link.wait_for_end();
        }
        self.lock().links.retain(|other| !Arc::ptr_eq(other, &link));
    }

    pub(crate) fn send(&self, frame: &Frame) {
        let mut state = self.lock();
        if self.options.latch {
            state.last = Some(frame.clone());
        }
        for link in &state.links {
            link.send(frame, self.options.queue_size);
        }
    }

    pub(crate) fn subscribers(&self) -> Vec<String> {
        self.lock().links.iter().map(|link| link.caller_id.clone()).collect()
    }

    pub(crate) fn close(&self) {
        let mut state = self.lock();
        state.closed = true;
        for link in state.links.drain(..) {
            link.close();
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Publishes on one topic until it is dropped.
pub struct Publisher {
    pub(crate) publication: Arc<Publication>,
    pub(crate) node: Weak<Inner>,
}

impl Publisher {
    /// The topic's whole name.
    pub fn topic(&self) -> &str {
        &self.publication.topic
    }

    /// Sends a message to all subscribers. Never waits for any of them.
    pub fn publish(&self, frame: &Frame) {
        self.publication.send(frame);
    }

    /// How many subscribers are connected.
    pub fn subscriber_count(&self) -> usize {
        self.publication.lock().links.len()
    }

    /// The names of the connected subscribers.
    pub fn subscribers(&self) -> Vec<String> {
        self.publication.subscribers()
    }
}

impl Drop for Publisher {
    fn drop(&mut self) {
        if let Some(node) = self.node.upgrade() {
            node.remove_publication(&self.publication);
        }
    }
}
