//! Messages that wait until their frame is known, with rviz's statuses for that.

use std::sync::Arc;

use rcs_messages::std_msgs::Header;
use rcs_transforms::{Time, WaitingQueue};

use crate::frame;
use crate::world::stamp;
use crate::{Level, Statuses, World};

/// The messages of one topic between their arrival and the moment when they can be placed.
#[derive(Debug)]
pub(crate) struct Incoming<M> {
    queue: WaitingQueue<Arc<M>>,
    received: u64,
    /// How many drops the statuses tell of.
    said_dropped: u64,
}

impl<M> Incoming<M> {
    /// At most `queue_size` messages wait; 0 sets no limit.
    pub(crate) fn new(queue_size: u32) -> Self {
        Self { queue: WaitingQueue::new(queue_size as usize), received: 0, said_dropped: 0 }
    }

    /// Takes a message that counts as received.
    pub(crate) fn push(&mut self, header: &Header, message: Arc<M>, statuses: &mut Statuses) {
        self.push_until(header, stamp(header), message, statuses);
    }

    /// Takes a message whose frame must be known both at its stamp and at another time.
    pub(crate) fn push_until(&mut self, header: &Header, end: Time, message: Arc<M>, statuses: &mut Statuses) {
        self.received += 1;
        statuses.set(Level::Ok, "Topic", format!("{} messages received", self.received));
        self.queue.push_until(&header.frame_id, stamp(header), end, message);
    }

    /// The messages that can be placed now.
    pub(crate) fn take_ready(&mut self, world: &World<'_>, statuses: &mut Statuses) -> Vec<Arc<M>> {
        if self.queue.is_empty() && self.queue.dropped().total() == self.said_dropped {
            return Vec::new();
        }
        let ready = self.queue.take_ready(world.transforms, world.fixed_frame);
        self.say_dropped(world, statuses);
        if !ready.is_empty() {
            statuses.set(Level::Ok, "Transform", "Transform OK");
        } else if let Some(reason) = self.queue.waiting_reason(world.transforms, world.fixed_frame) {
            // The error of a drop stays until a message can be placed.
            if statuses.get("Transform").is_none_or(|status| status.level < Level::Error) {
                statuses.set(Level::Warn, "Transform", frame::problem(&reason, world.fixed_frame));
            }
        }
        ready
    }

    /// Says why the last message was dropped, and how many were.
    fn say_dropped(&mut self, world: &World<'_>, statuses: &mut Statuses) {
        let counts = self.queue.dropped();
        if counts.total() == self.said_dropped {
            return;
        }
        self.said_dropped = counts.total();
        if let Some(dropped) = self.queue.last_dropped() {
            statuses.set(Level::Error, "Transform", frame::drop_reason(dropped, world.fixed_frame));
        }
        let by_reason =
            [(counts.queue_full, "queue full"), (counts.too_old, "too old"), (counts.empty_frame, "no frame")];
        let by_reason = by_reason.iter().filter(|(count, _)| *count > 0);
        let by_reason: Vec<String> = by_reason.map(|(count, reason)| format!("{count} {reason}")).collect();
        let text = format!("{} messages dropped: {}", counts.total(), by_reason.join(", "));
        statuses.set(Level::Ok, "Dropped", text);
    }

    /// Forgets what waits.
    pub(crate) fn clear(&mut self) {
        self.queue.clear();
        self.received = 0;
    }
}
