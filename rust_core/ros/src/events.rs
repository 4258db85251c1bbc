//! Queues of received events: [`NodeEvent`]s change the scene, [`ServiceCall`]s are to be answered at once.

use crate::settings::NamedValues;
use rcs_messages::dynamic_reconfigure::Config;
use rcs_messages::tf2_msgs::TFMessage;
use rcs_messages::{AnyMessage, Time};
use rcs_process::lock;
use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{sync_channel, Receiver, SyncSender};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// An event on the network.
#[derive(Debug)]
pub enum NodeEvent {
    /// A message of a subscribed topic.
    Message {
        /// Whole name of the topic, after remapping.
        topic: Arc<str>,
        /// The message.
        message: AnyMessage,
        /// Name of the sending node.
        publisher: Arc<str>,
        /// Time of reception, before decoding.
        received: Instant,
    },
    /// Transforms of `/tf` or `/tf_static`.
    Transforms {
        /// Transforms as sent.
        message: Arc<TFMessage>,
        /// `true` if they hold for all times.
        is_static: bool,
        /// Name of the sending node.
        authority: Arc<str>,
        /// Time of reception, before decoding.
        received: Instant,
    },
    /// The simulated time jumped back.
    TimeJumpedBack {
        /// Time before the jump.
        from: Time,
        /// Time after the jump.
        to: Time,
    },
    /// A followed parameter was read.
    Parameter {
        /// Name as given.
        name: Arc<str>,
        /// Value; `None` while it is not set.
        text: Option<Arc<str>>,
    },
    /// A publisher of a subscribed topic has unregistered.
    PublisherLeft {
        /// Whole name of the topic, after remapping.
        topic: Arc<str>,
    },
}

/// A call of one of the node's services.
#[derive(Debug)]
pub enum ServiceCall {
    /// Call of a trigger service.
    Trigger {
        /// Whole name of the service.
        service: Arc<str>,
        /// Whole name of the calling node.
        caller: Arc<str>,
        /// Sends the answer.
        reply: TriggerReply,
    },
    /// Call of a service that switches something on or off.
    SetBool {
        /// Whole name of the service.
        service: Arc<str>,
        /// On or off.
        value: bool,
        /// Whole name of the calling node.
        caller: Arc<str>,
        /// Sends the answer.
        reply: TriggerReply,
    },
    /// Call of a service of rviz's that loads or saves a file.
    FilePath {
        /// Whole name of the service.
        service: Arc<str>,
        /// Path of the file.
        path: PathBuf,
        /// Whole name of the calling node.
        caller: Arc<str>,
        /// Answers whether it was loaded or saved.
        reply: Reply<bool>,
    },
    /// Call that sets parameters of a dynamic_reconfigure server.
    Reconfigure {
        /// Whole name of the server.
        server: Arc<str>,
        /// Settings to be changed, some or all.
        request: NamedValues,
        /// Whole name of the calling node.
        caller: Arc<str>,
        /// Answers with the values that apply then.
        reply: Reply<Config>,
    },
}

/// Answers a service call; dropped unused, it causes an error.
#[derive(Debug)]
pub struct Reply<T>(SyncSender<T>);

/// Answers a call of a trigger or a switch service: success and message.
pub type TriggerReply = Reply<(bool, String)>;

impl<T> Reply<T> {
    pub(crate) fn new() -> (Self, Receiver<T>) {
        let (sender, receiver) = sync_channel(1);
        (Self(sender), receiver)
    }

    /// Answers the caller.
    pub fn answer(self, answer: T) {
        // Fails if the caller has given up.
        let _ = self.0.try_send(answer);
    }
}

impl TriggerReply {
    /// Answers the caller.
    pub fn send(self, success: bool, message: impl Into<String>) {
        self.answer((success, message.into()));
    }
}

/// Queue of events in the order of arrival.
#[derive(Debug)]
pub struct EventQueue<E = NodeEvent> {
    state: Mutex<State<E>>,
    changed: Condvar,
    next_id: AtomicU64,
}

#[derive(Debug)]
struct State<E> {
    queued: VecDeque<(u64, E)>,
    woken: bool,
}

impl<E> Default for EventQueue<E> {
    fn default() -> Self {
        let state = State { queued: VecDeque::new(), woken: false };
        Self { state: Mutex::new(state), changed: Condvar::new(), next_id: AtomicU64::new(0) }
    }
}

/// Largest number of queued events of a source.
const MOST_QUEUED: usize = 10_000;

/// Queues the events of a source, up to a number of them.
#[derive(Debug)]
pub struct EventSender<E = NodeEvent> {
    queue: Arc<EventQueue<E>>,
    id: u64,
    queue_size: Arc<AtomicUsize>,
}

impl<E> Clone for EventSender<E> {
    fn clone(&self) -> Self {
        Self { queue: Arc::clone(&self.queue), id: self.id, queue_size: Arc::clone(&self.queue_size) }
    }
}

impl<E> EventSender<E> {
    /// Adds an event and wakes the reader. The sender's oldest event is dropped if its queue size is reached. Never
    /// waits.
    pub fn push(&self, event: E) {
        let mut state = lock(&self.queue.state);
        let queue_size = self.queue_size.load(Ordering::Relaxed);
        // Events are counted only when the queue could be full of them.
        if state.queued.len() >= queue_size {
            let mine = || state.queued.iter().enumerate().filter(|(_, (id, _))| *id == self.id);
            let (count, oldest) = (mine().count(), mine().next().map(|(index, _)| index));
            if let (true, Some(index)) = (count >= queue_size, oldest) {
                state.queued.remove(index);
            }
        }
        state.queued.push_back((self.id, event));
        drop(state);
        self.queue.changed.notify_all();
    }

