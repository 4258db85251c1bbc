//! `rviz/TF`: the frames themselves.
//!
//! All frames that any transform ever named are shown, parents without a transform of their own included. A frame is
//! as old as the last change of the time at which it can be placed in the fixed frame: what a moving frame carries ages
//! with it, what is static does not age. Frames that grew too old stay in the list, and come back with new transforms;
//! until then they cost next to nothing.
//!
//! rviz updates the frames with each of its images, or after each "Update Interval". Here they are updated when
//! transforms came and, while frames fade, as often as it can be seen.

mod age;
mod symbol;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::time::Duration;

use nalgebra::Vector3;
use rcs_rviz_config::TfSettings;
use rcs_scene::{DisplayId, Drawable};
use rcs_transforms::Time;

use crate::framework::display::Display;
use crate::{Level, StatusText, Statuses, World};

use age::{Age, Fade};
use symbol::{FramePlace, Symbol, Symbols};

/// Period of lookups of frames that are too old.
const GONE_CHECK_PERIOD: Duration = Duration::from_secs(1);
/// Length below which arrows to parents are not shown.
const SHORTEST_ARROW_M: f64 = 0.001;

#[derive(Debug)]
struct ShownFrame {
    age: Age,
    /// `true` if the filters accept it. Other frames have neither a symbol nor a status.
    is_listed: bool,
    is_enabled: bool,
    symbol: Symbol,
    /// Set while it is too old to be visible.
    gone: Option<Gone>,
}

/// Lookup of a frame that is too old to be visible.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Gone {
    newest: Option<Time>,
    checked_at: Time,
}

impl Gone {
    /// `true` if it cannot be back: it has no new transform, and its parents were looked up a moment ago.
    fn is_certain(self, newest: Option<Time>, now: Time) -> bool {
        self.newest == newest && now >= self.checked_at && now < self.checked_at.saturating_add(GONE_CHECK_PERIOD)
    }
}

#[derive(Clone, Copy, Debug)]
struct LastUpdate {
    at: Time,
    generation: u64,
    /// The tree changed again when it was too early for another update.
    is_outdated: bool,
    next_fade: Option<Time>,
}

#[derive(Debug)]
pub(crate) struct TfDisplay {
    display: DisplayId,
    settings: TfSettings,
    symbols: Symbols,
    frames: BTreeMap<String, ShownFrame>,
    last_update: Option<LastUpdate>,
    drawables: Vec<Drawable>,
    statuses: Statuses,
}

pub(crate) fn create(display: DisplayId, settings: &TfSettings) -> TfDisplay {
    TfDisplay {
        display,
        symbols: Symbols::new(settings),
        settings: settings.clone(),
        frames: BTreeMap::new(),
        last_update: None,
        drawables: Vec::new(),
        statuses: Statuses::default(),
    }
}

impl TfDisplay {
    /// Shortest time between two updates. Within the same instant all is updated again: there, a bag may hold many
    /// messages.
    fn interval(&self) -> Duration {
        Duration::try_from_secs_f32(self.settings.update_interval_s).unwrap_or(Duration::MAX)
    }

    fn is_due(&mut self, world: &World<'_>) -> bool {
        let interval = self.interval();
        let Some(last) = &mut self.last_update else { return true };
        let has_new_frames = world.transforms.frames().count() > self.frames.len();
        let is_outdated = last.generation != world.transforms.generation() || world.prediction.is_some();
        let is_free = world.now <= last.at || world.now >= last.at.saturating_add(interval);
        last.is_outdated = is_outdated;
        has_new_frames || is_free && (is_outdated || last.next_fade.is_some_and(|fade| fade <= world.now))
    }
}

/// Poses of a frame and of the arrow to its parent; `None` where it cannot be placed.
fn place(name: &str, world: &World<'_>) -> Option<FramePlace> {
    let fixed_from_frame = world.fixed_from_each(name).ok()?;
    let to_parent_m = world.transforms.parent_of(name, Time::ZERO).and_then(|parent| {
        // rviz takes the origin for the place of a parent that cannot be found.
        let parent = world.fixed_from_each(parent).map_or_else(|_| Vector3::zeros(), |p| p.translation.vector);
        let to_parent = parent - fixed_from_frame.translation.vector;
        (to_parent.norm() > SHORTEST_ARROW_M).then_some(to_parent)
    });
    Some(FramePlace { fixed_from_frame, to_parent_m })
}

impl Display for TfDisplay {
    fn update(&mut self, world: &World<'_>) -> bool {
        if !self.is_due(world) {
            return false;
        }
        let timeout = Duration::try_from_secs_f32(self.settings.frame_timeout_s).unwrap_or(Duration::MAX);
        let mut changed = false;
        let mut next_fade: Option<Time> = None;
        for name in world.transforms.frames() {
            if !self.frames.contains_key(name) {
                let frame = ShownFrame {
                    age: Age::new(world.now),
                    is_listed: self.settings.lists(name),
                    is_enabled: !self.settings.hidden_frames.contains(name),
                    symbol: Symbol::default(),
                    gone: None,
                };
                self.frames.insert(name.to_owned(), frame);
            }
            let Some(frame) = self.frames.get_mut(name).filter(|frame| frame.is_listed) else { continue };
            let newest = world.transforms.newest_stamp_of(name);
            if frame.gone.is_some_and(|gone| gone.is_certain(newest, world.now)) {
                continue;
            }
            let common_time = world.transforms.latest_common_time(world.fixed_frame, name).ok();
            frame.age.update(common_time.unwrap_or(Time::ZERO), world.now);
            let fade = frame.age.fade(world.now, timeout);
            if fade == Fade::Gone {
                // As in rviz, the frame keeps its last status.
                changed |= frame.symbol.hide();
                frame.gone = Some(Gone { newest, checked_at: world.now });
                continue;
            }
            frame.gone = None;
            let place = place(name, world);
            if place.is_some() {
                self.statuses.set(Level::Ok, name, "Transform OK");
            } else {
                let text = format!("No transform from [{name}] to frame [{}]", world.fixed_frame);
                self.statuses.set(Level::Warn, name, StatusText::about_frame(text));
            }
            match place.filter(|_| frame.is_enabled) {
                Some(place) => {
                    changed |= frame.symbol.show(self.display, name, place, fade, &self.symbols);
                    next_fade = next_fade.into_iter().chain(frame.age.next_change(world.now, timeout)).min();
                }
                None => changed |= frame.symbol.hide(),
            }
        }
        let generation = world.transforms.generation();
        self.last_update = Some(LastUpdate { at: world.now, generation, is_outdated: false, next_fade });
        if changed {
            self.drawables = self.frames.values().flat_map(|frame| frame.symbol.drawables()).cloned().collect();
        }
        changed
    }

    fn drawables(&self) -> &[Drawable] {
        &self.drawables
    }

    fn next_change(&self) -> Option<Time> {
        let last = self.last_update.as_ref()?;
        let earliest = last.at.saturating_add(self.interval());
        if last.is_outdated {
            return Some(earliest);
        }
        last.next_fade.map(|fade| fade.max(earliest))
    }

    fn reset(&mut self) {
        self.frames.clear();
        self.last_update = None;
        self.drawables.clear();
        self.statuses.clear();
    }

    fn statuses(&self) -> &Statuses {
        &self.statuses
    }
}
