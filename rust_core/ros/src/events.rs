//! The queues between the threads that receive and those that act on it, and what is in them: [`NodeEvent`]s change
//! the scene, [`ServiceCall`]s are to be answered at once.

use rcs_messages::dynamic_reconfigure::Config;
use rcs_messages::tf2_msgs::TFMessage;
use rcs_messages::{AnyMessage, Time};
use rcs_scene::lock;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{sync_channel, Receiver, SyncSender};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Something that happened on the network.
#[derive(Debug)]
pub enum NodeEvent {
    /// A message of a subscribed topic.
    Message {
        /// The topic's whole name, after remapping.
        topic: Arc<str>,
        /// The message.
        message: AnyMessage,
        /// Name of the node that sent it.
        publisher: Arc<str>,
        /// When its bytes were there, before it was decoded.
        received: Instant,
    },
    /// Transforms of `/tf` or `/tf_static`.
    Transforms {
        /// The transforms, as sent.
        message: Arc<TFMessage>,
        /// Whether they hold for all times.
        is_static: bool,
        /// Name of the node that sent them.
        authority: Arc<str>,
        /// When their bytes were there, before they were decoded.
        received: Instant,
    },
    /// The simulation's time went back.
    TimeJumpedBack {
        /// The latest time before.
        from: Time,
        /// The time now.
        to: Time,
    },
    /// A parameter that is followed, see [`RosNode::follow_parameters`](crate::RosNode::follow_parameters).
    Parameter {
        /// Its name, as given.
        name: Arc<str>,
        /// Its value; none while it is not set.
        text: Option<Arc<str>>,
    },
    /// A publisher of a subscribed topic is not registered any more.
    PublisherLeft {
        /// The topic's whole name, after remapping.
        topic: Arc<str>,
    },
}

/// A call of one of the node's services, to be answered.
#[derive(Debug)]
pub enum ServiceCall {
    /// Somebody called a trigger service.
    Trigger {
        /// The service's whole name.
        service: Arc<str>,
        /// To be answered.
        reply: TriggerReply,
    },
    /// Somebody sets parameters of a [`ReconfigureServer`](crate::ReconfigureServer).
    Reconfigure {
        /// The server's whole name.
        server: Arc<str>,
        /// The parameters to be set; some or all.
        request: Config,
        /// To be answered with the values that hold then.
        reply: Reply<Config>,
    },
}

/// Answers a service call. If it is dropped unused, the caller gets an error.
#[derive(Debug)]
pub struct Reply<T>(SyncSender<T>);

/// Answers a call of a trigger service: success and message.
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

/// Events in the order of their arrival.
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

/// No source has more events than that in a queue.
const MOST_QUEUED: usize = 10_000;

/// Puts one source's events into a queue, which holds at most so many of them at a time.
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
    /// Adds an event and wakes the queue's reader. If `queue_size` events of this sender are queued already, the oldest
    /// of them is dropped. Never waits.
    pub fn push(&self, event: E) {
        let mut state = lock(&self.queue.state);
        let queue_size = self.queue_size.load(Ordering::Relaxed);
        // Counting is only worth it once the queue could be full of them.
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

    /// How many of its events may be queued from now on (0: 10,000, which is the most). Clones share this.
    pub fn set_queue_size(&self, queue_size: usize) {
        self.queue_size.store(bounded(queue_size), Ordering::Relaxed);
    }

    /// Drops those of its events that are queued.
    pub(crate) fn drop_queued(&self) {
        lock(&self.queue.state).queued.retain(|(id, _)| *id != self.id);
    }
}

/// A queue size within the bounds; 0 stands for the largest.
fn bounded(queue_size: usize) -> usize {
    if queue_size == 0 {
        MOST_QUEUED
    } else {
        queue_size.min(MOST_QUEUED)
    }
}

impl<E> EventQueue<E> {
    /// A new source of events, of which at most `queue_size` are queued (0: 10,000, which is the most).
    pub fn sender(self: &Arc<Self>, queue_size: usize) -> EventSender<E> {
        let id = self.next_id.fetch_add(1, Ordering::Relaxed);
        EventSender { queue: Arc::clone(self), id, queue_size: Arc::new(bounded(queue_size).into()) }
    }

    /// Waits until there are events, [`wake`](Self::wake) is called or `timeout` is over; takes all queued events.
    pub fn wait(&self, timeout: Duration) -> Vec<E> {
        let idle = |state: &mut State<E>| state.queued.is_empty() && !state.woken;
        let waited = self.changed.wait_timeout_while(lock(&self.state), timeout, idle);
        let mut state = waited.unwrap_or_else(PoisonError::into_inner).0;
        state.woken = false;
        state.queued.drain(..).map(|(_, event)| event).collect()
    }

    /// Takes all queued events.
    pub fn drain(&self) -> Vec<E> {
        lock(&self.state).queued.drain(..).map(|(_, event)| event).collect()
    }

    /// Makes the present or the next [`wait`](Self::wait) return at once.
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
