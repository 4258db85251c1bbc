//! Where light is forbidden for the sake of eyes: masks on topics, and spheres around frames.
//!
//! Both age like the data of displays ([`super::ages`]), after a second where nothing else is set. What is missing or
//! too old makes all black, unless it is not required: then the last mask and the last place hold.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use nalgebra::Point3;
use rcs_camera::NoLens;
use rcs_displays::{time_from_stamp, ShownMessage};
use rcs_messages::{Image, MessageKind};
use rcs_render::{LightMask, Sphere};

use super::ages::limits::Limits;
use super::ages::{Freshness, Now, SceneAges, Source, State};
use super::causes::{Cause, Dark};
use super::mask_image::light_mask;
use super::rules::KeepOutFrame;

/// When masks and keep-out frames are too old, where no other limit is set for all topics.
pub(super) const EYE_SAFETY_LIMIT: Duration = Duration::from_secs(1);

/// A topic of masks, and the last of them.
#[derive(Debug, Default)]
struct Mask {
    last: Option<Arc<LightMask>>,
    received: Option<ShownMessage>,
    /// Why the last message is no mask.
    problem: Option<String>,
}

/// The masks and keep-out frames as they are known.
#[derive(Debug)]
pub(super) struct Eyes {
    /// By the topic's whole name.
    masks: BTreeMap<String, Mask>,
    keep_out: Vec<KeepOutFrame>,
    is_required: bool,
    ages: Option<Freshness>,
}

/// Blackout of a camera's images, as far as it is known.
#[derive(Debug, Default)]
pub(super) struct Forbidden {
    /// Why nothing may be lit.
    pub(super) dark: Option<Dark>,
    /// Until when this holds if nothing new arrives.
    pub(super) until: Option<Instant>,
}

/// Where the keep-out frames are.
pub(super) struct Spheres {
    pub(super) known: Vec<Sphere>,
    state: State,
}

impl Spheres {
    /// There are none.
    pub(super) fn none() -> Self {
        Self { known: Vec::new(), state: State::Undated }
    }
}

impl Eyes {
    /// Nothing has come yet.
    pub(super) fn new<'t>(
        topics: impl Iterator<Item = &'t String>,
        keep_out: Vec<KeepOutFrame>,
        is_required: bool,
        limits: Limits,
    ) -> Self {
        let masks = topics.map(|topic| (topic.clone(), Mask::default())).collect();
        Self { masks, keep_out, is_required, ages: Freshness::new(limits.or_after(EYE_SAFETY_LIMIT)) }
    }

    /// Whether a mask's topic or keep-out frames are configured.
    pub(super) fn is_some(&self) -> bool {
        !self.masks.is_empty() || !self.keep_out.is_empty()
    }

    /// Whether there are keep-out frames, which are those of all cameras.
    pub(super) fn has_keep_out(&self) -> bool {
        !self.keep_out.is_empty()
    }

    /// Forgets what it knows of frames: the time jumped back.
    pub(super) fn reset(&mut self) {
        self.ages.iter_mut().for_each(Freshness::reset);
    }

    /// Takes an image, if its topic is a mask's.
    pub(super) fn take(&mut self, topic: &str, image: &Image, received: Instant) {
        let Some(mask) = self.masks.get_mut(topic) else { return };
        let problem = match light_mask(image) {
            Ok(light) => {
                // One that says the same again keeps images that were drawn with it.
                if mask.last.as_deref() != Some(&light) {
                    mask.last = Some(Arc::new(light));
                }
                let stamp = time_from_stamp(image.header.stamp);
                mask.received = Some(ShownMessage { stamp, received: Some(received) });
                None
            }
            Err(problem) => Some(format!("mask on {topic}: {problem}")),
        };
        if let Some(problem) = problem.as_ref().filter(|problem| mask.problem.as_ref() != Some(problem)) {
            log::error!("{problem}");
        }
        mask.problem = problem;
    }

    /// The last mask of a topic.
    pub(super) fn mask(&self, topic: &str) -> Option<Arc<LightMask>> {
        self.masks.get(topic)?.last.clone()
    }

    /// The states of all masks, by topic.
    pub(super) fn mask_states(
        &mut self,
        source: &impl Fn(&str, MessageKind) -> Option<Source>,
        now: Now,
    ) -> BTreeMap<String, State> {
        let Self { masks, ages: Some(ages), .. } = self else { return BTreeMap::new() };
        let state = |(topic, mask): (&String, &Mask)| {
            let state = match (mask.received, &mask.problem) {
                (None, Some(problem)) => State::Stale(problem.clone()),
                (None, None) => State::Stale(format!("no mask on {topic} yet")),
                (Some(received), _) => ages.data("mask", [(topic.as_str(), MessageKind::Image)], received, source, now),
            };
            (topic.clone(), state)
        };
        masks.iter().map(state).collect()
    }

    /// Where no light may be, as far as that is known.
    pub(super) fn spheres(&mut self, scene: &impl SceneAges, now: Now) -> Spheres {
        let (mut known, mut state) = (Vec::new(), State::Undated);
        for KeepOutFrame { frame, radius_m } in &self.keep_out {
            let place: Option<Point3<f64>> = scene.place_of(frame);
            match (place, &mut self.ages) {
                (None, _) => state = state.and(State::Stale(format!("keep-out frame {frame}: its place is not known"))),
                (Some(_), Some(ages)) => state = state.and(ages.frame(frame, scene, now)),
                (Some(_), None) => {}
            }
            known.extend(place.map(|center| Sphere { center, radius_m: *radius_m }));
        }
        Spheres { known, state }
    }

    /// Whether a camera must be dark: with the state of its mask, and why its lens is unknown if it is.
    pub(super) fn forbidden(&self, mask: Option<&State>, spheres: &Spheres, lens: Option<NoLens>) -> Forbidden {
        if !self.is_required {
            return Forbidden::default();
        }
        let lens = lens.filter(|_| !spheres.known.is_empty()).map_or(State::Undated, |why| {
            State::Stale(format!("where the lens sends light around keep-out frames is not known: {why}"))
        });
        let mask = mask.cloned().unwrap_or(State::Undated);
        let causes = [(Cause::Mask, &mask), (Cause::KeepOut, &spheres.state), (Cause::Lens, &lens)];
        let dark = causes.into_iter().find_map(|(cause, state)| match state {
            State::Stale(why) => Some(Dark::new(cause, why.clone())),
            State::Undated | State::Current(_) => None,
        });
        let until = match mask.and(spheres.state.clone()) {
            State::Current(until) => until,
            State::Undated | State::Stale(_) => None,
        };
        Forbidden { dark, until }
    }
}
