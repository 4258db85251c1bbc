//! A display of the set, with its shown messages, its followed frames and its recovery from panics.
//!
//! A display that panicked has lost its state. So it is given its parameters and the last messages of its topics again,
//! except those that make it panic. Messages that came since its last good update are tried one by one, because one of
//! them is the likely cause. This is done once, and again only after new input.

use std::sync::Arc;
use std::time::{Duration, Instant};

use rcs_rviz_config::DisplaySettings;
use rcs_scene::DisplayId;
use rcs_transforms::Time;

use crate::framework::arrivals::{Arrivals, ShownMessage};
use crate::framework::display::Display;
use crate::framework::guarded::GuardedDisplay;
use crate::framework::lookups::{FollowedFrames, Lookups};
use crate::framework::message_cache::{CachedMessage, MessageCache};
use crate::framework::report::{DisplayAge, DisplayReport, ListedDisplay};
use crate::{Level, World};

/// Causes of panics that are left out, one after the other, before a display is left empty.
const MOST_CAUSES: usize = 5;

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
    recovery: Recovery,
}

/// State of the recovery of a display from panics.
#[derive(Debug, Default)]
struct Recovery {
    refused_parameters: bool,
    /// Numbers of the messages that made it panic.
    refused_messages: Vec<u64>,
    answered_panics: u64,
    /// Something came from outside since the last restore.
    has_news: bool,
    /// Messages with smaller numbers were there in a good update, or are refused.
    updated_to: u64,
}

enum PanicCause {
    Parameters,
    Message(u64),
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
            recovery: Recovery { has_news: true, ..Recovery::default() },
        }
    }

    pub(super) fn take(&mut self, kept: &CachedMessage<'_>, received: Option<Instant>, world: &World<'_>) {
        let begun = Instant::now();
        let panics = self.display.panics();
        self.received += 1;
        self.recovery.has_news = true;
        self.give(kept, received, world);
        if self.display.panics() != panics {
            self.recovery.refused_messages.push(kept.number);
        }
        self.cost += begun.elapsed();
    }

    pub(super) fn take_parameter(&mut self, name: &str, text: Option<&Arc<str>>, world: &World<'_>) {
        let panics = self.display.panics();
        self.recovery.has_news = true;
        self.display.take_parameter(name, text, world);
        self.recovery.refused_parameters = self.display.panics() != panics;
    }

    pub(super) fn publisher_left(&mut self, topic: &str) {
        self.recovery.has_news = true;
        self.display.publisher_left(topic);
    }

    pub(super) fn forget_shown(&mut self) {
        self.recovery.has_news = true;
        self.display.forget_shown();
        self.arrivals.clear();
    }

    /// Removes all messages but those that it goes on to show.
    pub(super) fn reset(&mut self) {
        (self.received, self.recovery.has_news) = (0, true);
        self.recovery.refused_messages.clear();
        self.display.reset();
        match self.display.drawables() {
            [] => self.arrivals.clear(),
            _ => self.arrivals.forget_waiting(),
        }
    }

    /// Places its messages again, in another fixed frame.
    pub(super) fn place_again(&mut self, cache: &MessageCache, world: &World<'_>) {
        (self.received, self.recovery.has_news) = (0, true);
        self.followed = FollowedFrames::default();
        self.display.reset();
        self.arrivals.clear();
        self.give_messages(cache, world);
    }

    /// Gives a new display the cached parameters and messages.
    pub(super) fn give_all(&mut self, cache: &MessageCache, world: &World<'_>) {
        self.give_parameters(cache, world);
        self.give_messages(cache, world);
    }

    /// Updates it. Returns whether its drawables changed, and the newest message that is shown since then.
    pub(super) fn update(&mut self, cache: &MessageCache, world: &World<'_>) -> (bool, Option<ShownMessage>) {
        let begun = Instant::now();
        let (mut has_changed, mut shown) = self.update_once(world);
        if self.display.panics() != self.recovery.answered_panics && std::mem::take(&mut self.recovery.has_news) {
            self.restore(cache, world);
            (has_changed, shown) = (true, None);
        }
        self.recovery.answered_panics = self.display.panics();
        self.recovery.updated_to = cache.next_number();
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

    fn give(&mut self, kept: &CachedMessage<'_>, received: Option<Instant>, world: &World<'_>) {
        let lookups = Lookups::default();
        self.arrivals.note(&kept.message, received);
        self.display.take_from(kept.topic, &kept.message, &world.recording(&lookups));
        self.placed_at = self.placed_at.into_iter().chain(lookups.placed_at()).min();
    }

    fn give_parameters(&mut self, cache: &MessageCache, world: &World<'_>) {
        for name in self.display.parameters() {
            if let Some(text) = cache.parameter(&name) {
                self.display.take_parameter(&name, text, world);
            }
        }
    }

    fn give_messages(&mut self, cache: &MessageCache, world: &World<'_>) {
        let topics = self.display.topics();
        for kept in cache.messages(&topics, world.now) {
            self.received += 1;
            self.give(&kept, None, world);
        }
    }

    fn update_once(&mut self, world: &World<'_>) -> (bool, Option<ShownMessage>) {
        let lookups = Lookups::of_update(std::mem::take(&mut self.followed));
        let has_changed = self.display.update(&world.recording(&lookups));
        let placed_at = self.placed_at.take().into_iter().chain(lookups.placed_at()).min();
        self.followed = lookups.into_followed(has_changed);
        let display = &self.display;
        let is_accepted = || display.statuses().level() < Level::Error;
        let shown = self.arrivals.settle(has_changed, placed_at, is_accepted, |stamp| display.is_waiting(stamp));
        (has_changed, shown)
    }

    /// Restores a display that panicked, without the causes of panics.
    fn restore(&mut self, cache: &MessageCache, world: &World<'_>) {
        for _ in 0..MOST_CAUSES {
            self.begin_anew();
            match self.try_all(cache, world) {
                Ok(()) => return,
                Err(Some(PanicCause::Parameters)) => self.recovery.refused_parameters = true,
                Err(Some(PanicCause::Message(number))) => self.recovery.refused_messages.push(number),
                Err(None) => break,
            }
        }
        self.begin_anew();
    }

    fn begin_anew(&mut self) {
        self.display.begin_anew();
        self.arrivals.clear();
    }

    /// Gives it all cached input that is not refused.
    fn try_all(&mut self, cache: &MessageCache, world: &World<'_>) -> Result<(), Option<PanicCause>> {
        let (panics, mut last) = (self.display.panics(), None);
        if !self.recovery.refused_parameters && !self.display.parameters().is_empty() {
            last = Some(PanicCause::Parameters);
            self.give_parameters(cache, world);
            self.update_once(world);
        }
        let topics = self.display.topics();
        let messages = cache.messages(&topics, world.now);
        self.recovery.refused_messages.retain(|number| messages.iter().any(|kept| kept.number == *number));
        let is_new = |number: u64| number >= self.recovery.updated_to;
        let suspects = if messages.iter().any(|kept| is_new(kept.number)) { self.recovery.updated_to } else { 0 };
        for kept in
            messages.iter().filter(|kept| !self.recovery.refused_messages.contains(&kept.number)).collect::<Vec<_>>()
        {
            if self.display.panics() != panics {
                return Err(last);
            }
            last = Some(PanicCause::Message(kept.number));
            self.give(kept, None, world);
            if kept.number >= suspects {
                self.update_once(world);
            }
        }
        self.update_once(world);
        if self.display.panics() == panics {
            Ok(())
        } else {
            Err(last)
        }
    }
}

#[cfg(test)]
mod tests;
