//! The permit to show a paused image or a test picture in place of an image.

use std::sync::Arc;

use rcs_render::LastStep;
use rcs_scene::{Encoding, Picture};

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
    /// `true` if the image is not dark for a reason, so that a paused one may stay in its place.
    pub(crate) is_lit: bool,
    pub(crate) test: Allowance,
    /// Post-processing, with masks and keep-out frames.
    pub(crate) post: Arc<LastStep>,
}

impl Permit {
    /// The permit of an image that is dark for a reason, or lit.
    pub(crate) fn new(dark: Option<&DarkReason>, protects_eyes: bool, post: &Arc<LastStep>) -> Self {
        let is_dark_in_tests = dark.is_some_and(|dark| dark.cause.beats_test_pictures(protects_eyes));
        let test = match is_dark_in_tests {
            true => Allowance::Nothing,
            false if protects_eyes || post.painted_mask.is_some() => Allowance::Masked,
            false => Allowance::All,
        };
        Self { is_lit: dark.is_none(), test, post: Arc::clone(post) }
    }

    /// The permit of an image on a topic, of which only the pixels are known.
    pub fn of_topic(is_black: bool) -> Self {
        let dark = is_black.then(|| DarkReason::new(DarkCause::BlackImage, "the image is black"));
        Self::new(dark.as_ref(), false, &Arc::default())
    }
}

/// The share of light that post-processing leaves each pixel of an image of this size: a mono8 picture, 255 for all.
/// `drawn_px` is the size of the camera's images before they are turned. Pixels beyond their edges are dark.
pub(crate) fn shares(post: &LastStep, drawn_px: [u32; 2], size_px: [u32; 2]) -> Picture {
    let mut turned = Picture::default();
    turned.reset(drawn_px[0], drawn_px[1], Encoding::Mono8);
    turned.data.fill(u8::MAX);
    // Blending is no mask.
    LastStep { blend: None, ..post.clone() }.apply(&mut turned, &mut Picture::default());
    let mut shares = Picture::default();
    shares.reset(size_px[0], size_px[1], Encoding::Mono8);
    let rows = shares.data.chunks_mut(size_px[0].max(1) as usize);
    for (to, from) in rows.zip(turned.data.chunks(turned.width_px.max(1) as usize)) {
        let width = to.len().min(from.len());
        to.iter_mut().zip(from.iter().take(width)).for_each(|(to, from)| *to = *from);
    }
    shares
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_cause_beats_a_pause_and_those_about_eyes_beat_test_pictures() {
        use DarkCause::{
            BlackImage, Blackout, CameraData, Displays, KeepOut, Lens, Mask, NoCamera, Silence, Surface, UnknownName,
        };
        let test = |cause, protects_eyes| {
            let permit = Permit::new(Some(&DarkReason::new(cause, "")), protects_eyes, &Arc::default());
            assert!(!permit.is_lit, "{cause:?}");
            permit.test
        };
        for cause in [Blackout, UnknownName, Mask, KeepOut, Lens, Surface] {
            assert_eq!([test(cause, false), test(cause, true)], [Allowance::Nothing; 2], "{cause:?}");
        }
        for cause in [NoCamera, CameraData, Silence] {
            assert_eq!([test(cause, false), test(cause, true)], [Allowance::All, Allowance::Nothing], "{cause:?}");
        }
        for cause in [Displays, BlackImage] {
            assert_eq!([test(cause, false), test(cause, true)], [Allowance::All, Allowance::Masked], "{cause:?}");
        }
        let lit = |protects_eyes| Permit::new(None, protects_eyes, &Arc::default());
        assert_eq!((lit(false).is_lit, lit(false).test), (true, Allowance::All));
        assert_eq!((lit(true).is_lit, lit(true).test), (true, Allowance::Masked));
    }

    #[test]
    fn only_what_is_too_old_is_said_in_the_image() {
        use DarkCause::{Blackout, CameraData, Displays, KeepOut, Lens, Mask, NoCamera, Silence, Surface, UnknownName};
        for cause in [Blackout, UnknownName, Mask, KeepOut, Lens, Surface, Silence] {
            assert!(!cause.allows_note(false) && !cause.allows_note(true), "{cause:?}");
        }
        for cause in [CameraData, Displays] {
            assert!(cause.allows_note(false) && cause.allows_note(true), "{cause:?}");
        }
        assert!(NoCamera.allows_note(false) && !NoCamera.allows_note(true));
    }
}
