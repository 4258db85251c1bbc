//! Queue of messages that wait for their frame, like tf2_ros' message filter for rviz's displays.
//!
//! A display can draw a message only where its frame is known at the message's stamp, and transforms often arrive a
//! little after the data. A message that cannot be placed yet waits until it can, or is dropped when newer ones need
//! its place in the queue or when it is older than the tree's cache. The owner calls [`WaitingQueue::take_ready`] after
//! each message and whenever [`TransformTree::generation`] has grown.
//!
//! Two things differ from tf2_ros. Messages come out in the order of their arrival, where the filter's order after a
//! transform is arbitrary. And a message with stamp zero, which stands for the latest transform, is never too old: the
//! filter compares even that stamp with the newest transforms and so loses a message that came before the first of
//! them.

use std::collections::VecDeque;

use thiserror::Error;

use crate::transform::strip_slash;
use crate::{LookupError, Time, TransformTree};

/// Messages of type `T`, each with a frame and a stamp, until they can be placed.
#[derive(Clone, Debug)]
pub struct WaitingQueue<T> {
    queue_size: usize,
    /// In the order of arrival.
    messages: VecDeque<QueuedMessage<T>>,
    /// Messages at the end of the queue that were not tried yet.
    new: usize,
    /// Messages added so far.
    added: u64,
    /// Number of the last message that could be placed.
    last_ready: u64,
    counts: DropCounts,
    last_dropped: Option<Dropped>,
    /// The dropped messages, where the owner wants them.
    dropped: Option<Vec<(T, Dropped)>>,
}

#[derive(Clone, Debug)]
struct QueuedMessage<T> {
    frame: String,
    stamp: Time,
    /// Other time at which the frame must be known; mostly the stamp.
    end: Time,
    content: T,
    /// Counts the messages from one.
    number: u64,
}

impl<T> QueuedMessage<T> {
    /// Times at which its frame must be known.
    fn times(&self) -> [Time; 2] {
        [self.stamp, self.end]
    }

    /// Reason why it cannot be placed.
    fn waits_for(&self, tree: &TransformTree, target: &str) -> Option<LookupError> {
        self.times().iter().find_map(|time| tree.lookup(target, &self.frame, *time).err())
    }
}

/// Number of dropped messages by reason.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct DropCounts {
    /// Pushed out by newer messages.
    pub queue_full: u64,
    /// Older than the tree's cache.
    pub too_old: u64,
    /// Without a frame.
    pub empty_frame: u64,
}

impl DropCounts {
    /// Sum over all reasons.
    pub fn total(&self) -> u64 {
        self.queue_full + self.too_old + self.empty_frame
    }
}

/// A dropped message.
#[derive(Clone, PartialEq, Debug, Error)]
#[error("a message in frame [{frame}] at {stamp} was dropped because {reason}")]
pub struct Dropped {
    /// The message's frame.
    pub frame: String,
    /// The message's stamp.
    pub stamp: Time,
    /// Reason.
    pub reason: DropReason,
}

/// Reason why a message was dropped.
#[derive(Clone, PartialEq, Debug, Error)]
pub enum DropReason {
    /// More messages waited than the queue holds, and this one was the oldest. With its last failed lookup; `None` if
    /// it was not tried yet.
    #[error("the queue was full{}", waited_for(.0.as_ref()))]
    QueueFull(Option<LookupError>),
    /// The tree's cache does not reach back to its stamp, so that the message can never be placed.
    #[error("it is too old to be placed in frame [{target}], whose transforms have reached {latest}")]
    TooOld {
        /// The target frame.
        target: String,
        /// The latest common time of the two frames.
        latest: Time,
    },
    /// The message has no frame.
    #[error("its frame name is empty")]
    EmptyFrame,
}

fn waited_for(reason: Option<&LookupError>) -> String {
    reason.map_or_else(String::new, |reason| format!("; it waited: {reason}"))
}

impl<T> WaitingQueue<T> {
    /// A queue in which at most `queue_size` messages wait; 0 means no limit.
    pub fn new(queue_size: usize) -> Self {
        WaitingQueue {
            queue_size,
            messages: VecDeque::new(),
            new: 0,
            added: 0,
            last_ready: 0,
            counts: DropCounts::default(),
            last_dropped: None,
            dropped: None,
        }
    }

    /// Keeps dropped messages until [`WaitingQueue::take_dropped`].
    #[must_use]
    pub fn keeping_dropped(mut self) -> Self {
        self.dropped = Some(Vec::new());
        self
    }

    /// Returns the messages dropped since the last call, in that order, each with the reason; always empty without
    /// [`WaitingQueue::keeping_dropped`].
    pub fn take_dropped(&mut self) -> Vec<(T, Dropped)> {
        self.dropped.as_mut().map(std::mem::take).unwrap_or_default()
    }

