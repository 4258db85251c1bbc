//! Collects the evidence about each camera's light, which [`rcs_light`] decides from, and which displays it shows.
//!
//! ```text
//!  stamps, transforms, masks ─► Safety ─► CameraLight {evidence, hidden, surface} ─► decide ─► grant ─► outputs
//!  measured surfaces ───────────┤
//!  rules of the user ───────────┘
//! ```

pub(crate) mod ages;
pub(crate) mod black_image;
pub(crate) mod confirmed_displays;
mod eyes;
pub(crate) mod mask_image;
pub(crate) mod names;
pub(crate) mod read_rules;
pub(crate) mod rules;
pub(crate) mod status;
pub(crate) mod surface;
#[cfg(test)]
mod tests;

use std::sync::Arc;
use std::time::{Duration, Instant};

use rcs_camera::NoLens;
use rcs_displays::CameraView;
use rcs_light::{Condition, DarkCause, Evidence, LightRules, Now};
use rcs_messages::{AnyMessage, Image, MessageKind};
use rcs_render::{KeepOut, PostProcess};
use rcs_scene::{Camera, DisplayId};

use self::ages::{Assessment, Freshness, TopicSource};
use self::eyes::{EyeSafety, KeepOutSpheres, MaskPublishers, EYE_SAFETY_LIMIT};
pub use self::mask_image::light_mask;
pub(crate) use self::mask_image::painted_mask;
use self::names::{of_camera, ConfigNames};
use self::rules::Rules;
use self::surface::{SurfaceCheck, Surfaces};
use crate::scene::SceneState;

/// Name of the status of stale data.
pub(crate) const STALE: &str = "Stale";

/// Shortest limit of the light, which is granted anew at least twice a second.
const LEAST_LIMIT: Duration = Duration::from_secs(1);
/// Limit of the light where nothing becomes stale.
const UNGUARDED_LIMIT: Duration = Duration::from_secs(5);

/// The light of a camera at a moment: what is known about it, and what it must leave out.
#[derive(Clone, Debug)]
pub(crate) struct CameraLight {
    /// What is known of all causes but the operator's blackout. Whether there is a camera is for the camera to set.
    pub(crate) evidence: Evidence,
    /// Stale displays, which are left out.
    pub(crate) hidden: Vec<DisplayId>,
    /// Surface that the image is checked against, if its light must be confirmed.
    pub(crate) surface: Option<SurfaceCheck>,
    /// `true` if black images replace old ones while there is no camera; otherwise old images stay, as in rviz.
    pub(crate) is_guarded: bool,
    /// `true` if a black image says why it is black, where that is allowed.
    pub(crate) has_note: bool,
}

impl CameraLight {
    /// Nothing is known yet: dark.
    pub(crate) fn unknown() -> Self {
        let rules = LightRules { protects_eyes: true, must_confirm: true, limit: LEAST_LIMIT };
        let evidence = Evidence::unknown(&DarkCause::OF_CAMERA, rules, Arc::default());
        Self { evidence, hidden: Vec::new(), surface: None, is_guarded: true, has_note: false }
    }
}

/// A camera to assess.
pub(crate) struct LitView<'a> {
    /// The camera's settings.
    pub(crate) view: &'a CameraView,
    /// Its projection; `None` if it cannot draw, or where that does not matter.
    pub(crate) camera: Option<&'a Camera>,
    /// Why its lens is unknown.
    pub(crate) unknown_lens: Option<NoLens>,
    /// `true` if somebody watches.
    pub(crate) is_watched: bool,
}

/// Assesses what cameras may show.
#[derive(Debug)]
pub(crate) struct Safety {
    rules: Rules,
    /// The rules that name cameras or displays which do not exist.
    unmatched: Option<String>,
    /// `None` where nothing becomes stale.
    ages: Option<Freshness>,
    eyes: EyeSafety,
    surfaces: Surfaces,
    /// Of the last [`assess`](Self::assess).
    assessment: Option<Assessment>,
    has_note: bool,
}

impl Safety {
    pub(crate) fn new(rules: Rules) -> Self {
        let topics = rules.mask_topics.iter().map(|mask| &mask.value);
        let eyes = EyeSafety::new(topics, rules.keep_out.clone(), rules.is_required, rules.limits.clone());
        let surfaces = Surfaces::new(rules.confirm.clone(), rules.limits.clone());
        let (ages, has_note) = (Freshness::new(rules.limits.clone()), rules.limits.has_note);
        Self { rules, unmatched: None, ages, eyes, surfaces, assessment: None, has_note }
    }

    /// Takes the names in a config. While a rule names another camera or display, all cameras are dark, because it is
    /// unknown whose rule it is. Returns the rules that name others.
    pub(crate) fn set_names(&mut self, names: &ConfigNames) -> Option<&str> {
        let unmatched = self.rules.unmatched(&names.cameras).or_else(|| self.surfaces.unmatched(names));
        match (&self.unmatched, &unmatched) {
            (before, Some(why)) if before.as_ref() != Some(why) => {
                log::error!("all cameras are dark: {why}; use the names of the config");
            }
            (Some(_), None) => log::info!("all rules have names of the config again"),
            _ => {}
        }
        self.unmatched = unmatched;
        self.unmatched.as_deref()
    }

    /// The rules that name cameras or displays which the config does not have: all cameras are dark.
    pub(crate) fn unmatched(&self) -> Option<&str> {
        self.unmatched.as_deref()
    }

