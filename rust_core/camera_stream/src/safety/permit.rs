//! The permit for a window to show a paused image or a test picture in place of the newest image.

use std::sync::Arc;

use rcs_render::LastStep;

use super::causes::{DarkCause, DarkReason};

/// Share of an image that may be lit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Allowance {
    /// All of it.
    #[default]
    All,
    /// Only outside masks and keep-out frames.
    Masked,
    /// Nothing.
    Nothing,
}

/// The permit that comes with an image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Permit {
    pub(crate) paused: Allowance,
    pub(crate) test: Allowance,
    /// Images of one number may be held in each other's place: they leave out the same data, of the same config.
    pub(crate) epoch: u64,
    /// Post-processing, with masks and keep-out frames.
    pub(crate) post: Arc<LastStep>,
}

impl Permit {
    /// The permit of an image that is dark for a reason, or lit.
    pub(crate) fn new(dark: Option<&DarkReason>, protects_eyes: bool, epoch: u64, post: &Arc<LastStep>) -> Self {
        let post = Arc::clone(post);
        let masked = if protects_eyes { Allowance::Masked } else { Allowance::All };
        let is_dark_in_tests = dark.is_some_and(|dark| dark.cause.beats_test_pictures(protects_eyes));
        let test = match is_dark_in_tests {
            true => Allowance::Nothing,
            false if post.painted_mask.is_some() => Allowance::Masked,
            false => masked,
        };
        Self { paused: if dark.is_some() { Allowance::Nothing } else { masked }, test, epoch, post }
    }

    /// The permit of an image on a topic, of which only the pixels are known.
    pub fn of_topic(is_black: bool) -> Self {
        let dark = is_black.then(|| DarkReason::new(DarkCause::BlackImage, "the image is black"));
        Self::new(dark.as_ref(), false, 0, &Arc::default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_cause_beats_a_pause_and_those_about_eyes_beat_test_pictures() {
        use DarkCause::{BlackImage, CameraData, Displays, KeepOut, Lens, Mask, NoCamera, Silence, UnknownCamera};
        let test = |cause, protects_eyes| {
            let permit = Permit::new(Some(&DarkReason::new(cause, "")), protects_eyes, 0, &Arc::default());
            assert_eq!(permit.paused, Allowance::Nothing, "{cause:?}");
            permit.test
        };
        for cause in [UnknownCamera, Mask, KeepOut, Lens] {
            assert_eq!([test(cause, false), test(cause, true)], [Allowance::Nothing; 2], "{cause:?}");
        }
        for cause in [NoCamera, CameraData, Silence] {
            assert_eq!([test(cause, false), test(cause, true)], [Allowance::All, Allowance::Nothing], "{cause:?}");
        }
        for cause in [Displays, BlackImage] {
            assert_eq!([test(cause, false), test(cause, true)], [Allowance::All, Allowance::Masked], "{cause:?}");
        }
        let lit = |protects_eyes| Permit::new(None, protects_eyes, 0, &Arc::default());
        assert_eq!((lit(false).paused, lit(false).test), (Allowance::All, Allowance::All));
        assert_eq!((lit(true).paused, lit(true).test), (Allowance::Masked, Allowance::Masked));
    }

    #[test]
    fn only_what_is_too_old_is_said_in_the_image() {
        use DarkCause::{CameraData, Displays, KeepOut, Lens, Mask, NoCamera, Silence, UnknownCamera};
        for cause in [UnknownCamera, Mask, KeepOut, Lens, Silence] {
            assert!(!cause.allows_note(false) && !cause.allows_note(true), "{cause:?}");
        }
        for cause in [CameraData, Displays] {
            assert!(cause.allows_note(false) && cause.allows_note(true), "{cause:?}");
        }
        assert!(NoCamera.allows_note(false) && !NoCamera.allows_note(true));
    }
}