    fn note_dropped(&mut self, message: QueuedMessage<T>, reason: DropReason) {
        *match reason {
            DropReason::QueueFull(_) => &mut self.counts.queue_full,
            DropReason::TooOld { .. } => &mut self.counts.too_old,
            DropReason::EmptyFrame => &mut self.counts.empty_frame,
        } += 1;
        let dropped = Dropped { frame: message.frame, stamp: message.stamp, reason };
        if let Some(all) = &mut self.dropped {
            all.push((message.content, dropped.clone()));
        }
        self.last_dropped = Some(dropped);
    }

    /// Adds a message in `frame_id` (one leading `/` is ignored) at `stamp`.
    ///
    /// A message without a frame is dropped at once. Messages that were not tried yet do not push out those that wait,
    /// because they may be ready; but as in a subscriber's queue there are at most queue size of them, then the oldest
    /// of them is dropped.
    pub fn push(&mut self, frame_id: &str, stamp: Time, message: T) {
        self.push_until(frame_id, stamp, stamp, message);
    }

    /// Like [`WaitingQueue::push`], for a message recorded from `stamp` until `end`: its frame must be known at both,
    /// and it is too old when the older of them is.
    pub fn push_until(&mut self, frame_id: &str, stamp: Time, end: Time, message: T) {
        self.added += 1;
        let frame = strip_slash(frame_id).to_owned();
        let message = QueuedMessage { frame, stamp, end, content: message, number: self.added };
        if message.frame.is_empty() {
            return self.note_dropped(message, DropReason::EmptyFrame);
        }
        if self.queue_size != 0 && self.new >= self.queue_size {
            let oldest_new = self.messages.len().saturating_sub(self.new);
            self.new -= 1;
            if let Some(oldest) = self.messages.remove(oldest_new) {
                self.note_dropped(oldest, DropReason::QueueFull(None));
            }
        }
        self.messages.push_back(message);
        self.new += 1;
    }

    /// Returns the messages that `tree` can now place in `target`, in the order of their arrival. Of the rest it drops
    /// those that can never be placed, and the oldest beyond the queue size.
    pub fn take_ready(&mut self, tree: &TransformTree, target: &str) -> Vec<T> {
        let mut ready = Vec::new();
        for _ in 0..self.messages.len() {
            let Some(message) = self.messages.pop_front() else { break };
            if message.times().iter().all(|time| tree.can_transform(target, &message.frame, *time)) {
                self.last_ready = self.last_ready.max(message.number);
                ready.push(message.content);
            } else if let Some(latest) = forgotten_since(tree, target, &message) {
                let target = strip_slash(target).to_owned();
                self.note_dropped(message, DropReason::TooOld { target, latest });
            } else {
                self.messages.push_back(message);
            }
        }
        self.new = 0;
        while self.queue_size != 0 && self.messages.len() > self.queue_size {
            let Some(oldest) = self.messages.pop_front() else { break };
            let reason = oldest.waits_for(tree, target);
            self.note_dropped(oldest, DropReason::QueueFull(reason));
        }
        ready
    }

    /// Reason why the newest message waits; `None` when none does, or when a newer one could be placed.
    pub fn waiting_reason(&self, tree: &TransformTree, target: &str) -> Option<LookupError> {
        let newest = self.messages.back().filter(|newest| newest.number > self.last_ready)?;
        newest.waits_for(tree, target)
    }

    /// Stamps of the waiting messages, in the order of their arrival.
    pub fn stamps(&self) -> impl Iterator<Item = Time> + '_ {
        self.messages.iter().map(|message| message.stamp)
    }

    /// Number of waiting messages.
    pub fn len(&self) -> usize {
        self.messages.len()
    }

    /// `true` if no message waits.
    pub fn is_empty(&self) -> bool {
        self.messages.is_empty()
    }

    /// Number of messages dropped so far.
    pub fn dropped(&self) -> DropCounts {
        self.counts
    }

    /// The last drop and its reason, since the queue was made or cleared.
    pub fn last_dropped(&self) -> Option<&Dropped> {
        self.last_dropped.as_ref()
    }

    /// Removes all messages, for a jump in time or another target frame. The counts go on.
    pub fn clear(&mut self) {
        self.messages.clear();
        self.new = 0;
        self.last_dropped = None;
        if let Some(all) = &mut self.dropped {
            all.clear();
        }
    }
}