    /// Takes a received image, which may be a mask; by its topic's whole name.
    pub(crate) fn take_image(&mut self, topic: &str, image: &Image, publisher: &Arc<str>, received: Instant) {
        self.eyes.take(topic, image, publisher, received);
    }

    /// Takes the publishers of each mask's topic. All must send masks.
    pub(crate) fn follow_publishers(&mut self, publishers: impl Fn(&str) -> MaskPublishers, now: Instant) {
        self.eyes.follow_publishers(publishers, now);
    }

    /// Takes a received message, which may be a depth camera's; by its topic's whole name. Returns `true` for one that
    /// was taken before.
    pub(crate) fn take_surface(&mut self, topic: &str, message: &AnyMessage, received: Instant) -> bool {
        self.surfaces.take(topic, message, received)
    }

    /// Records that transforms of moving frames were received.
    pub(crate) fn note_transforms(&mut self, received: Instant) {
        self.ages.iter_mut().for_each(|ages| ages.note_transforms(received));
    }

    /// Forgets all measurements and the ages of frames: the time jumped back.
    pub(crate) fn reset(&mut self) {
        self.ages.iter_mut().for_each(Freshness::reset);
        self.eyes.reset();
        self.surfaces.reset();
    }

    /// `true` if the projections of cameras matter.
    pub(crate) fn needs_cameras(&self) -> bool {
        self.eyes.is_some() || self.surfaces.is_some()
    }

    /// `true` if a camera has masks on a topic, keep-out frames, or light that must be confirmed.
    fn protects_eyes(&self, camera: &str) -> bool {
        self.eyes.has_keep_out() || of_camera(&self.rules.mask_topics, camera).is_some() || self.surfaces.has(camera)
    }

    /// The states of all displays at the last [`assess`](Self::assess); `None` where nothing becomes stale.
    pub(crate) fn assessment(&self) -> Option<&Assessment> {
        self.assessment.as_ref()
    }

    /// The light of each camera, in their order. `source` says who publishes a topic, by its type and its name in the
    /// config.
    pub(crate) fn assess(
        &mut self,
        scene: &SceneState,
        views: &[LitView<'_>],
        source: impl Fn(&str, MessageKind) -> Option<TopicSource>,
        now: Now,
    ) -> Vec<CameraLight> {
        self.assessment = self.ages.as_mut().map(|ages| ages.assess(scene, &source, now));
        let spheres = self.eyes.spheres(scene, now);
        views.iter().map(|lit| self.camera_light(lit, scene, &spheres, now)).collect()
    }

    fn camera_light(
        &mut self,
        lit: &LitView<'_>,
        scene: &SceneState,
        spheres: &KeepOutSpheres,
        now: Now,
    ) -> CameraLight {
        let name = lit.view.name.as_str();
        self.surfaces.observe(lit, scene);
        let surface = self.surfaces.condition(lit, now);
        let (protects_eyes, must_confirm) = (self.protects_eyes(name), self.surfaces.has(name));
        let rules = LightRules { protects_eyes, must_confirm, limit: self.light_limit(name) };
        let post = Arc::new(self.post(name, lit.camera, spheres));
        let mut evidence = Evidence::unknown(&DarkCause::OF_CAMERA, rules, post);
        let unmatched = self.unmatched.clone().map_or(Condition::Always, Condition::Dark);
        evidence.set(DarkCause::UnknownName, unmatched);
        let mask_topic = of_camera(&self.rules.mask_topics, name);
        let mask = mask_topic.map_or(Condition::Always, |topic| self.eyes.mask_condition(topic, now));
        evidence.set(DarkCause::Mask, mask);
        evidence.set(DarkCause::KeepOut, spheres.condition.clone());
        evidence.set(DarkCause::Lens, self.eyes.lens_condition(spheres, lit.unknown_lens.as_ref()));
        evidence.set(DarkCause::Surface, surface);
        let ages = self.assessment.as_ref().map(|all| all.of_camera(lit.view));
        let (hidden, camera, displays) = ages.map_or((Vec::new(), Condition::Always, Condition::Always), |ages| {
            (ages.hidden, ages.camera, ages.displays)
        });
        evidence.set(DarkCause::CameraData, camera);
        evidence.set(DarkCause::Displays, displays);
        let surface = self.surfaces.check(name, scene);
        let is_guarded = self.ages.is_some() || self.unmatched.is_some() || protects_eyes;
        CameraLight { evidence, hidden, surface, is_guarded, has_note: self.has_note }
    }

    fn post(&self, camera_name: &str, camera: Option<&Camera>, spheres: &KeepOutSpheres) -> PostProcess {
        let rules = &self.rules;
        if rules.is_noop() {
            return PostProcess::default();
        }
        PostProcess {
            masks: of_camera(&rules.mask_topics, camera_name).map_or_else(Vec::new, |topic| self.eyes.masks(topic)),
            keep_out: camera.and_then(|camera| KeepOut::new(camera, &spheres.known)),
            orientation: of_camera(&rules.orientations, camera_name).copied().unwrap_or_default(),
            blend: of_camera(&rules.blends, camera_name).cloned(),
            painted_mask: of_camera(&rules.painted_masks, camera_name).cloned(),
            confirmed: None,
        }
    }

    /// Longest time for which a camera's light is granted at once: a window that hears nothing for longer is black.
    pub(crate) fn light_limit(&self, camera: &str) -> Duration {
        let limit = self.rules.limits.for_all_topics().or(self.protects_eyes(camera).then_some(EYE_SAFETY_LIMIT));
        limit.map_or(UNGUARDED_LIMIT, |limit| limit.max(LEAST_LIMIT))
    }
}
