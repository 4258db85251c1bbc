//! Decides when a camera is dark, which displays it shows, and until when: for topics, windows and files.
//!
//! ```text
//!  stamps, transforms, masks ─► Safety ─► FramePolicy {dark_reason, hidden, valid_until, post} ─► image ─► outputs
//!  measured surfaces ───────────┤             └─► SurfaceCheck: the image's light, confirmed ──────┘
//!  rules of the user ───────────┘                 └─► Permit ─► paused images, test pictures
//! ```
//!
//! [`causes`] is the table of reasons for a blackout; there are no others. Black is the safe image: unknown data make
//! an image dark, and it is lit again as soon as they are known.

pub(crate) mod ages;
pub(crate) mod black_image;
pub(crate) mod causes;
pub(crate) mod confirmed_displays;
mod eyes;
pub(crate) mod mask_image;
pub(crate) mod names;
pub(crate) mod permit;
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
use rcs_messages::{AnyMessage, Image, MessageKind};
use rcs_render::{KeepOut, LastStep};
use rcs_scene::{Camera, DisplayId};

use self::ages::{AgeState, Assessment, Freshness, Now, TopicSource};
use self::causes::{DarkCause, DarkReason};
use self::eyes::{EyeSafety, KeepOutSpheres, EYE_SAFETY_LIMIT};
pub use self::mask_image::light_mask;
pub(crate) use self::mask_image::painted_mask;
use self::names::{of_camera, ConfigNames};
use self::permit::Permit;
use self::rules::Rules;
use self::surface::{SurfaceCheck, Surfaces};
use crate::scene::SceneState;

/// Name of the status of stale data.
pub(crate) const STALE: &str = "Stale";

/// Shortest timeout of a window, which is told less often that its image is valid.
const LEAST_WINDOW_TIMEOUT: Duration = Duration::from_secs(1);

/// Policy for an image of a camera at a moment: what it may show, and its post-processing.
#[derive(Clone, Debug, Default)]
pub(crate) struct FramePolicy {
    /// Why nothing may be lit.
    pub(crate) dark_reason: Option<DarkReason>,
    /// Stale displays, which are left out.
    pub(crate) hidden: Vec<DisplayId>,
    /// End of this if nothing new arrives.
    pub(crate) valid_until: Option<Instant>,
    /// Post-processing: masks, keep-out frames, blending, turning.
    pub(crate) post: Arc<LastStep>,
    /// Surface that the image is checked against, if its light must be confirmed.
    pub(crate) surface: Option<SurfaceCheck>,
    /// `true` if the camera has masks on a topic, keep-out frames, or light that must be confirmed.
    pub(crate) protects_eyes: bool,
    /// `true` if data of the camera may become stale, or rules name no camera.
    is_guarded: bool,
    /// `true` if a black image says why it is black, where that is allowed.
    has_note: bool,
}

impl FramePolicy {
    /// The policy of images that are drawn from files: nothing ages, and no eyes are near.
    pub(crate) fn offline(post: LastStep) -> Self {
        Self { post: Arc::new(post), ..Self::default() }
    }

    /// The policy with the surface that confirms its light. What is dark for the sake of eyes stays so for that reason.
    fn checked(self, state: &AgeState, surface: Option<SurfaceCheck>) -> Self {
        let dark = match state {
            AgeState::Stale(why) => Some(DarkReason::new(DarkCause::Surface, why.clone())),
            AgeState::Undated | AgeState::Current(_) => None,
        };
        let until = match state {
            AgeState::Current(until) => *until,
            AgeState::Undated | AgeState::Stale(_) => None,
        };
        // The first in the table.
        let dark_reason = self.dark_reason.into_iter().chain(dark).min_by_key(|dark| dark.cause);
        Self { dark_reason, valid_until: self.valid_until.into_iter().chain(until).min(), surface, ..self }
    }

    /// Reason for a blackout while there is no CameraInfo or pose; `None` where old images stay for ever, as in rviz.
    pub(crate) fn without_camera(&self, problem: &str) -> Option<DarkReason> {
        let without = || DarkReason::new(DarkCause::NoCamera, problem);
        let is_decided = self.dark_reason.as_ref().filter(|dark| dark.cause.beats_test_pictures(self.protects_eyes));
        is_decided.cloned().or_else(|| (self.is_guarded || self.protects_eyes).then(without))
    }

    /// The policy of a black image while there is no camera: without post-processing that depends on it.
    pub(crate) fn unplaced(&self) -> Self {
        Self { post: unplaced(&self.post), valid_until: None, ..self.clone() }
    }

    /// The policy while the operator has blacked the camera out.
    pub(crate) fn blacked_out(&self, dark: DarkReason) -> Self {
        Self { dark_reason: Some(dark), ..self.unplaced() }
    }

