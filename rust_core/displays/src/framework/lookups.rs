//! Record of the transforms that place a display's drawables.
//!
//! Drawables that follow a frame are looked up in each update, and are as old as the frame's transforms. Those that a
//! message places once, at its stamp, age with the message; without a stamp they are placed by the latest transforms,
//! and are no newer than those. Each display looks frames up through a [`World`](crate::World) that records this, so no
//! class has to report it.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;

use rcs_transforms::Time;

/// Frames that a display's drawables follow.
#[derive(Clone, Debug, Default)]
pub struct FollowedFrames {
    /// Frames with whether they were looked up in the current update.
    frames: BTreeMap<String, bool>,
    all: bool,
    all_in_update: bool,
}

impl FollowedFrames {
    /// Sorted names of the frames: the drawables are as old as the oldest of them.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.frames.keys().map(String::as_str)
    }

    /// `true` if it follows all existing frames, each of which comes and goes by itself: the drawables are as old as
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

    /// Ends an update. One that changed the drawables has looked up all their frames. Otherwise the display may have
    /// skipped the lookups, as between two updates of its own rate.
    fn end_update(&mut self, has_changed: bool) {
        if has_changed {
            self.frames.retain(|_, is_in_update| *is_in_update);
            self.all = self.all_in_update;
        }
        self.frames.values_mut().for_each(|is_in_update| *is_in_update = false);
        self.all_in_update = false;
    }
}

/// Lookups of one display while it takes a message or is updated.
#[derive(Debug, Default)]
pub(crate) struct Lookups {
    /// `None` while it takes a message, which is placed once.
    followed: Option<RefCell<FollowedFrames>>,
    placed_at: Cell<Option<Time>>,
}

impl Lookups {
    /// Lookups of an update of a display that has followed these frames so far.
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

    /// Records that a message was placed by the latest transforms, of this time; zero for static ones.
    pub(crate) fn place_at(&self, latest: Time) {
        if !latest.is_zero() {
            self.placed_at.set(Some(self.placed_at.get().map_or(latest, |known| known.min(latest))));
        }
    }

    /// Oldest time of latest transforms that placed a message; `None` if only stamps and static transforms did.
    pub(crate) fn placed_at(&self) -> Option<Time> {
        self.placed_at.get()
    }

    /// Frames that the display follows after the update.
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
