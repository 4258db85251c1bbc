//! "Never false": which displays and cameras are too old to be shown.
//!
//! The age of data is the longer of two: since their stamp, by ROS time, and since they were received, by the
//! computer's clock, so that neither a wrong clock nor a simulation that stands still makes old data look new. What a
//! latching publisher sent does not age while that publisher is connected, for it is not sent again. What follows a
//! frame is as old as the frame's transforms as well, and too old while there are none: static ones do not age, and
//! moving ones are as old as the oldest on the way to the fixed frame. A display without data, a grid in the fixed
//! frame say, is neither current nor stale.

pub mod limits;
#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::time::{Duration, Instant};

use nalgebra::Point3;
use rcs_displays::{CameraView, DisplayAge, FollowedFrames, ShownMessage};
use rcs_messages::MessageKind;
use rcs_ros::Publishing;
use rcs_scene::DisplayId;
use rcs_transforms::Time;

use self::limits::{Limit, Limits};
use super::causes::{Cause, Dark};

/// The ages of a scene's displays, cameras and frames.
pub trait SceneAges {
    /// How old what each display shows is.
    fn ages(&self) -> Vec<DisplayAge<'_>>;

    /// The CameraInfo topics of its cameras, by their names in the config.
    fn camera_info_topics(&self) -> Vec<&str>;

    /// The frame of the last CameraInfo of such a topic, and what is known of its age.
    fn received_camera_info(&self, topic: &str) -> Option<(&str, ShownMessage)>;

    /// Until when a frame's place in the fixed frame is known; zero where nothing between them moves. None for the
    /// fixed frame itself, and for a frame whose place is not known at all.
    fn known_until(&self, frame: &str) -> Option<Time>;

    /// Where the origin of a frame is in the fixed frame now, as far as that is known.
    fn place_of(&self, frame: &str) -> Option<Point3<f64>>;
}

/// Where the data of a subscribed topic come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The topic's whole name.
    pub topic: String,
    /// Who is connected.
    pub publishing: Publishing,
}

/// The present by both clocks.
#[derive(Clone, Copy, Debug)]
pub struct Now {
    /// ROS time; zero before a simulation's first.
    pub ros: Time,
    /// The computer's clock.
    pub steady: Instant,
}

/// Follows how old everything is.
#[derive(Debug)]
pub(super) struct Freshness {
    limits: Limits,
    /// Until when the data of a topic were held by their publisher; by its name in the config.
    held_until: HashMap<String, Instant>,
    /// The newest time at which a frame is known, and since when it is that.
    frames: HashMap<String, (Time, Instant)>,
    /// When the last moving transforms were received.
    transforms_received: Option<Instant>,
}

/// Whether something may be shown.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum State {
    /// It has no data that could age, or none yet.
    Undated,
    /// It is current, and until when if nothing new arrives; without end for what does not age.
    Current(Option<Instant>),
    /// It is too old; says what and since how long.
    Stale(String),
}

/// The state of a display.
#[derive(Clone, Debug)]
struct DisplayState {
    id: DisplayId,
    /// Its name with those of the groups around it.
    path: String,
    state: State,
}

/// The states of all displays, at one moment.
#[derive(Clone, Debug, Default)]
pub struct Assessment {
    displays: Vec<DisplayState>,
    cameras: HashMap<String, State>,
}

/// What a camera may show.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Shown {
    /// The displays that are too old.
    pub(super) hidden: Vec<DisplayId>,
    /// Why nothing may be shown, if that is so.
    pub(super) black: Option<Dark>,
    /// Until when that holds if nothing new arrives.
    pub(super) until: Option<Instant>,
}

impl State {
    /// The worse of two: stale before current, current before undated, and the sooner end.
    pub(super) fn and(self, other: Self) -> Self {
        match (self, other) {
            (Self::Stale(why), _) | (_, Self::Stale(why)) => Self::Stale(why),
            (Self::Undated, state) | (state, Self::Undated) => state,
            (Self::Current(a), Self::Current(b)) => Self::Current(a.into_iter().chain(b).min()),
        }
    }
}

impl Freshness {
    /// Nothing is known yet. `None` where nothing is ever too old.
    pub(super) fn new(limits: Limits) -> Option<Self> {
        let (held_until, frames) = (HashMap::new(), HashMap::new());
        (!limits.is_off()).then_some(Self { limits, held_until, frames, transforms_received: None })
    }

