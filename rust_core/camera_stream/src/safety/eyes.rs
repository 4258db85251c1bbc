//! Eye safety: masks on topics, and keep-out spheres around frames.
//!
//! Both are measurements, which age ([`Measured`]), after a second where nothing else is set. Each publisher of a
//! mask's topic has a mask of its own, and the darkest counts; one that is missing, invalid or stale makes all black,
//! until the master does not list its publisher any more. Where masks are not required, the last mask and the last
//! place hold.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::{Duration, Instant};

use nalgebra::Point3;
use rcs_camera::NoLens;
use rcs_displays::time_from_stamp;
use rcs_light::{Condition, Measured, Now};
use rcs_messages::Image;
use rcs_render::{LightMask, Sphere};
use rcs_transforms::Time;

use super::ages::limits::AgeLimits;
use super::ages::Freshness;
use super::mask_image::light_mask;
use super::rules::KeepOutFrame;
use crate::scene::SceneState;

/// Age at which masks and keep-out frames are stale, where no other limit is set for all topics.
pub(super) const EYE_SAFETY_LIMIT: Duration = Duration::from_secs(1);

/// The last mask of a publisher, or why its last message is none.
#[derive(Debug)]
struct ReceivedMask {
    mask: Result<Arc<LightMask>, String>,
    measured: Measured,
}

/// The masks of a topic, by publisher.
type Masks = BTreeMap<Arc<str>, ReceivedMask>;

/// The publishers of a mask's topic.
#[derive(Clone, Debug, Default)]
pub(crate) struct MaskPublishers {
    /// Names of the nodes.
    pub(crate) names: BTreeSet<Arc<str>>,
    /// The time for which the master's list is known.
    pub(crate) listed_at: Option<Instant>,
}

/// The masks and keep-out frames of all cameras.
#[derive(Debug)]
pub(super) struct EyeSafety {
    /// By the topic's whole name.
    masks: BTreeMap<String, Masks>,
    keep_out: Vec<KeepOutFrame>,
    is_required: bool,
    limits: AgeLimits,
    frame_limit: Duration,
    /// Of keep-out frames.
    ages: Option<Freshness>,
}

/// The spheres around keep-out frames, as far as their places are known.
pub(super) struct KeepOutSpheres {
    pub(super) known: Vec<Sphere>,
    pub(super) condition: Condition,
}