    /// Sets the queue size (0: 10,000, the largest), which clones share.
    pub fn set_queue_size(&self, queue_size: usize) {
        self.queue_size.store(bounded(queue_size), Ordering::Relaxed);
    }

    /// Drops its queued events.
    pub(crate) fn drop_queued(&self) {
        lock(&self.queue.state).queued.retain(|(id, _)| *id != self.id);
    }
}

/// A queue size within the bounds; 0 means the largest.
fn bounded(queue_size: usize) -> usize {
    if queue_size == 0 {
        MOST_QUEUED
    } else {
        queue_size.min(MOST_QUEUED)
    }
}

impl<E> EventQueue<E> {
    /// A new source, of whose events at most `queue_size` are queued (0: 10,000, the largest).
    pub fn sender(self: &Arc<Self>, queue_size: usize) -> EventSender<E> {
        let id = self.next_id.fetch_add(1, Ordering::Relaxed);
        EventSender { queue: Arc::clone(self), id, queue_size: Arc::new(bounded(queue_size).into()) }
    }

    /// Waits for events, a [`wake`](Self::wake) or `timeout`, and takes all queued events.
    pub fn wait(&self, timeout: Duration) -> Vec<E> {
        let idle = |state: &mut State<E>| state.queued.is_empty() && !state.woken;
        let waited = self.changed.wait_timeout_while(lock(&self.state), timeout, idle);
        let mut state = waited.unwrap_or_else(PoisonError::into_inner).0;
        state.woken = false;
        state.queued.drain(..).map(|(_, event)| event).collect()
    }

    /// Takes all queued events if there is one of a kind among them. Never waits.
    pub fn drain_if(&self, is_wanted: impl Fn(&E) -> bool) -> Vec<E> {
        let mut state = lock(&self.state);
        let count = if state.queued.iter().any(|(_, event)| is_wanted(event)) { state.queued.len() } else { 0 };
        state.queued.drain(..count).map(|(_, event)| event).collect()
    }

    /// Takes all queued events.
    pub fn drain(&self) -> Vec<E> {
        lock(&self.state).queued.drain(..).map(|(_, event)| event).collect()
    }

    /// Ends the present or the next [`wait`](Self::wait).
    pub fn wake(&self) {
        lock(&self.state).woken = true;
        self.changed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn jump(sec: u32) -> NodeEvent {
        NodeEvent::TimeJumpedBack { from: Time::default(), to: Time { sec, nsec: 0 } }
    }

    fn secs(events: Vec<NodeEvent>) -> Vec<u32> {
        let sec = |event| match event {
            NodeEvent::TimeJumpedBack { to, .. } => to.sec,
            other => panic!("{other:?}"),
        };
        events.into_iter().map(sec).collect()
    }

    #[test]
    fn a_full_queue_drops_the_oldest_event_of_the_same_source() {
        let queue = Arc::<EventQueue>::default();
        let (small, large) = (queue.sender(2), queue.sender(0));
        large.push(jump(1));
        for sec in 10..14 {
            small.push(jump(sec));
        }
        large.push(jump(2));
        assert_eq!(secs(queue.drain()), [1, 12, 13, 2]);
        assert!(queue.drain().is_empty());
        small.set_queue_size(1);
        small.push(jump(14));
        small.push(jump(15));
        assert_eq!(secs(queue.drain()), [15]);
    }

    #[test]
    fn waiting_ends_with_an_event_a_wake_or_the_timeout() {
        let queue = Arc::<EventQueue>::default();
        assert!(queue.wait(Duration::from_millis(1)).is_empty());
        queue.wake();
        assert!(queue.wait(Duration::from_secs(60)).is_empty());
        let sender = queue.sender(1);
        let pushing = std::thread::spawn(move || sender.push(jump(3)));
        assert_eq!(secs(queue.wait(Duration::from_secs(60))), [3]);
        pushing.join().unwrap();
    }

    #[test]
    fn events_stay_queued_until_one_of_a_kind_is_among_them() {
        let queue = Arc::<EventQueue>::default();
        let sender = queue.sender(0);
        let is_seven = |event: &NodeEvent| matches!(event, NodeEvent::TimeJumpedBack { to: Time { sec: 7, .. }, .. });
        assert!(queue.drain_if(is_seven).is_empty());
        sender.push(jump(3));
        assert!(queue.drain_if(is_seven).is_empty());
        sender.push(jump(7));
        sender.push(jump(4));
        assert_eq!(secs(queue.drain_if(is_seven)), [3, 7, 4]);
        assert!(queue.drain().is_empty());
    }

    #[test]
    fn the_queued_events_of_one_source_are_dropped() {
        let queue = Arc::<EventQueue>::default();
        let (gone, stays) = (queue.sender(0), queue.sender(0));
        gone.push(jump(1));
        stays.push(jump(2));
        gone.drop_queued();
        assert_eq!(secs(queue.drain()), [2]);
    }

    #[test]
    fn a_reply_that_is_dropped_is_noticed() {
        let (reply, answer) = TriggerReply::new();
        drop(reply);
        assert!(answer.recv().is_err());
    }
}
