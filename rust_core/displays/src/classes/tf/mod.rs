//! `rviz/TF`: the frames themselves.
//!
//! All frames that any transform ever mentioned are looked at, also the parents that nothing is known of. A frame is
//! as old as the last change of the time at which it can be placed in the fixed frame: what a moving frame carries ages
//! with it, what is static does not age. Frames that grew too old stay in the list, and come back with new transforms.
//!
//! rviz looks at the frames at each of its pictures, or after each "Update Interval". Here they are looked at when
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
use symbol::{Place, Symbol, Symbols};

/// Arrows to parents that are nearer are not shown.
const SHORTEST_ARROW_M: f64 = 0.001;

/// A frame from look to look.
#[derive(Debug)]
struct Frame {
    age: Age,
    is_enabled: bool,
    symbol: Symbol,
}

/// The last look at the frames.
#[derive(Clone, Copy, Debug)]
struct Look {
    at: Time,
    /// What the tree knew then.
    generation: u64,
    /// The tree had changed again when it was too early for another look.
    is_outdated: bool,
    /// When the frames will look different by themselves.
    next_fade: Option<Time>,
}

/// A TF display.
#[derive(Debug)]
pub(crate) struct TfDisplay {
    display: DisplayId,
    settings: TfSettings,
    symbols: Symbols,
    frames: BTreeMap<String, Frame>,
    last_look: Option<Look>,
    drawables: Vec<Drawable>,
    statuses: Statuses,
}

impl TfDisplay {
    pub(crate) fn new(display: DisplayId, settings: TfSettings) -> Self {
        Self {
            display,
            symbols: Symbols::new(&settings),
            settings,
            frames: BTreeMap::new(),
            last_look: None,
            drawables: Vec::new(),
            statuses: Statuses::default(),
        }
    }

    /// The next time after a look at which there may be another one. Within the same instant all is looked at again:
    /// there, a bag may hold many messages.
    fn interval(&self) -> Duration {
        Duration::try_from_secs_f32(self.settings.update_interval_s).unwrap_or(Duration::MAX)
    }

    fn is_due(&mut self, world: &World<'_>) -> bool {
        let interval = self.interval();
        let Some(look) = &mut self.last_look else { return true };
        let has_new_frames = world.transforms.frames().count() > self.frames.len();
        let is_outdated = look.generation != world.transforms.generation();
        let is_free = world.now <= look.at || world.now >= look.at.saturating_add(interval);
        look.is_outdated = is_outdated;
        has_new_frames || is_free && (is_outdated || look.next_fade.is_some_and(|fade| fade <= world.now))
    }
}

/// Where a frame and the arrow to its parent are now; `None` where it cannot be placed.
fn place(name: &str, world: &World<'_>) -> Option<Place> {
    let fixed_from_frame = world.fixed_from(name, Time::ZERO).ok()?;
    let to_parent_m = world.transforms.parent_of(name, Time::ZERO).and_then(|parent| {
        // rviz takes the origin for the place of a parent that cannot be found.
        let parent = world.fixed_from(parent, Time::ZERO).map_or_else(|_| Vector3::zeros(), |p| p.translation.vector);
        let to_parent = parent - fixed_from_frame.translation.vector;
        (to_parent.norm() > SHORTEST_ARROW_M).then_some(to_parent)
    });
    Some(Place { fixed_from_frame, to_parent_m })
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
                let is_enabled = !self.settings.hidden_frames.contains(name);
                let frame = Frame { age: Age::new(world.now), is_enabled, symbol: Symbol::default() };
                self.frames.insert(name.to_owned(), frame);
            }
            let Some(frame) = self.frames.get_mut(name) else { continue };
            let common_time = world.transforms.latest_common_time(world.fixed_frame, name).ok();
            frame.age.hear(common_time.unwrap_or(Time::ZERO), world.now);
            let fade = frame.age.fade(world.now, timeout);
            if fade == Fade::Gone {
                // As rviz does, what was said of the frame last stays.
                changed |= frame.symbol.hide();
                continue;
            }
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
        self.last_look = Some(Look { at: world.now, generation, is_outdated: false, next_fade });
        if changed {
            self.drawables = self.frames.values().flat_map(|frame| frame.symbol.drawables()).cloned().collect();
        }
        changed
    }

    fn drawables(&self) -> &[Drawable] {
        &self.drawables
    }

    fn next_change(&self) -> Option<Time> {
        let look = self.last_look.as_ref()?;
        let earliest = look.at.saturating_add(self.interval());
        if look.is_outdated {
            return Some(earliest);
        }
        look.next_fade.map(|fade| fade.max(earliest))
    }

    fn reset(&mut self) {
        self.frames.clear();
        self.last_look = None;
        self.drawables.clear();
        self.statuses.clear();
    }

    fn statuses(&self) -> &Statuses {
        &self.statuses
    }
}