impl EyeSafety {
    pub(super) fn new<'t>(
        topics: impl Iterator<Item = &'t String>,
        keep_out: Vec<KeepOutFrame>,
        is_required: bool,
        limits: AgeLimits,
    ) -> Self {
        let masks: BTreeMap<_, _> = topics.map(|topic| (topic.clone(), Masks::new())).collect();
        for topic in masks.keys().filter(|topic| limits.is_endless(topic)) {
            log::warn!("{topic}: masks always age: its limit is ignored; set ~mask_required to false to keep the last");
        }
        let frame_limit = limits.of_measured_frames(EYE_SAFETY_LIMIT);
        let ages = Freshness::new(AgeLimits::general(frame_limit));
        Self { masks, keep_out, is_required, limits, frame_limit, ages }
    }

    pub(super) fn is_some(&self) -> bool {
        !self.masks.is_empty() || !self.keep_out.is_empty()
    }

    /// `true` if there are keep-out frames, which count for all cameras.
    pub(super) fn has_keep_out(&self) -> bool {
        !self.keep_out.is_empty()
    }

    /// Forgets all measurements: the time jumped back.
    pub(super) fn reset(&mut self) {
        self.ages.iter_mut().for_each(Freshness::reset);
        self.masks.values_mut().for_each(Masks::clear);
    }

    /// Takes a publisher's image, if its topic is a mask's.
    pub(super) fn take(&mut self, topic: &str, image: &Image, publisher: &Arc<str>, received: Instant) {
        let Some(masks) = self.masks.get_mut(topic) else { return };
        let measured = Measured { stamp: time_from_stamp(image.header.stamp), received };
        let last = masks.remove(publisher).map(|last| last.mask);
        let mask = light_mask(image).map(Arc::new).map_err(|problem| format!("mask on {topic}: {problem}"));
        let mask = match (last, mask) {
            // An equal one keeps images that were drawn with the last.
            (Some(Ok(last)), Ok(mask)) if last == mask => Ok(last),
            (last, Err(problem)) => {
                if last != Some(Err(problem.clone())) {
                    log::error!("{problem} (from {publisher})");
                }
                Err(problem)
            }
            (_, mask) => mask,
        };
        masks.insert(Arc::clone(publisher), ReceivedMask { mask, measured });
    }

    /// Forgets the masks of nodes that do not publish any more, and notes publishers without a mask.
    pub(super) fn follow_publishers(&mut self, publishers: impl Fn(&str) -> MaskPublishers, now: Instant) {
        for (topic, masks) in &mut self.masks {
            let MaskPublishers { names, listed_at } = publishers(topic);
            // A list from before the last mask says nothing about its publisher.
            let is_gone = |last: &ReceivedMask| listed_at.is_some_and(|at| at > last.measured.received);
            masks.retain(|publisher, last| names.contains(publisher) || !is_gone(last));
            for publisher in names.into_iter().filter(|_| self.is_required) {
                masks.entry(publisher).or_insert_with_key(|publisher| ReceivedMask {
                    mask: Err(format!("no mask on {topic} from {publisher} yet")),
                    measured: Measured { stamp: Time::ZERO, received: now },
                });
            }
        }
    }

    /// The masks of a topic. Each darkens.
    pub(super) fn masks(&self, topic: &str) -> Vec<Arc<LightMask>> {
        let masks = self.masks.get(topic).into_iter().flat_map(BTreeMap::values);
        masks.filter_map(|received| received.mask.as_ref().ok().map(Arc::clone)).collect()
    }

    /// Whether all masks of a topic are there and current.
    pub(super) fn mask_condition(&self, topic: &str, now: Now) -> Condition {
        let masks = self.masks.get(topic).filter(|masks| !masks.is_empty());
        let Some(masks) = masks else {
            let none = Condition::Dark(format!("no mask on {topic}"));
            return if self.is_required { none } else { Condition::Always };
        };
        let limit = self.limits.of_measurement(topic, self.limits.for_all_topics().unwrap_or(EYE_SAFETY_LIMIT));
        let condition = |(publisher, received): (&Arc<str>, &ReceivedMask)| match &received.mask {
            Err(problem) => Condition::Dark(problem.clone()),
            Ok(_) if !self.is_required => Condition::Always,
            Ok(_) => received.measured.condition(&format!("mask on {topic} from {publisher}"), limit, now),
        };
        masks.iter().map(condition).fold(Condition::Always, Condition::and)
    }

    pub(super) fn spheres(&mut self, scene: &SceneState, now: Now) -> KeepOutSpheres {
        let (mut known, mut condition) = (Vec::new(), Condition::Always);
        for KeepOutFrame { frame, radius_m } in &self.keep_out {
            let place: Option<Point3<f64>> = scene.place_of(frame);
            let of_frame = match (place, &mut self.ages) {
                (None, _) | (_, None) => Condition::Dark(format!("keep-out frame {frame}: its place is not known")),
                (Some(_), Some(ages)) => ages.frame(frame, scene, now).condition(),
            };
            let ahead = scene.known_until(frame).map(|stamp| stamp.saturating_since(now.ros));
            let of_frame = match ahead.filter(|ahead| *ahead > self.frame_limit && !now.ros.is_zero()) {
                Some(ahead) => Condition::Dark(format!(
                    "keep-out frame {frame}: its transform is {:.1} s ahead of the clock",
                    ahead.as_secs_f64()
                )),
                None => of_frame,
            };
            condition = condition.and(of_frame);
            known.extend(place.map(|center| Sphere { center, radius_m: *radius_m }));
        }
        if !self.is_required {
            condition = Condition::Always;
        }
        KeepOutSpheres { known, condition }
    }

    /// Whether it is known where the lens sends light around keep-out frames.
    pub(super) fn lens_condition(&self, spheres: &KeepOutSpheres, lens: Option<&NoLens>) -> Condition {
        match lens.filter(|_| self.is_required && !spheres.known.is_empty()) {
            Some(why) => {
                Condition::Dark(format!("where the lens sends light around keep-out frames is not known: {why}"))
            }
            None => Condition::Always,
        }
    }
}