    /// Records that transforms of moving frames were received.
    pub(super) fn note_transforms(&mut self, received: Instant) {
        self.transforms_received = Some(received);
    }

    /// Forgets what it knows of frames: the time jumped back.
    pub(super) fn reset(&mut self) {
        self.frames.clear();
        self.transforms_received = None;
    }

    /// The state of each display and camera. `source` says who publishes a topic, by its name in the config and type.
    pub(super) fn assess(
        &mut self,
        stage: &impl SceneAges,
        source: impl Fn(&str, MessageKind) -> Option<Source>,
        now: Now,
    ) -> Assessment {
        let mut displays = Vec::new();
        for age in stage.ages() {
            let path = age.path.join(" / ");
            let state = self.display(&age, &path, stage, &source, now);
            displays.push(DisplayState { id: age.id, path, state });
        }
        let mut cameras = HashMap::new();
        for topic in stage.camera_info_topics() {
            if !cameras.contains_key(topic) {
                cameras.insert(topic.to_owned(), self.camera(topic, stage, &source, now));
            }
        }
        Assessment { displays, cameras }
    }

    fn display(
        &mut self,
        age: &DisplayAge<'_>,
        path: &str,
        stage: &impl SceneAges,
        source: &impl Fn(&str, MessageKind) -> Option<Source>,
        now: Now,
    ) -> State {
        if age.is_empty {
            return State::Undated;
        }
        let topics = age.topics.iter().map(|request| (request.topic.as_str(), request.kind));
        let data = match age.current {
            Some(shown) => self.data(path, topics, shown, source, now),
            None => State::Undated,
        };
        data.and(self.followed(age.follows, stage, now))
    }

    /// The state of the frames that a display follows.
    fn followed(&mut self, frames: &FollowedFrames, stage: &impl SceneAges, now: Now) -> State {
        let all = match self.transforms_received.filter(|_| frames.is_all()) {
            Some(received) => self.transforms(now.steady.saturating_duration_since(received), "transforms", now),
            None => State::Undated,
        };
        frames.names().map(|frame| self.followed_frame(frame, stage, now)).fold(all, State::and)
    }

    /// The state of a frame that a display follows. Where its place is not known, it ages since that was last known,
    /// and one that was never known is too old.
    fn followed_frame(&mut self, frame: &str, stage: &impl SceneAges, now: Now) -> State {
        if stage.known_until(frame).is_some() {
            return self.frame(frame, stage, now);
        }
        let age = self.frames.get(frame).map_or(Duration::MAX, |(stamp, since)| {
            now.steady.saturating_duration_since(*since).max(age_by_stamp(*stamp, now.ros))
        });
        self.transforms(age, frame, now)
    }

    /// The state of a camera: that of its CameraInfo and of its frame. Undated before its first CameraInfo.
    fn camera(
        &mut self,
        topic: &str,
        stage: &impl SceneAges,
        source: &impl Fn(&str, MessageKind) -> Option<Source>,
        now: Now,
    ) -> State {
        let Some((frame, shown)) = stage.received_camera_info(topic) else { return State::Undated };
        let data = self.data("CameraInfo", [(topic, MessageKind::CameraInfo)], shown, source, now);
        data.and(self.frame(frame, stage, now))
    }

    /// The state of data that come on these topics.
    pub(super) fn data<'t>(
        &mut self,
        what: &str,
        topics: impl IntoIterator<Item = (&'t str, MessageKind)>,
        shown: ShownMessage,
        source: &impl Fn(&str, MessageKind) -> Option<Source>,
        now: Now,
    ) -> State {
        let sources: Vec<(&str, Source)> =
            topics.into_iter().filter_map(|(topic, kind)| Some((topic, source(topic, kind)?))).collect();
        let (limit, is_own) = self.limits.of(sources.iter().map(|(_, source)| source.topic.as_str()));
        let after = match limit {
            Limit::Never => return State::Current(None),
            Limit::After(after) => after,
            Limit::Held => Duration::ZERO,
        };
        let holds = |source: &Source| match limit {
            Limit::Held => source.publishing.is_connected,
            // Only where nothing was set for the topic: who sets a time for it means that time.
            _ => source.publishing.is_latched && !is_own,
        };
        let mut held_until = None;
        for (topic, source) in &sources {
            if holds(source) {
                self.held_until.insert((*topic).to_owned(), now.steady);
            }
            held_until = held_until.max(self.held_until.get(*topic).copied());
        }
        if held_until == Some(now.steady) {
            return State::Current(None);
        }
        let name = sources.first().map_or(what, |(_, source)| &source.topic);
        let since_held = held_until.filter(|held| shown.received.is_none_or(|received| *held >= received));
        let age = match (since_held, shown.received) {
            (Some(held), _) => now.steady.saturating_duration_since(held),
            (None, Some(received)) => {
                let since_stamp = age_by_stamp(shown.stamp, now.ros);
                now.steady.saturating_duration_since(received).max(since_stamp)
            }
            // A display that was made anew shows a message of which that is not known: the next one is.
            (None, None) => Duration::MAX,
        };
        let why = || match limit {
            Limit::Held => format!("{what}: nobody publishes {name} any more"),
            _ => format!("{what}: no data on {name} of the last {} s", after.as_secs_f64()),
        };
        state(age, after, now, why)
    }

