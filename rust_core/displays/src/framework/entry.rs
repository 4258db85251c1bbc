//! A display of the scene, with its shown messages and its followed frames. Its panics end neither the other displays
//! nor the program.
//!
//! The state of a display after a panic is unreliable. So it is replaced by a new, empty one, whose status is an error
//! until it shows something. After a second panic within a minute it is off: it takes nothing until the config makes it
//! anew.

use std::borrow::Cow;
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::sync::Arc;
use std::time::{Duration, Instant};

use rcs_messages::AnyMessage;
use rcs_rviz_config::DisplaySettings;
use rcs_scene::{DisplayId, Drawable};
use rcs_transforms::Time;

use crate::framework::arrivals::{Arrivals, ShownMessage};
use crate::framework::display::Display;
use crate::framework::lookups::{FollowedFrames, Lookups};
use crate::framework::message_cache::MessageCache;
use crate::framework::report::{topic_status, DisplayAge, DisplayReport, ListedDisplay};
use crate::{Level, Statuses, TopicRequest, World};

const FAILED: &str = "This display panicked, see the log. It shows nothing until its next message.";
const OFF: &str = "This display panicked twice within a minute, see the log. It is off until the config is reloaded.";

/// ROS time after a panic in which another one switches the display off.
const PROBATION_SECS: f64 = 60.0;

/// Makes a display of these settings; always or never.
type Create = fn(DisplayId, &DisplaySettings) -> Option<Box<dyn Display>>;

pub(crate) struct DisplayEntry {
    /// Stays as long as the display does, whatever is listed around it.
    pub(super) id: DisplayId,
    pub(super) listed: ListedDisplay,
    pub(super) settings: DisplaySettings,
    /// Topics that it subscribes to.
    pub(super) topics: Vec<TopicRequest>,
    create: Create,
    display: Box<dyn Display>,
    /// The scene's version at its last change.
    pub(super) changed_at: u64,
    /// Time spent on its messages and updates since it was last taken.
    pub(super) cost: Duration,
    /// Messages given since the start or the last reset.
    received: u64,
    arrivals: Arrivals,
    followed: FollowedFrames,
    faults: Faults,
}

/// The panics of a display.
#[derive(Default)]
struct Faults {
    /// ROS time of the display's last message or update, and of its last panic.
    now: Time,
    panicked_at: Option<Time>,
    /// `true` after a panic within [`PROBATION_SECS`] of another one.
    is_off: bool,
    /// Statuses since a panic, until the display shows something.
    statuses: Option<Statuses>,
    /// The drawables are gone, which the next update reports.
    is_emptied: bool,
}

impl Faults {
    /// Records a panic.
    fn record(&mut self) {
        let (now, last) = (self.now, self.panicked_at.replace(self.now));
        self.is_off = last.is_some_and(|last| (0.0..PROBATION_SECS).contains(&now.secs_since(last)));
        let mut statuses = Statuses::default();
        statuses.set(Level::Error, Statuses::FAULT, if self.is_off { OFF } else { FAILED });
        (self.statuses, self.is_emptied) = (Some(statuses), true);
    }
}

impl DisplayEntry {
    /// `None` for what is no display in the scene: groups and cameras.
    pub(super) fn new(id: DisplayId, listed: ListedDisplay, settings: DisplaySettings, create: Create) -> Option<Self> {
        let display = create(id, &settings)?;
        Some(Self {
            id,
            listed,
            settings,
            topics: display.topics(),
            create,
            display,
            changed_at: 0,
            cost: Duration::ZERO,
            received: 0,
            arrivals: Arrivals::default(),
            followed: FollowedFrames::default(),
            faults: Faults::default(),
        })
    }

    /// Runs `work` on the display. `None` if it panics or is off: then it shows none of its messages any more.
    fn guard<T>(&mut self, work: impl FnOnce(&mut dyn Display) -> T) -> Option<T> {
        if self.faults.is_off {
            return None;
        }
        let display = self.display.as_mut();
        if let Ok(result) = catch_unwind(AssertUnwindSafe(|| work(display))) {
            return Some(result);
        }
        if let Some(new) = (self.create)(self.id, &self.settings) {
            let old = std::mem::replace(&mut self.display, new);
            // Dropping a broken display may panic, too.
            let _ = catch_unwind(AssertUnwindSafe(|| drop(old)));
        }
        self.faults.record();
        self.arrivals.clear();
        None
    }

