//! Images in place of the scene's: black ones, test pictures and patterns of a calibration.

use std::sync::Arc;
use std::time::Instant;

use rcs_scene::{Encoding, Picture};

use super::frame::{FrameContent, FrameSpec, TestImage};
use crate::control::OperatorSettings;
use crate::safety::black_image::black_picture;
use crate::safety::causes::DarkReason;
use crate::safety::permit::{shares, Allowance};
use crate::safety::FramePolicy;

/// The content in place of the scene: black for a reason, or a pattern or a test picture where that does not beat it.
/// `None` where the scene is shown. `frame_id` is the camera's optical frame.
pub(super) fn content(
    (size_px, frame_id): ([u32; 2], &str),
    dark: Option<&DarkReason>,
    policy: &FramePolicy,
    operator: &OperatorSettings,
) -> Option<FrameContent> {
    let beats_tests = dark.is_some_and(|dark| dark.cause.beats_test_pictures(policy.protects_eyes));
    let turned_px = policy.post.orientation.size_px(size_px);
    let pattern = operator.pattern.as_ref().filter(|pattern| pattern.fits(frame_id, turned_px));
    let pattern = pattern.map(|pattern| TestImage::Pattern(Arc::clone(pattern)));
    match (dark, pattern.or(operator.test_picture.map(TestImage::Picture))) {
        (_, Some(test)) if !beats_tests => Some(FrameContent::Test { size_px, test }),
        (Some(dark), _) => Some(FrameContent::Black { size_px, dark: dark.clone(), has_note: policy.shows_note(dark) }),
        (None, _) => None,
    }
}

/// Expiry of a frame, by that of its data and that of a pattern.
pub(super) fn valid_until(content: &FrameContent, of_data: Option<Instant>) -> Option<Instant> {
    match content {
        FrameContent::Test { test: TestImage::Pattern(pattern), .. } => {
            of_data.into_iter().chain([pattern.until()]).min()
        }
        _ => of_data,
    }
}

/// The image of a frame that shows no scene; `None` for one that does. `camera` is the text of the test picture with
/// the name.
pub(super) fn image(spec: &FrameSpec, encoding: Encoding, camera: &str) -> Option<Picture> {
    match &spec.content {
        FrameContent::Scene { .. } => None,
        FrameContent::Black { size_px, dark, has_note } => {
            let mut picture = black_picture(*size_px, encoding, has_note.then_some(dark.why.as_str()));
            spec.post.apply(&mut picture, &mut Picture::default());
            Some(picture)
        }
        FrameContent::Test { size_px, test } => Some(test_image(test, *size_px, spec, encoding, camera)),
    }
}

/// A test picture or a pattern as it stands on the projector, not turned, dark where no light is allowed.
fn test_image(test: &TestImage, drawn_px: [u32; 2], spec: &FrameSpec, encoding: Encoding, camera: &str) -> Picture {
    let size_px = spec.post.orientation.size_px(drawn_px);
    let mut levels = match test {
        TestImage::Picture(test) => test.draw(size_px, camera).data,
        TestImage::Pattern(pattern) => pattern.levels().to_vec(),
    };
    match spec.permit().test {
        Allowance::All => {}
        Allowance::Nothing => levels.fill(0),
        Allowance::Masked => {
            let allowed = shares(&spec.post, drawn_px, size_px).data;
            levels.iter_mut().zip(&allowed).for_each(|(level, share)| {
                *level = (u16::from(*level) * u16::from(*share) / u16::from(u8::MAX)) as u8;
            });
        }
    }
    let mut picture = Picture::default();
    picture.reset(size_px[0], size_px[1], encoding);
    let step = picture.step().max(1);
    let mut row = Vec::with_capacity(size_px[0] as usize);
    for (to, from) in picture.data.chunks_mut(step).zip(levels.chunks(size_px[0].max(1) as usize)) {
        row.clear();
        row.extend(from.iter().map(|level| [*level, *level, *level, u8::MAX]));
        encoding.write_row(&row, to);
    }
    picture
}