    /// The state of a frame's place in the fixed frame.
    pub(super) fn frame(&mut self, frame: &str, stage: &impl SceneAges, now: Now) -> State {
        let Some(stamp) = stage.known_until(frame) else { return State::Undated };
        if stamp.is_zero() {
            return State::Undated;
        }
        let known = self.frames.get(frame).copied().filter(|(known, _)| *known == stamp);
        let (_, since) = known.unwrap_or((stamp, now.steady));
        if known.is_none() {
            self.frames.insert(frame.to_owned(), (stamp, since));
        }
        let age = now.steady.saturating_duration_since(since).max(age_by_stamp(stamp, now.ros));
        self.transforms(age, frame, now)
    }

    fn transforms(&self, age: Duration, what: &str, now: Now) -> State {
        match self.limits.of_transforms() {
            None => State::Current(None),
            Some(limit) => {
                state(age, limit, now, || format!("{what}: no transform of the last {} s", limit.as_secs_f64()))
            }
        }
    }
}

/// The state of something of this age, which may be as old as `limit`.
fn state(age: Duration, limit: Duration, now: Now, why: impl FnOnce() -> String) -> State {
    match limit.checked_sub(age) {
        Some(left) => State::Current(now.steady.checked_add(left)),
        None => State::Stale(why()),
    }
}

/// How old a stamp is; zero where it says nothing.
fn age_by_stamp(stamp: Time, now: Time) -> Duration {
    if stamp.is_zero() || now.is_zero() {
        return Duration::ZERO;
    }
    now.saturating_since(stamp)
}

impl Assessment {
    /// What a camera may show.
    pub(super) fn of_camera(&self, view: &CameraView) -> Shown {
        let mut shown = Shown::default();
        let (mut stale, mut is_any_current) = (Vec::new(), false);
        for display in self.displays.iter().filter(|display| view.visible.shows(display.id)) {
            match &display.state {
                State::Undated => {}
                State::Current(until) => {
                    is_any_current = true;
                    shown.until = shown.until.into_iter().chain(*until).min();
                }
                State::Stale(why) => {
                    shown.hidden.push(display.id);
                    stale.push(why.as_str());
                }
            }
        }
        match self.cameras.get(&view.settings.camera_info_topic) {
            Some(State::Stale(why)) => shown.black = Some(Dark::new(Cause::CameraData, why.clone())),
            Some(State::Current(until)) => shown.until = shown.until.into_iter().chain(*until).min(),
            Some(State::Undated) | None => {}
        }
        if shown.black.is_none() && !stale.is_empty() && !is_any_current {
            shown.black = Some(Dark::new(Cause::Displays, stale.join("; ")));
        }
        shown
    }

    /// When the first thing that is current now will not be.
    pub(crate) fn next_change(&self) -> Option<Instant> {
        let states = self.displays.iter().map(|display| &display.state).chain(self.cameras.values());
        let until = |state: &State| match state {
            State::Current(until) => *until,
            State::Undated | State::Stale(_) => None,
        };
        states.filter_map(until).min()
    }

    /// Why a display is not drawn, by its number and its path: what is too old.
    pub(crate) fn why_hidden(&self, id: DisplayId, path: &str) -> Option<&str> {
        let display = self.displays.iter().find(|display| display.id == id && display.path == path)?;
        match &display.state {
            State::Stale(why) => Some(why),
            State::Undated | State::Current(_) => None,
        }
    }
}