    /// `true` if a black image says why it is black.
    pub(crate) fn shows_note(&self, dark: &DarkReason) -> bool {
        self.has_note && dark.cause.allows_note(self.protects_eyes)
    }
}

/// Post-processing without what depends on the camera: of a black image.
pub(crate) fn unplaced(post: &LastStep) -> Arc<LastStep> {
    Arc::new(LastStep { blend: None, mask: None, keep_out: None, confirmed: None, ..post.clone() })
}

/// Reason for a blackout after an image has expired before the next one is drawn.
pub(crate) fn expired() -> DarkReason {
    DarkReason::new(DarkCause::Silence, "the node is busy, and its data are too old by now")
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

/// A window's timeout, and its permit before the first image and after images stop.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct SilentWindow {
    /// The window becomes black when nothing was drawn or confirmed for this long.
    pub(crate) timeout: Option<Duration>,
    /// The permit without an image.
    pub(crate) permit: Permit,
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
    pub(crate) fn take_image(&mut self, topic: &str, image: &Image, received: Instant) {
        self.eyes.take(topic, image, received);
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

    /// Forgets the ages of frames: the time jumped back.
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

    /// The policy of each camera, in their order. `source` says who publishes a topic, by its type and its name in the
    /// config, or a mask's or surface's by its whole name.
    pub(crate) fn assess(
        &mut self,
        scene: &SceneState,
        views: &[LitView<'_>],
        source: impl Fn(&str, MessageKind) -> Option<TopicSource>,
        now: Now,
    ) -> Vec<FramePolicy> {
        self.assessment = self.ages.as_mut().map(|ages| ages.assess(scene, &source, now));
        let masks = self.eyes.mask_states(&source, now);
        let spheres = self.eyes.spheres(scene, now);
        let mask_of =
            |view: &CameraView| of_camera(&self.rules.mask_topics, &view.name).and_then(|topic| masks.get(topic));
        let masks: Vec<_> = views.iter().map(|lit| mask_of(lit.view)).collect();
        let mut policies = Vec::with_capacity(views.len());
        for (lit, mask) in views.iter().zip(masks) {
            self.surfaces.observe(lit, scene);
            let surface = self.surfaces.state(lit, &source, now);
            let check = self.surfaces.check(&lit.view.name, scene.displays());
            policies.push(self.policy(lit, mask, &spheres).checked(&surface, check));
        }
        policies
    }

    fn policy(&self, lit: &LitView<'_>, mask: Option<&AgeState>, spheres: &KeepOutSpheres) -> FramePolicy {
        let shown = self.assessment.as_ref().map(|all| all.of_camera(lit.view)).unwrap_or_default();
        let forbidden = self.eyes.forbidden(mask, spheres, lit.unknown_lens.clone());
        let unmatched = self.unmatched.as_ref().map(|why| DarkReason::new(DarkCause::UnknownName, why.clone()));
        FramePolicy {
            dark_reason: unmatched.or(forbidden.dark_reason).or(shown.dark_reason),
            surface: None,
            hidden: shown.hidden,
            valid_until: shown.until.into_iter().chain(forbidden.until).min(),
            post: Arc::new(self.post(&lit.view.name, lit.camera, spheres)),
            protects_eyes: self.protects_eyes(&lit.view.name),
            is_guarded: self.ages.is_some() || self.unmatched.is_some(),
            has_note: self.has_note,
        }
    }

    fn post(&self, camera_name: &str, camera: Option<&Camera>, spheres: &KeepOutSpheres) -> LastStep {
        let rules = &self.rules;
        if rules.is_noop() {
            return LastStep::default();
        }
        LastStep {
            mask: of_camera(&rules.mask_topics, camera_name).and_then(|topic| self.eyes.mask(topic)),
            keep_out: camera.and_then(|camera| KeepOut::new(camera, &spheres.known)),
            orientation: of_camera(&rules.orientations, camera_name).copied().unwrap_or_default(),
            blend: of_camera(&rules.blends, camera_name).cloned(),
            painted_mask: of_camera(&rules.painted_masks, camera_name).cloned(),
            confirmed: None,
        }
    }

    /// The timeout of a camera's window, and its permit without an image.
    pub(crate) fn silent_window(&self, camera: &str) -> SilentWindow {
        let protects_eyes = self.protects_eyes(camera);
        let limit = self.rules.limits.for_all_topics().or(protects_eyes.then_some(EYE_SAFETY_LIMIT));
        let nowhere = KeepOutSpheres::none();
        let silence = DarkReason::new(DarkCause::Silence, "no image");
        let permit = Permit::new(Some(&silence), protects_eyes, &Arc::new(self.post(camera, None, &nowhere)));
        SilentWindow { timeout: limit.map(|limit| limit.max(LEAST_WINDOW_TIMEOUT)), permit }
    }
}
