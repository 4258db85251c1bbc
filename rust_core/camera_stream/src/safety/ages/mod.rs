//! Stale data: which displays and cameras are too old to be shown.
//!
//! The age of data is the longer of two: since their stamp, by ROS time, and since they were received, by the
//! computer's clock, so that neither a wrong clock nor a simulation that stands still makes old data look new. Messages
//! of a latching publisher do not age while its connection, which sent the last one, is open: they are not sent again.
//! That is for displays and CameraInfos only; see [`rcs_light::Measured`] for measurements. A display that follows a
//! frame is as old as the frame's transforms as well, and stale while there are none: static ones do not age, and
//! moving ones are as old as the oldest on the path to the fixed frame. A display without data, such as a grid in the
//! fixed frame, is neither current nor stale.

pub(crate) mod limits;
#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::time::{Duration, Instant};

use rcs_displays::{CameraView, DisplayAge, FollowedFrames, ShownMessage};
use rcs_light::{Condition, Now};
use rcs_messages::MessageKind;
use rcs_ros::Publishing;
use rcs_scene::DisplayId;
use rcs_transforms::Time;

use self::limits::{AgeLimit, AgeLimits};
use crate::scene::SceneState;

/// The publishers of a subscribed topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct TopicSource {
    /// The topic's whole name.
    pub(crate) topic: String,
    /// Connections, and whether the one that sent the last message latches.
    pub(crate) publishing: Publishing,
}

/// Tracks the ages of displays, cameras and frames.
#[derive(Debug)]
pub(super) struct Freshness {
    limits: AgeLimits,
    /// Last time at which a publisher held the data of a topic; by its name in the config.
    held_until: HashMap<String, Instant>,
    /// The newest time at which a frame is known, and when that was first seen.
    frames: HashMap<String, (Time, Instant)>,
    /// Arrival of the last moving transforms.
    transforms_received: Option<Instant>,
}

/// Age of data against their limit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum AgeState {
    /// No data that could age, or none yet.
    Undated,
    /// Current until then, if nothing new arrives; for ever if the data do not age.
    Current(Option<Instant>),
    /// Too old; says what, and the limit.
    Stale(String),
}

/// The state of a display.
#[derive(Clone, Debug)]
struct DisplayState {
    id: DisplayId,
    /// The names of the groups around it and its own.
    path: String,
    state: AgeState,
}

/// The states of all displays and cameras at one moment.
#[derive(Clone, Debug, Default)]
pub(crate) struct Assessment {
    displays: Vec<DisplayState>,
    cameras: HashMap<String, AgeState>,
}

/// The ages of everything that one camera shows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct CameraAges {
    /// Stale displays.
    pub(super) hidden: Vec<DisplayId>,
    /// Of the displays together: dark if all that have data are stale.
    pub(super) displays: Condition,
    /// Of the CameraInfo and the camera's frame.
    pub(super) camera: Condition,
}

impl AgeState {
    /// What it means for the light. Without data there is nothing that could be too old.
    pub(super) fn condition(&self) -> Condition {
        match self {
            Self::Undated | Self::Current(None) => Condition::Always,
            Self::Current(Some(until)) => Condition::Until(*until),
            Self::Stale(why) => Condition::Dark(why.clone()),
        }
    }

    /// The worse of two: stale before current, current before undated; the sooner end.
    pub(super) fn and(self, other: Self) -> Self {
        match (self, other) {
            (Self::Stale(why), _) | (_, Self::Stale(why)) => Self::Stale(why),
            (Self::Undated, state) | (state, Self::Undated) => state,
            (Self::Current(a), Self::Current(b)) => Self::Current(a.into_iter().chain(b).min()),
        }
    }
}

impl Freshness {
    /// `None` where nothing becomes stale.
    pub(super) fn new(limits: AgeLimits) -> Option<Self> {
        let (held_until, frames) = (HashMap::new(), HashMap::new());
        (!limits.is_off()).then_some(Self { limits, held_until, frames, transforms_received: None })
    }

    /// Records that transforms of moving frames were received.
    pub(super) fn note_transforms(&mut self, received: Instant) {
        self.transforms_received = Some(received);
    }

