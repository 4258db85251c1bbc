//! Messages that wait until their frame is known, with rviz's statuses for that.

use std::sync::Arc;

use rcs_messages::std_msgs::Header;
use rcs_transforms::{Time, WaitingQueue};

use crate::world::stamp;
use crate::{Level, Statuses, World};

/// The messages of one topic between their arrival and the moment when they can be placed.
#[derive(Debug)]
pub(crate) struct Incoming<M> {
    queue: WaitingQueue<Arc<M>>,
    received: u64,
}

impl<M> Incoming<M> {
    /// At most `queue_size` messages wait; 0 sets no limit.
    pub(crate) fn new(queue_size: u32) -> Self {
        Self { queue: WaitingQueue::new(queue_size as usize), received: 0 }
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
        if self.queue.is_empty() && self.queue.last_dropped().is_none() {
            return Vec::new();
        }
        let ready = self.queue.take_ready(world.transforms, world.fixed_frame);
        if ready.is_empty() {
            if let Some(reason) = self.queue.waiting_reason(world.transforms, world.fixed_frame) {
                statuses.set(Level::Warn, "Transform", reason.to_string());
            } else if let Some(dropped) = self.queue.last_dropped() {
                statuses.set(Level::Error, "Transform", dropped.to_string());
            }
        } else {
            statuses.set(Level::Ok, "Transform", "Transform OK");
        }
        ready
    }

    /// Forgets what waits.
    pub(crate) fn clear(&mut self) {
        self.queue.clear();
        self.received = 0;
    }
}
