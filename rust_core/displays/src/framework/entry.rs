//! A display of the set, with its shown messages and its followed frames.

use std::sync::Arc;
use std::time::{Duration, Instant};

use rcs_messages::AnyMessage;
use rcs_rviz_config::DisplaySettings;
use rcs_scene::DisplayId;
use rcs_transforms::Time;

use crate::framework::arrivals::{Arrivals, ShownMessage};
use crate::framework::display::Display;
use crate::framework::guarded::GuardedDisplay;
use crate::framework::lookups::{FollowedFrames, Lookups};
use crate::framework::message_cache::MessageCache;
use crate::framework::report::{DisplayAge, DisplayReport, ListedDisplay};
use crate::{Level, World};

pub(crate) struct DisplayEntry {
    /// Stays as long as the display does, whatever is listed around it.
    pub(super) id: DisplayId,
    pub(super) listed: ListedDisplay,
    pub(super) settings: DisplaySettings,
    pub(super) display: GuardedDisplay,
    /// The set's version at its last change.
    pub(super) changed_at: u64,
    /// Time spent on its messages and updates since it was last taken.
    pub(super) cost: Duration,
    /// Messages given since the start or the last reset.
    received: u64,
    arrivals: Arrivals,
    /// Time of the oldest latest transforms that placed messages since the last update.
    placed_at: Option<Time>,
    followed: FollowedFrames,
}

impl DisplayEntry {
    pub(super) fn new(
        id: DisplayId,
        listed: ListedDisplay,
        settings: DisplaySettings,
        display: GuardedDisplay,
    ) -> Self {
        Self {
            id,
            listed,
            settings,
            display,
            changed_at: 0,
            cost: Duration::ZERO,
            received: 0,
            arrivals: Arrivals::default(),
            placed_at: None,
            followed: FollowedFrames::default(),
        }
    }

    pub(super) fn take(&mut self, topic: &str, message: &AnyMessage, received: Option<Instant>, world: &World<'_>) {
        let begun = Instant::now();
        self.received += 1;
        self.give(topic, message, received, world);
        self.cost += begun.elapsed();
    }

    pub(super) fn take_parameter(&mut self, name: &str, text: Option<&Arc<str>>, world: &World<'_>) {
        self.with_display(|display| display.take_parameter(name, text, world));
    }

    pub(super) fn publisher_left(&mut self, topic: &str) {
        self.with_display(|display| display.publisher_left(topic));
    }

    /// Removes all messages but those that it goes on to show.
    pub(super) fn reset(&mut self) {
        self.received = 0;
        self.display.reset();
        match self.display.drawables() {
            [] => self.arrivals.clear(),
            _ => self.arrivals.forget_waiting(),
        }
    }

    /// Places its messages again, in another fixed frame.
    pub(super) fn place_again(&mut self, cache: &MessageCache, world: &World<'_>) {
        self.received = 0;
        self.followed = FollowedFrames::default();
        self.display.reset();
        self.arrivals.clear();
        self.give_messages(cache, world);
    }

    /// Gives a new display the cached parameters and messages.
    pub(super) fn give_all(&mut self, cache: &MessageCache, world: &World<'_>) {
        for name in self.display.parameters() {
            if let Some(text) = cache.parameter(&name) {
                self.take_parameter(&name, text, world);
            }
        }
        self.give_messages(cache, world);
    }

    /// Updates it. Returns whether its drawables changed, and the newest message that is shown since then.
    pub(super) fn update(&mut self, world: &World<'_>) -> (bool, Option<ShownMessage>) {
        let begun = Instant::now();
        let lookups = Lookups::of_update(std::mem::take(&mut self.followed));
        let has_changed = self.with_display(|display| display.update(&world.recording(&lookups)));
        let placed_at = self.placed_at.take().into_iter().chain(lookups.placed_at()).min();
        self.followed = lookups.into_followed(has_changed);
        let display = &self.display;
        let is_accepted = || display.statuses().level() < Level::Error;
        let shown = self.arrivals.settle(has_changed, placed_at, is_accepted, |stamp| display.is_waiting(stamp));
        self.cost += begun.elapsed();
        (has_changed, shown)
    }

    pub(super) fn age(&self) -> DisplayAge<'_> {
        DisplayAge {
            id: self.id,
            path: &self.listed.path,
            topics: self.display.topics(),
            current: self.arrivals.current(),
            follows: &self.followed,
            is_empty: self.display.drawables().is_empty(),
        }
    }

    pub(super) fn report(&self) -> DisplayReport<'_> {
        DisplayReport::new(self.id, &self.listed, &self.display, self.received, self.arrivals.shown())
    }

    fn give(&mut self, topic: &str, message: &AnyMessage, received: Option<Instant>, world: &World<'_>) {
        let lookups = Lookups::default();
        self.arrivals.note(message, received);
        self.with_display(|display| display.take_from(topic, message, &world.recording(&lookups)));
        self.placed_at = self.placed_at.into_iter().chain(lookups.placed_at()).min();
    }

    fn give_messages(&mut self, cache: &MessageCache, world: &World<'_>) {
        let topics = self.display.topics();
        for (topic, message) in cache.messages(&topics, world.now) {
            self.received += 1;
            self.give(topic, &message, None, world);
        }
    }

    /// Runs `work` on the display. If the display panics, it shows none of its messages any more.
    fn with_display<T>(&mut self, work: impl FnOnce(&mut GuardedDisplay) -> T) -> T {
        let panics = self.display.panics();
        let result = work(&mut self.display);
        if self.display.panics() != panics {
            self.arrivals.clear();
        }
        result
    }
}

#[cfg(test)]
mod tests;
