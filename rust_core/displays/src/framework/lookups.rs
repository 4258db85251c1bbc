//! Which transforms place what a display shows, recorded as the display looks them up.
//!
//! What follows a frame is looked up again in each update, and is as old as the frame's transforms then. What a message
//! places once, at its stamp, ages as that message does; without a stamp it is placed by the latest transforms, and is
//! no newer than those were. Each display looks frames up through a [`World`](crate::World) that records this, so no
//! class has to report it.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;

use rcs_transforms::Time;

/// The frames that what a display shows follows.
#[derive(Clone, Debug, Default)]
pub struct FollowedFrames {
    /// Each with whether it was looked up in the update at hand.
    frames: BTreeMap<String, bool>,
    all: bool,
    all_in_update: bool,
}

impl FollowedFrames {
    /// The frames by their names, sorted: what is shown is as old as the oldest of them.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.frames.keys().map(String::as_str)
    }

    /// Whether it follows all frames that there are, each of which comes and goes by itself: what is shown is as old as
    /// the newest of them.
    pub fn is_all(&self) -> bool {
        self.all
    }

    fn add(&mut self, frame: &str) {
        match self.frames.get_mut(frame) {
            Some(is_in_update) => *is_in_update = true,
            None => drop(self.frames.insert(frame.to_owned(), true)),
        }
    }

    fn add_all(&mut self) {
        (self.all, self.all_in_update) = (true, true);
    }

    /// Ends an update. One that changed what is shown has looked up all that this follows. Otherwise the display may
    /// have had nothing to look up, as between two updates of its own rate.
    fn end_update(&mut self, has_changed: bool) {
        if has_changed {
            self.frames.retain(|_, is_in_update| *is_in_update);
            self.all = self.all_in_update;
        }
        self.frames.values_mut().for_each(|is_in_update| *is_in_update = false);
        self.all_in_update = false;
    }
}

/// Records what one display looks up while it takes a message or is updated.
#[derive(Debug, Default)]
pub(crate) struct Lookups {
    /// `None` while it takes a message, which it places once.
    followed: Option<RefCell<FollowedFrames>>,
    placed_at: Cell<Option<Time>>,
}

impl Lookups {
    /// Of a display that is updated, and has followed these frames so far.
    pub(crate) fn of_update(followed: FollowedFrames) -> Self {
        Self { followed: Some(RefCell::new(followed)), placed_at: Cell::default() }
    }

    pub(crate) fn follow(&self, frame: &str) {
        if let Some(followed) = &self.followed {
            followed.borrow_mut().add(frame);
        }
    }

    pub(crate) fn follow_all(&self) {
        if let Some(followed) = &self.followed {
            followed.borrow_mut().add_all();
        }
    }

    /// Records that something was placed by the latest transforms, which are of that time; zero for static ones.
    pub(crate) fn place_at(&self, latest: Time) {
        if !latest.is_zero() {
            self.placed_at.set(Some(self.placed_at.get().map_or(latest, |known| known.min(latest))));
        }
    }

    /// The oldest time of latest transforms by which something was placed; none if only messages' stamps and static
    /// transforms did that.
    pub(crate) fn placed_at(&self) -> Option<Time> {
        self.placed_at.get()
    }

    /// The frames that the display follows after the update, which has changed what it shows or not.
    pub(crate) fn into_followed(self, has_changed: bool) -> FollowedFrames {
        let mut followed = self.followed.map(RefCell::into_inner).unwrap_or_default();
        followed.end_update(has_changed);
        followed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_followed_until_an_update_changes_what_is_shown_without_it() {
        let mut followed = FollowedFrames::default();
        let mut update = |frames: &[&str], has_changed: bool| {
            let lookups = Lookups::of_update(std::mem::take(&mut followed));
            frames.iter().for_each(|frame| lookups.follow(frame));
            followed = lookups.into_followed(has_changed);
            followed.names().map(str::to_owned).collect::<Vec<_>>()
        };
        assert_eq!(update(&["b", "a"], true), ["a", "b"]);
        assert_eq!(update(&[], false), ["a", "b"], "it was not due");
        assert_eq!(update(&["c"], false), ["a", "b", "c"], "only some of its markers were placed so far");
        assert_eq!(update(&["b"], true), ["b"]);
        assert!(update(&[], true).is_empty());
    }

    #[test]
    fn a_message_that_is_taken_makes_nothing_follow_and_the_oldest_place_counts() {
        let lookups = Lookups::default();
        lookups.follow("a");
        lookups.follow_all();
        assert_eq!(lookups.placed_at(), None);
        [0, 7, 5, 9].into_iter().for_each(|secs| lookups.place_at(Time::from_secs_nanos(secs, 0)));
        assert_eq!(lookups.placed_at(), Some(Time::from_secs_nanos(5, 0)));
        let followed = lookups.into_followed(false);
        assert!(followed.names().next().is_none() && !followed.is_all());
    }
}
