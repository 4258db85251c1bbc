//! Eye safety: masks on topics, and keep-out spheres around frames.
//!
//! Both age like the data of displays ([`super::ages`]), after a second where nothing else is set. A missing or stale
//! one makes all black, unless it is not required: then the last mask and the last place hold.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use nalgebra::Point3;
use rcs_camera::NoLens;
use rcs_displays::{time_from_stamp, ShownMessage};
use rcs_messages::{Image, MessageKind};
use rcs_render::{LightMask, Sphere};

use super::ages::limits::AgeLimits;
use super::ages::{AgeState, Freshness, Now, TopicSource};
use super::causes::{DarkCause, DarkReason};
use super::mask_image::light_mask;
use super::rules::KeepOutFrame;
use crate::scene::SceneState;

/// Age at which masks and keep-out frames are stale, where no other limit is set for all topics.
pub(super) const EYE_SAFETY_LIMIT: Duration = Duration::from_secs(1);

/// The last mask of a topic.
#[derive(Debug, Default)]
struct MaskTopic {
    last: Option<Arc<LightMask>>,
    received: Option<ShownMessage>,
    /// Why the last message is invalid.
    problem: Option<String>,
}

/// The masks and keep-out frames of all cameras.
#[derive(Debug)]
pub(super) struct EyeSafety {
    /// By the topic's whole name.
    masks: BTreeMap<String, MaskTopic>,
    keep_out: Vec<KeepOutFrame>,
    is_required: bool,
    ages: Option<Freshness>,
}

/// Blackout of a camera's images for the sake of eyes.
#[derive(Debug, Default)]
pub(super) struct EyeSafetyState {
    pub(super) dark_reason: Option<DarkReason>,
    /// End of this if nothing new arrives.
    pub(super) until: Option<Instant>,
}

/// The spheres around keep-out frames, as far as their places are known.
pub(super) struct KeepOutSpheres {
    pub(super) known: Vec<Sphere>,
    state: AgeState,
}

impl KeepOutSpheres {
    pub(super) fn none() -> Self {
        Self { known: Vec::new(), state: AgeState::Undated }
    }
}

impl EyeSafety {
    pub(super) fn new<'t>(
        topics: impl Iterator<Item = &'t String>,
        keep_out: Vec<KeepOutFrame>,
        is_required: bool,
        limits: AgeLimits,
    ) -> Self {
        let masks = topics.map(|topic| (topic.clone(), MaskTopic::default())).collect();
        Self { masks, keep_out, is_required, ages: Freshness::new(limits.or_after(EYE_SAFETY_LIMIT)) }
    }

    pub(super) fn is_some(&self) -> bool {
        !self.masks.is_empty() || !self.keep_out.is_empty()
    }

    /// `true` if there are keep-out frames, which count for all cameras.
    pub(super) fn has_keep_out(&self) -> bool {
        !self.keep_out.is_empty()
    }

    /// Forgets the ages of frames: the time jumped back.
    pub(super) fn reset(&mut self) {
        self.ages.iter_mut().for_each(Freshness::reset);
    }

    /// Takes an image, if its topic is a mask's.
    pub(super) fn take(&mut self, topic: &str, image: &Image, received: Instant) {
        let Some(mask) = self.masks.get_mut(topic) else { return };
        let problem = match light_mask(image) {
            Ok(light) => {
                // An equal one keeps images that were drawn with the last.
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

    pub(super) fn mask(&self, topic: &str) -> Option<Arc<LightMask>> {
        self.masks.get(topic)?.last.clone()
    }

    /// The states of all masks, by topic.
    pub(super) fn mask_states(
        &mut self,
        source: &impl Fn(&str, MessageKind) -> Option<TopicSource>,
        now: Now,
    ) -> BTreeMap<String, AgeState> {
        let Self { masks, ages: Some(ages), .. } = self else { return BTreeMap::new() };
        let state = |(topic, mask): (&String, &MaskTopic)| {
            let state = match (mask.received, &mask.problem) {
                (None, Some(problem)) => AgeState::Stale(problem.clone()),
                (None, None) => AgeState::Stale(format!("no mask on {topic} yet")),
                (Some(received), _) => ages.data("mask", [(topic.as_str(), MessageKind::Image)], received, source, now),
            };
            (topic.clone(), state)
        };
        masks.iter().map(state).collect()
    }

    pub(super) fn spheres(&mut self, scene: &SceneState, now: Now) -> KeepOutSpheres {
        let (mut known, mut state) = (Vec::new(), AgeState::Undated);
        for KeepOutFrame { frame, radius_m } in &self.keep_out {
            let place: Option<Point3<f64>> = scene.place_of(frame);
            match (place, &mut self.ages) {
                (None, _) => {
                    state = state.and(AgeState::Stale(format!("keep-out frame {frame}: its place is not known")));
                }
                (Some(_), Some(ages)) => state = state.and(ages.frame(frame, scene, now)),
                (Some(_), None) => {}
            }
            known.extend(place.map(|center| Sphere { center, radius_m: *radius_m }));
        }
        KeepOutSpheres { known, state }
    }

    /// Decides whether a camera must be dark, by the state of its mask and why its lens is unknown, if it is.
    pub(super) fn forbidden(
        &self,
        mask: Option<&AgeState>,
        spheres: &KeepOutSpheres,
        lens: Option<NoLens>,
    ) -> EyeSafetyState {
        if !self.is_required {
            return EyeSafetyState::default();
        }
        let lens = lens.filter(|_| !spheres.known.is_empty()).map_or(AgeState::Undated, |why| {
            AgeState::Stale(format!("where the lens sends light around keep-out frames is not known: {why}"))
        });
        let mask = mask.cloned().unwrap_or(AgeState::Undated);
        let causes = [(DarkCause::Mask, &mask), (DarkCause::KeepOut, &spheres.state), (DarkCause::Lens, &lens)];
        let dark_reason = causes.into_iter().find_map(|(cause, state)| match state {
            AgeState::Stale(why) => Some(DarkReason::new(cause, why.clone())),
            AgeState::Undated | AgeState::Current(_) => None,
        });
        let until = match mask.and(spheres.state.clone()) {
            AgeState::Current(until) => until,
            AgeState::Undated | AgeState::Stale(_) => None,
        };
        EyeSafetyState { dark_reason, until }
    }
}