    /// Forgets the ages of frames: the time jumped back.
    pub(super) fn reset(&mut self) {
        self.frames.clear();
        self.transforms_received = None;
    }

    /// The state of each display and camera. `source` says who publishes a topic, by its name in the config and type.
    pub(super) fn assess(
        &mut self,
        scene: &SceneState,
        source: impl Fn(&str, MessageKind) -> Option<TopicSource>,
        now: Now,
    ) -> Assessment {
        let mut displays = Vec::new();
        for age in scene.ages() {
            let path = age.path.join(" / ");
            let state = self.display(&age, &path, scene, &source, now);
            displays.push(DisplayState { id: age.id, path, state });
        }
        let mut cameras = HashMap::new();
        for topic in scene.camera_info_topics() {
            if !cameras.contains_key(topic) {
                cameras.insert(topic.to_owned(), self.camera(topic, scene, &source, now));
            }
        }
        Assessment { displays, cameras }
    }

    fn display(
        &mut self,
        age: &DisplayAge<'_>,
        path: &str,
        scene: &SceneState,
        source: &impl Fn(&str, MessageKind) -> Option<TopicSource>,
        now: Now,
    ) -> AgeState {
        if age.is_empty {
            return AgeState::Undated;
        }
        let topics = age.topics.iter().map(|request| (request.topic.as_str(), request.kind));
        let data = match age.current {
            Some(shown) => self.data(path, topics, shown, source, now),
            None => AgeState::Undated,
        };
        data.and(self.followed(age.follows, scene, now))
    }

    /// The state of the frames that a display follows.
    fn followed(&mut self, frames: &FollowedFrames, scene: &SceneState, now: Now) -> AgeState {
        let all = match self.transforms_received.filter(|_| frames.is_all()) {
            Some(received) => self.transforms(now.steady.saturating_duration_since(received), "transforms", now),
            None => AgeState::Undated,
        };
        frames.names().map(|frame| self.followed_frame(frame, scene, now)).fold(all, AgeState::and)
    }

    /// The state of a frame that a display follows. While its place is unknown, it ages since it was last known; one
    /// that was never known is stale.
    fn followed_frame(&mut self, frame: &str, scene: &SceneState, now: Now) -> AgeState {
        if scene.known_until(frame).is_some() {
            return self.frame(frame, scene, now);
        }
        let age = self.frames.get(frame).map_or(Duration::MAX, |(stamp, since)| {
            now.steady.saturating_duration_since(*since).max(age_by_stamp(*stamp, now.ros))
        });
        self.transforms(age, frame, now)
    }

    /// The worse state of a camera's CameraInfo and of its frame. Undated before its first CameraInfo.
    fn camera(
        &mut self,
        topic: &str,
        scene: &SceneState,
        source: &impl Fn(&str, MessageKind) -> Option<TopicSource>,
        now: Now,
    ) -> AgeState {
        let Some((frame, shown)) = scene.received_camera_info(topic) else { return AgeState::Undated };
        let data = self.data("CameraInfo", [(topic, MessageKind::CameraInfo)], shown, source, now);
        data.and(self.frame(frame, scene, now))
    }

    /// The state of data that come on these topics.
    fn data<'t>(
        &mut self,
        what: &str,
        topics: impl IntoIterator<Item = (&'t str, MessageKind)>,
        shown: ShownMessage,
        source: &impl Fn(&str, MessageKind) -> Option<TopicSource>,
        now: Now,
    ) -> AgeState {
        let sources: Vec<(&str, TopicSource)> =
            topics.into_iter().filter_map(|(topic, kind)| Some((topic, source(topic, kind)?))).collect();
        let (limit, is_own) = self.limits.of(sources.iter().map(|(_, source)| source.topic.as_str()));
        let after = match limit {
            AgeLimit::Never => return AgeState::Current(None),
            AgeLimit::After(after) => after,
            AgeLimit::Held => Duration::ZERO,
        };
        let holds = |source: &TopicSource| match limit {
            AgeLimit::Held => source.publishing.is_connected,
            // A limit of the topic's own counts instead.
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
            return AgeState::Current(None);
        }
        let name = sources.first().map_or(what, |(_, source)| &source.topic);
        let since_held = held_until.filter(|held| shown.received.is_none_or(|received| *held >= received));
        let age = match (since_held, shown.received) {
            (Some(held), _) => now.steady.saturating_duration_since(held),
            (None, Some(received)) => {
                let since_stamp = age_by_stamp(shown.stamp, now.ros);
                now.steady.saturating_duration_since(received).max(since_stamp)
            }
            // A display that was made anew shows a message whose arrival is unknown.
            (None, None) => Duration::MAX,
        };
        let why = || match limit {
            AgeLimit::Held => format!("{what}: nobody publishes {name} any more"),
            _ => format!("{what}: no data on {name} of the last {} s", after.as_secs_f64()),
        };
        state(age, after, now, why)
    }