/// Latest common time of the message's frame and `target`, if the tree's cache no longer reaches back from there to the
/// message's stamp.
fn forgotten_since<T>(tree: &TransformTree, target: &str, message: &QueuedMessage<T>) -> Option<Time> {
    if message.stamp.is_zero() {
        return None;
    }
    let latest = tree.latest_common_time(target, &message.frame).ok()?;
    let is_forgotten = message.stamp.min(message.end).saturating_add(tree.cache_length()) < latest;
    (is_forgotten && !latest.is_zero()).then_some(latest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LookupProblem, RawTransform};

    fn at(secs: u32) -> Time {
        Time::from_secs_nanos(secs, 0)
    }

    fn place(tree: &mut TransformTree, child: &str, secs: u32) {
        let transform = RawTransform {
            parent: "map",
            child,
            stamp: at(secs),
            translation: [1.0, 0.0, 0.0],
            rotation_xyzw: [0.0, 0.0, 0.0, 1.0],
        };
        tree.insert(&transform, false, "/a").unwrap();
    }

    #[test]
    fn messages_wait_for_their_stamp_and_come_in_the_order_of_arrival() {
        let mut tree = TransformTree::new();
        let mut queue = WaitingQueue::new(5);
        for (secs, name) in [(12, "late"), (11, "early"), (14, "future")] {
            queue.push("laser", at(secs), name);
        }
        assert!(queue.take_ready(&tree, "map").is_empty());
        let reason = queue.waiting_reason(&tree, "map").unwrap().to_string();
        assert!(reason.contains("[map]") && reason.contains("[laser]"), "{reason}");

        place(&mut tree, "laser", 10);
        place(&mut tree, "laser", 13);
        assert_eq!(queue.take_ready(&tree, "map"), ["late", "early"]);
        assert_eq!(queue.len(), 1);
        let reason = queue.waiting_reason(&tree, "map");
        assert!(matches!(reason.unwrap().problem, LookupProblem::Extrapolation { .. }));

        place(&mut tree, "laser", 14);
        assert_eq!(queue.take_ready(&tree, "map"), ["future"]);
        assert!(queue.is_empty());
        assert_eq!(queue.waiting_reason(&tree, "map"), None);
        assert_eq!(queue.dropped().total(), 0);
    }

    #[test]
    fn a_message_of_some_duration_waits_for_both_of_its_ends() {
        let mut tree = TransformTree::new();
        let mut queue = WaitingQueue::new(5);
        place(&mut tree, "laser", 10);
        place(&mut tree, "laser", 12);
        queue.push_until("laser", at(11), at(13), "later");
        queue.push_until("laser", at(11), at(9), "earlier");
        assert!(queue.take_ready(&tree, "map").is_empty());
        let reason = queue.waiting_reason(&tree, "map").unwrap();
        assert!(
            matches!(reason.problem, LookupProblem::Extrapolation { requested, .. } if requested == at(9)),
            "{reason}"
        );
        place(&mut tree, "laser", 13);
        assert_eq!(queue.take_ready(&tree, "map"), ["later"]);
        place(&mut tree, "laser", 20);
        assert!(queue.take_ready(&tree, "map").is_empty());
        assert_eq!((queue.len(), queue.dropped().too_old), (0, 1));
    }

    #[test]
    fn a_message_that_waits_is_no_reason_to_report_once_a_newer_one_was_placed() {
        let mut tree = TransformTree::new();
        let mut queue = WaitingQueue::new(5);
        place(&mut tree, "laser", 10);
        queue.push("laserr", Time::ZERO, "misspelt");
        assert!(queue.take_ready(&tree, "map").is_empty());
        assert!(matches!(queue.waiting_reason(&tree, "map").unwrap().problem, LookupProblem::MissingFrame(_)));
        queue.push("laser", at(10), "good");
        assert_eq!(queue.take_ready(&tree, "map"), ["good"]);
        assert!(queue.take_ready(&tree, "map").is_empty());
        assert_eq!((queue.len(), queue.waiting_reason(&tree, "map")), (1, None));
        queue.push("laser", at(11), "late");
        assert!(queue.take_ready(&tree, "map").is_empty());
        assert!(matches!(queue.waiting_reason(&tree, "map").unwrap().problem, LookupProblem::Extrapolation { .. }));
    }

    #[test]
    fn a_message_in_the_target_frame_needs_no_transform() {
        let mut queue = WaitingQueue::new(1);
        queue.push("/map", at(12), ());
        assert_eq!(queue.take_ready(&TransformTree::new(), "map").len(), 1);
    }

    #[test]
    fn dropped_messages_are_handed_back_when_asked_for() {
        let mut tree = TransformTree::new();
        let mut queue = WaitingQueue::new(1).keeping_dropped();
        queue.push("", at(11), "nowhere");
        queue.push("laser", at(11), "first");
        queue.push("laser", at(12), "second");
        place(&mut tree, "laser", 40);
        assert!(queue.take_ready(&tree, "map").is_empty());
        let dropped = queue.take_dropped();
        let names: Vec<&str> = dropped.iter().map(|(name, _)| *name).collect();
        assert_eq!(names, ["nowhere", "first", "second"]);
        assert!(matches!(dropped[2].1.reason, DropReason::TooOld { .. }));
        assert!(queue.take_dropped().is_empty());
    }

    #[test]
    fn when_too_many_wait_the_oldest_is_dropped() {
        let mut tree = TransformTree::new();
        let mut queue = WaitingQueue::new(2);
        for secs in 11..=14 {
            queue.push("laser", at(secs), secs);
            assert!(queue.take_ready(&tree, "map").is_empty());
        }
        assert_eq!(queue.len(), 2);
        assert_eq!(queue.dropped().queue_full, 2);
        let text = queue.last_dropped().unwrap().to_string();
        for part in ["[laser]", "12.000000000", "queue was full", "[map]", "does not exist"] {
            assert!(text.contains(part), "{text}");
        }
        place(&mut tree, "laser", 10);
        place(&mut tree, "laser", 20);
        assert_eq!(queue.take_ready(&tree, "map"), [13, 14]);
    }

    #[test]
    fn a_message_that_is_ready_on_arrival_pushes_none_out() {
        let mut tree = TransformTree::new();
        place(&mut tree, "laser", 10);
        let mut queue = WaitingQueue::new(1);
        queue.push("laser", at(11), "waits");
        assert!(queue.take_ready(&tree, "map").is_empty());
        queue.push("laser", at(10), "ready");
        assert_eq!(queue.take_ready(&tree, "map"), ["ready"]);
        assert_eq!((queue.len(), queue.dropped().total()), (1, 0));
    }

    #[test]
    fn messages_that_nobody_asks_for_do_not_pile_up() {
        let mut tree = TransformTree::new();
        let mut queue = WaitingQueue::new(2);
        queue.push("laser", at(10), 10);
        assert!(queue.take_ready(&tree, "map").is_empty());
        for secs in 11..100 {
            queue.push("laser", at(secs), secs);
        }
        assert_eq!(queue.len(), 3, "one that waited and two new ones");
        assert_eq!(queue.dropped().queue_full, 87);
        place(&mut tree, "laser", 99);
        assert_eq!(queue.take_ready(&tree, "map"), [99]);
    }

    #[test]
    fn queue_size_zero_sets_no_limit() {
        let tree = TransformTree::new();
        let mut queue = WaitingQueue::new(0);
        for secs in 0..1000 {
            queue.push("laser", at(secs), secs);
        }
        assert!(queue.take_ready(&tree, "map").is_empty());
        assert_eq!(queue.len(), 1000);
    }

    #[test]
    fn a_message_older_than_the_cache_is_dropped() {
        let mut tree = TransformTree::new();
        let mut queue = WaitingQueue::new(5);
        place(&mut tree, "laser", 20);
        queue.push("laser", at(9), "too old");
        queue.push("laser", at(10), "may still come");
        assert!(queue.take_ready(&tree, "map").is_empty());
        assert_eq!((queue.len(), queue.dropped().too_old), (1, 1));
        let text = queue.last_dropped().unwrap().to_string();
        for part in ["[laser]", "[map]", "9.000000000", "20.000000000", "too old"] {
            assert!(text.contains(part), "{text}");
        }
        // And one that waited grows too old as time goes by.
        place(&mut tree, "laser", 21);
        assert!(queue.take_ready(&tree, "map").is_empty());
        assert_eq!((queue.len(), queue.dropped().too_old), (0, 2));
    }

    #[test]
    fn stamp_zero_means_latest_and_is_never_too_old() {
        let mut tree = TransformTree::new();
        let mut queue = WaitingQueue::new(5);
        queue.push("laser", Time::ZERO, "latched");
        assert!(queue.take_ready(&tree, "map").is_empty());
        place(&mut tree, "laser", 1_700_000_000);
        assert_eq!(queue.take_ready(&tree, "map"), ["latched"]);
    }

    #[test]
    fn a_message_without_a_frame_is_dropped_with_that_reason() {
        let mut queue = WaitingQueue::new(5);
        for frame in ["", "/"] {
            queue.push(frame, at(3), ());
        }
        assert!(queue.is_empty());
        assert_eq!(queue.dropped().empty_frame, 2);
        let text = queue.last_dropped().unwrap().to_string();
        assert!(text.contains("frame name is empty"), "{text}");
    }

    #[test]
    fn clearing_forgets_the_messages() {
        let mut tree = TransformTree::new();
        let mut queue = WaitingQueue::new(1);
        queue.push("", at(9), "nowhere");
        queue.push("laser", at(9), "before the jump");
        queue.clear();
        assert!(queue.last_dropped().is_none());
        place(&mut tree, "laser", 9);
        assert!(queue.take_ready(&tree, "map").is_empty());
        assert_eq!(queue.dropped().total(), 1);
    }
}
