//! Decides when a camera must be dark, what of its scene may be lit, and until when: for topics, windows and files.
//!
//! ```text
//!  stamps, transforms, masks ─► Safety ─► FramePolicy {dark, hidden, valid_until, post} ─► image ─► outputs
//!  rules of the user ───────────┘                 └─► Permit ─► windows: paused images, test pictures
//! ```
//!
//! [`causes`] is the table of reasons for darkness; there are no others. Black is the safe image: whatever is not known
//! makes an image dark, and it is lit again as soon as it is known.

pub mod ages;
pub(crate) mod black_image;
pub mod causes;
mod eyes;
mod mask_image;
pub mod names;
pub mod permit;
pub(crate) mod read_rules;
pub mod rules;
pub(crate) mod status;
#[cfg(test)]
mod tests;

use std::sync::Arc;
use std::time::{Duration, Instant};

use rcs_camera::NoLens;
use rcs_displays::CameraView;
use rcs_messages::{Image, MessageKind};
use rcs_render::{KeepOut, LastStep};
use rcs_scene::{Camera, DisplayId};

use self::ages::{Assessment, Freshness, Now, SceneAges, Source};
use self::causes::{Cause, Dark};
use self::eyes::{Eyes, Spheres, EYE_SAFETY_LIMIT};
pub use self::mask_image::{light_mask, painted_mask};
use self::names::of_camera;
use self::permit::Permit;
use self::rules::Rules;

/// The name of the status of what is too old.
pub(crate) const STALE: &str = "Stale";

/// A window becomes black after this at the earliest when nothing is drawn or confirmed: it is told less often.
const LEAST_WINDOW_TIMEOUT: Duration = Duration::from_secs(1);

/// Policy for an image of a camera at a moment: what it may show, and its post-processing.
#[derive(Clone, Debug, Default)]
pub struct FramePolicy {
    /// Why nothing may be lit.
    pub dark: Option<Dark>,
    /// Displays that are too old, and so left out.
    pub hidden: Vec<DisplayId>,
    /// Until when this holds if nothing new arrives.
    pub valid_until: Option<Instant>,
    /// Post-processing: masks, keep-out frames, blending, turning.
    pub post: Arc<LastStep>,
    /// Whether the camera has masks on a topic, or keep-out frames.
    pub protects_eyes: bool,
    /// Whether data of the camera may be too old, or its rules not fit.
    is_guarded: bool,
    /// Whether a black image says why it is black, where that is allowed.
    has_note: bool,
}

impl FramePolicy {
    /// The policy of images that are drawn from files: nothing ages, and no eyes are near.
    pub fn offline(post: LastStep) -> Self {
        Self { post: Arc::new(post), ..Self::default() }
    }

    /// Why an image is dark for which there is no camera: it has no CameraInfo, or no pose. None where old images stay
    /// for ever, as in rviz.
    pub fn without_camera(&self, problem: &str) -> Option<Dark> {
        let without = || Dark::new(Cause::NoCamera, problem);
        let is_decided = self.dark.as_ref().filter(|dark| dark.cause.beats_test_pictures(self.protects_eyes));
        is_decided.cloned().or_else(|| (self.is_guarded || self.protects_eyes).then(without))
    }

    /// The policy of a black image for which there is no camera: without what depends on the camera.
    pub fn unplaced(&self) -> Self {
        let post = LastStep { blend: None, mask: None, keep_out: None, ..(*self.post).clone() };
        Self { post: Arc::new(post), valid_until: None, ..self.clone() }
    }

    /// Whether a black image says why.
    pub fn shows_note(&self, dark: &Dark) -> bool {
        self.has_note && dark.cause.allows_note(self.protects_eyes)
    }
}

/// Why an image is dark whose policy is over before the next one is drawn.
pub fn expired() -> Dark {
    Dark::new(Cause::Silence, "the node is busy, and its data are too old by now")
}

/// A camera whose policy is asked for.
pub struct LitView<'a> {
    /// The camera's settings.
    pub view: &'a CameraView,
    /// Where its light goes; none for one that cannot draw, or where that does not matter.
    pub camera: Option<&'a Camera>,
    /// Why its light may go elsewhere.
    pub unknown_lens: Option<NoLens>,
}

/// A window's timeout, and its permit before the first image and after images stop.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SilentWindow {
    /// It is black when nothing was drawn or confirmed for this long.
    pub timeout: Option<Duration>,
    /// The permit without an image.
    pub permit: Permit,
}

/// Follows everything that light depends on.
#[derive(Debug)]
pub struct Safety {
    rules: Rules,
    /// Which rules name cameras that do not exist.
    unmatched: Option<String>,
    /// `None` where nothing is ever too old.
    ages: Option<Freshness>,
    eyes: Eyes,
    /// The states of all displays at the last [`assess`](Self::assess).
    assessment: Option<Assessment>,
    has_note: bool,
}

impl Safety {
    /// With the rules of a user; nothing has come yet.
    pub fn new(rules: Rules) -> Self {
        let topics = rules.mask_topics.iter().map(|mask| &mask.value);
        let eyes = Eyes::new(topics, rules.keep_out.clone(), rules.is_required, rules.limits.clone());
        let (ages, has_note) = (Freshness::new(rules.limits.clone()), rules.limits.has_note);
        Self { rules, unmatched: None, ages, eyes, assessment: None, has_note }
    }