    /// The state of a frame's place in the fixed frame.
    pub(super) fn frame(&mut self, frame: &str, scene: &SceneState, now: Now) -> AgeState {
        let Some(stamp) = scene.known_until(frame) else { return AgeState::Undated };
        if stamp.is_zero() {
            return AgeState::Undated;
        }
        let known = self.frames.get(frame).copied().filter(|(known, _)| *known == stamp);
        let (_, since) = known.unwrap_or((stamp, now.steady));
        if known.is_none() {
            self.frames.insert(frame.to_owned(), (stamp, since));
        }
        let age = now.steady.saturating_duration_since(since).max(age_by_stamp(stamp, now.ros));
        self.transforms(age, frame, now)
    }

    fn transforms(&self, age: Duration, what: &str, now: Now) -> AgeState {
        match self.limits.of_transforms() {
            None => AgeState::Current(None),
            Some(limit) => {
                state(age, limit, now, || format!("{what}: no transform of the last {} s", limit.as_secs_f64()))
            }
        }
    }
}

/// The state of data of this age, which may be as old as `limit`.
fn state(age: Duration, limit: Duration, now: Now, why: impl FnOnce() -> String) -> AgeState {
    match limit.checked_sub(age) {
        Some(left) => AgeState::Current(now.steady.checked_add(left)),
        None => AgeState::Stale(why()),
    }
}

/// Age of a stamp; zero if either time is zero.
fn age_by_stamp(stamp: Time, now: Time) -> Duration {
    if stamp.is_zero() || now.is_zero() {
        return Duration::ZERO;
    }
    now.saturating_since(stamp)
}

impl Assessment {
    /// The ages of everything that a camera shows.
    pub(super) fn of_camera(&self, view: &CameraView) -> CameraAges {
        let (mut hidden, mut stale, mut all) = (Vec::new(), Vec::new(), AgeState::Undated);
        for display in self.displays.iter().filter(|display| view.visible.shows(display.id)) {
            match &display.state {
                AgeState::Stale(why) => {
                    hidden.push(display.id);
                    stale.push(why.as_str());
                }
                state => all = all.and(state.clone()),
            }
        }
        if !stale.is_empty() && all == AgeState::Undated {
            all = AgeState::Stale(stale.join("; "));
        }
        let camera = self.cameras.get(&view.settings.camera_info_topic).unwrap_or(&AgeState::Undated);
        CameraAges { hidden, displays: all.condition(), camera: camera.condition() }
    }

    /// Time at which the next data become stale.
    pub(crate) fn next_change(&self) -> Option<Instant> {
        let states = self.displays.iter().map(|display| &display.state).chain(self.cameras.values());
        let until = |state: &AgeState| match state {
            AgeState::Current(until) => *until,
            AgeState::Undated | AgeState::Stale(_) => None,
        };
        states.filter_map(until).min()
    }

    /// Why a display is not drawn, by its number and its path.
    pub(crate) fn why_hidden(&self, id: DisplayId, path: &str) -> Option<&str> {
        let display = self.displays.iter().find(|display| display.id == id && display.path == path)?;
        match &display.state {
            AgeState::Stale(why) => Some(why),
            AgeState::Undated | AgeState::Current(_) => None,
        }
    }
}