    pub(super) fn take(&mut self, topic: &str, message: &AnyMessage, received: Option<Instant>, world: &World<'_>) {
        let begun = Instant::now();
        self.received += 1;
        self.faults.now = world.now;
        let lookups = Lookups::default();
        self.arrivals.note(message, received);
        self.guard(|display| display.take_from(topic, message, &world.recording(&lookups)));
        self.arrivals.place(lookups.placed_at());
        self.cost += begun.elapsed();
    }

    pub(super) fn take_parameter(&mut self, name: &str, text: Option<&Arc<str>>, world: &World<'_>) {
        self.faults.now = world.now;
        self.guard(|display| display.take_parameter(name, text, world));
    }

    pub(super) fn publisher_left(&mut self, topic: &str) {
        self.guard(|display| display.publisher_left(topic));
    }

    /// Removes all messages but those that it goes on to show.
    pub(super) fn reset(&mut self) {
        self.received = 0;
        self.guard(|display| display.reset());
        match self.drawables() {
            [] => self.arrivals.clear(),
            _ => self.arrivals.forget_waiting(),
        }
    }

    /// Places its messages again, in another fixed frame.
    pub(super) fn place_again(&mut self, cache: &MessageCache, world: &World<'_>) {
        self.received = 0;
        self.followed = FollowedFrames::default();
        self.guard(|display| display.reset());
        self.arrivals.clear();
        self.give_messages(cache, world);
    }

    /// Gives a new display the cached parameters and messages.
    pub(super) fn give_all(&mut self, cache: &MessageCache, world: &World<'_>) {
        for name in self.parameters() {
            if let Some(text) = cache.parameter(&name) {
                self.take_parameter(&name, text, world);
            }
        }
        self.give_messages(cache, world);
    }

    fn give_messages(&mut self, cache: &MessageCache, world: &World<'_>) {
        for (topic, message) in cache.messages(&self.topics.clone(), world.now) {
            self.take(topic, &message, None, world);
        }
    }

    /// Updates it. Returns whether its drawables changed, and the newest message that is shown since then.
    pub(super) fn update(&mut self, world: &World<'_>) -> (bool, Option<ShownMessage>) {
        let begun = Instant::now();
        self.faults.now = world.now;
        let lookups = Lookups::of_update(std::mem::take(&mut self.followed));
        let updated = self.guard(|display| display.update(&world.recording(&lookups)));
        if updated.is_some() && !self.drawables().is_empty() {
            self.faults.statuses = None;
        }
        let has_changed = updated.unwrap_or_default() | std::mem::take(&mut self.faults.is_emptied);
        self.arrivals.place(lookups.placed_at());
        self.followed = lookups.into_followed(has_changed);
        let (failed, display) = (&self.faults.statuses, &self.display);
        let is_accepted = || failed.as_ref().unwrap_or_else(|| display.statuses()).level() < Level::Error;
        let shown = self.arrivals.settle(has_changed, is_accepted, |stamp| display.is_waiting(stamp));
        self.cost += begun.elapsed();
        (has_changed, shown)
    }

    /// `true` if it panicked and has shown nothing since then.
    pub(super) fn has_failed(&self) -> bool {
        self.faults.statuses.is_some()
    }

    pub(super) fn parameters(&self) -> Vec<String> {
        self.display.parameters()
    }

    pub(super) fn is_replaced_by_newest(&self) -> bool {
        self.display.is_replaced_by_newest()
    }

    pub(super) fn drawables(&self) -> &[Drawable] {
        self.display.drawables()
    }

    pub(super) fn next_change(&self) -> Option<Time> {
        self.display.next_change()
    }

    fn statuses(&self) -> &Statuses {
        self.faults.statuses.as_ref().unwrap_or_else(|| self.display.statuses())
    }

    pub(super) fn age(&self) -> DisplayAge<'_> {
        DisplayAge {
            id: self.id,
            path: &self.listed.path,
            topics: &self.topics,
            current: self.arrivals.current(),
            follows: &self.followed,
            is_empty: self.drawables().is_empty(),
        }
    }

    pub(super) fn report(&self) -> DisplayReport<'_> {
        let Self { id, listed, topics, received, .. } = self;
        let mut statuses = Cow::Borrowed(self.statuses());
        if let Some((level, text)) = topic_status(listed, topics, *received, &statuses) {
            statuses.to_mut().set(level, Statuses::TOPIC, text);
        }
        DisplayReport { id: *id, listed, topics, received: *received, shown: self.arrivals.shown(), statuses }
    }
}

#[cfg(test)]
mod tests;