    /// Takes the cameras of a config, by name. While a rule names another one, all are dark: it is not known whose rule
    /// it is. Returns what does not fit.
    pub fn set_cameras(&mut self, cameras: &[String]) -> Option<&str> {
        let unmatched = self.rules.unmatched(cameras);
        match (&self.unmatched, &unmatched) {
            (before, Some(why)) if before.as_ref() != Some(why) => {
                log::error!("all cameras are dark: {why}; name the cameras as the config does");
            }
            (Some(_), None) => log::info!("the names of all cameras fit again"),
            _ => {}
        }
        self.unmatched = unmatched;
        self.unmatched.as_deref()
    }

    /// Why all cameras are dark: rules name cameras that the config does not have.
    pub fn unmatched(&self) -> Option<&str> {
        self.unmatched.as_deref()
    }

    /// Takes an image that was received, in case that it is a mask; by its topic's whole name.
    pub fn take_image(&mut self, topic: &str, image: &Image, received: Instant) {
        self.eyes.take(topic, image, received);
    }

    /// Records that transforms of moving frames were received.
    pub fn note_transforms(&mut self, received: Instant) {
        self.ages.iter_mut().for_each(|ages| ages.note_transforms(received));
    }

    /// Forgets what it knows of frames: the time jumped back.
    pub fn reset(&mut self) {
        self.ages.iter_mut().for_each(Freshness::reset);
        self.eyes.reset();
    }

    /// Whether it has to be known where the light of cameras goes.
    pub fn needs_cameras(&self) -> bool {
        self.eyes.is_some()
    }

    /// Whether a camera has masks on a topic, or keep-out frames.
    fn protects_eyes(&self, camera: &str) -> bool {
        self.eyes.has_keep_out() || of_camera(&self.rules.mask_topics, camera).is_some()
    }

    /// The states of all displays at the last [`assess`](Self::assess); none where nothing is ever too old.
    pub fn assessment(&self) -> Option<&Assessment> {
        self.assessment.as_ref()
    }

    /// The policy of each camera, in their order. `source` says who publishes a topic, by its name in the config, or a
    /// mask's by its whole name, and type.
    pub fn assess(
        &mut self,
        scene: &impl SceneAges,
        views: &[LitView<'_>],
        source: impl Fn(&str, MessageKind) -> Option<Source>,
        now: Now,
    ) -> Vec<FramePolicy> {
        self.assessment = self.ages.as_mut().map(|ages| ages.assess(scene, &source, now));
        let masks = self.eyes.mask_states(&source, now);
        let spheres = self.eyes.spheres(scene, now);
        let mask_of =
            |view: &CameraView| of_camera(&self.rules.mask_topics, &view.name).and_then(|topic| masks.get(topic));
        views.iter().map(|lit| self.policy(lit, mask_of(lit.view), &spheres)).collect()
    }

    fn policy(&self, lit: &LitView<'_>, mask: Option<&ages::State>, spheres: &Spheres) -> FramePolicy {
        let shown = self.assessment.as_ref().map(|all| all.of_camera(lit.view)).unwrap_or_default();
        let forbidden = self.eyes.forbidden(mask, spheres, lit.unknown_lens.clone());
        let unmatched = self.unmatched.as_ref().map(|why| Dark::new(Cause::UnknownCamera, why.clone()));
        FramePolicy {
            dark: unmatched.or(forbidden.dark).or(shown.black),
            hidden: shown.hidden,
            valid_until: shown.until.into_iter().chain(forbidden.until).min(),
            post: Arc::new(self.post(&lit.view.name, lit.camera, spheres)),
            protects_eyes: self.protects_eyes(&lit.view.name),
            is_guarded: self.ages.is_some() || self.unmatched.is_some(),
            has_note: self.has_note,
        }
    }

    fn post(&self, camera_name: &str, camera: Option<&Camera>, spheres: &Spheres) -> LastStep {
        let rules = &self.rules;
        if rules.change_nothing() {
            return LastStep::default();
        }
        LastStep {
            mask: of_camera(&rules.mask_topics, camera_name).and_then(|topic| self.eyes.mask(topic)),
            keep_out: camera.and_then(|camera| KeepOut::new(camera, &spheres.known)),
            orientation: of_camera(&rules.orientations, camera_name).copied().unwrap_or_default(),
            blend: of_camera(&rules.blends, camera_name).cloned(),
            painted_mask: of_camera(&rules.painted_masks, camera_name).cloned(),
        }
    }

    /// The timeout of a camera's window, and its permit without an image.
    pub fn silent_window(&self, camera: &str) -> SilentWindow {
        let protects_eyes = self.protects_eyes(camera);
        let limit = self.rules.limits.for_all_topics().or(protects_eyes.then_some(EYE_SAFETY_LIMIT));
        let nowhere = Spheres::none();
        let silence = Dark::new(Cause::Silence, "no image");
        let permit = Permit::new(Some(&silence), protects_eyes, 0, &Arc::new(self.post(camera, None, &nowhere)));
        SilentWindow { timeout: limit.map(|limit| limit.max(LEAST_WINDOW_TIMEOUT)), permit }
    }
}
