//! Tracking of the newest message that a display shows.
//!
//! A message may wait for its frame, be dropped or be replaced by the next one before it is ever visible. It counts as
//! shown in the update in which the drawables changed and the message did not wait any more; the newest of those is the
//! one that the display shows. The time of reception comes from the caller and is passed on.

use std::collections::VecDeque;
use std::time::Instant;

use rcs_messages::{header, AnyMessage, MessageKind};
use rcs_transforms::Time;

use crate::framework::world::stamp;

/// Largest number of tracked messages; the oldest are dropped.
const MOST_WAITING: usize = 100;

/// A message that a display shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShownMessage {
    /// The time in its header, of an array's first element; zero where it has none.
    pub stamp: Time,
    /// When it was received, if the caller gave that.
    pub received: Option<Instant>,
}

/// Messages of a display that wait, and the last one that is shown.
#[derive(Debug, Default)]
pub(crate) struct Arrivals {
    /// Messages taken since the last update or waiting for their frames; oldest first.
    pending: VecDeque<ShownMessage>,
    shown: Option<ShownMessage>,
    current: Option<ShownMessage>,
    /// Oldest time of the latest transforms that placed messages since the last update.
    placed_at: Option<Time>,
}

impl Arrivals {
    /// Records a message that the display takes. A CameraInfo has no drawables itself.
    pub(crate) fn note(&mut self, message: &AnyMessage, received: Option<Instant>) {
        if message.kind() == MessageKind::CameraInfo {
            return;
        }
        if self.pending.len() >= MOST_WAITING {
            self.pending.pop_front();
        }
        self.pending.push_back(ShownMessage { stamp: header(message).map_or(Time::ZERO, stamp), received });
    }

    /// Records the time of the latest transforms that placed messages, if any did.
    pub(crate) fn place(&mut self, placed_at: Option<Time>) {
        self.placed_at = self.placed_at.into_iter().chain(placed_at).min();
    }

    /// Records an update. Returns the newest message that is shown since then, if any. `is_accepted`: messages that do
    /// not wait any more were not refused or dropped.
    pub(crate) fn settle(
        &mut self,
        changed: bool,
        is_accepted: impl FnOnce() -> bool,
        is_waiting: impl Fn(Time) -> bool,
    ) -> Option<ShownMessage> {
        let (placed_at, mut newest) = (self.placed_at.take(), None);
        self.pending.retain(|message| {
            let stays = is_waiting(message.stamp);
            if !stays {
                newest = Some(*message);
            }
            stays
        });
        let newest = newest?;
        if changed || is_accepted() {
            let stamp = Some(newest.stamp).filter(|stamp| !stamp.is_zero());
            let oldest = stamp.into_iter().chain(placed_at).min();
            self.current = Some(ShownMessage { stamp: oldest.unwrap_or(Time::ZERO), ..newest });
        }
        if !changed {
            return None;
        }
        self.shown = Some(newest);
        Some(newest)
    }

    /// Newest message that the drawables stand for: also one that changed nothing, as it repeats its predecessor. Its
    /// stamp is no newer than the transforms that placed it.
    pub(crate) fn current(&self) -> Option<ShownMessage> {
        self.current
    }

    /// Newest message that changed the drawables.
    pub(crate) fn shown(&self) -> Option<ShownMessage> {
        self.shown
    }

    /// Removes the waiting messages; the display keeps its drawables.
    pub(crate) fn forget_waiting(&mut self) {
        self.pending.clear();
        self.shown = None;
    }

    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rcs_messages::geometry_msgs::PoseStamped;

    use super::*;

    fn note(arrivals: &mut Arrivals, secs: u32) {
        let mut pose = PoseStamped::default();
        pose.header.stamp.sec = secs;
        arrivals.note(&AnyMessage::PoseStamped(Arc::new(pose)), None);
    }

    /// The stamp of what is newly shown after an update, while stamps from `waiting_secs` on wait.
    fn settle(arrivals: &mut Arrivals, changed: bool, waiting_secs: u32) -> Option<u32> {
        let waits = |stamp: Time| stamp >= Time::from_secs_nanos(waiting_secs, 0);
        arrivals.settle(changed, || false, waits).map(|shown| shown.stamp.as_secs_nanos().0)
    }

    #[test]
    fn the_newest_that_does_not_wait_is_shown_once() {
        let mut arrivals = Arrivals::default();
        [1, 2, 3].into_iter().for_each(|secs| note(&mut arrivals, secs));
        assert_eq!(settle(&mut arrivals, true, 3), Some(2));
        assert_eq!(settle(&mut arrivals, true, 3), None, "something else changed");
        assert_eq!(settle(&mut arrivals, true, 4), Some(3));
        assert_eq!(arrivals.shown().unwrap().stamp, Time::from_secs_nanos(3, 0));
        arrivals.clear();
        assert_eq!(arrivals.shown(), None);
    }

    #[test]
    fn a_message_that_changed_nothing_is_never_shown() {
        let mut arrivals = Arrivals::default();
        note(&mut arrivals, 1);
        assert_eq!(settle(&mut arrivals, false, 9), None);
        assert_eq!(settle(&mut arrivals, true, 9), None, "a later change is not its own");
        assert_eq!(arrivals.shown(), None);
    }

    #[test]
    fn what_is_shown_stands_for_a_message_that_says_the_same_but_not_for_one_that_was_refused() {
        let mut arrivals = Arrivals::default();
        let mut settled = |secs: u32, changed: bool, is_accepted: bool| {
            note(&mut arrivals, secs);
            arrivals.settle(changed, || is_accepted, |_| false);
            arrivals.current().map(|current| current.stamp.as_secs_nanos().0)
        };
        assert_eq!(settled(1, false, false), None);
        assert_eq!(settled(2, true, false), Some(2));
        assert_eq!(settled(3, false, true), Some(3));
        assert_eq!(settled(4, false, false), Some(3));
    }

    #[test]
    fn a_message_is_no_newer_than_the_transforms_that_placed_it() {
        for (secs, placed_at, oldest) in [(0, None, 0), (0, Some(7), 7), (9, Some(7), 7), (5, Some(7), 5)] {
            let mut arrivals = Arrivals::default();
            note(&mut arrivals, secs);
            let placed_at = placed_at.map(|secs| Time::from_secs_nanos(secs, 0));
            arrivals.place(placed_at);
            let shown = arrivals.settle(true, || true, |_| false);
            assert_eq!(shown.unwrap().stamp, Time::from_secs_nanos(secs, 0), "latencies count from its own stamp");
            assert_eq!(arrivals.current().unwrap().stamp, Time::from_secs_nanos(oldest, 0));
        }
    }

    #[test]
    fn messages_that_never_become_ready_are_limited() {
        let mut arrivals = Arrivals::default();
        (0..10_000).for_each(|secs| note(&mut arrivals, secs));
        assert_eq!(arrivals.pending.len(), MOST_WAITING);
        assert_eq!(settle(&mut arrivals, true, 10_000), Some(9_999));
    }
}
