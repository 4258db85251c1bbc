//! Images in place of the scene's: black ones, notes, test pictures and patterns of a calibration.

use std::sync::Arc;

use rcs_light::Grant;
use rcs_scene::{Encoding, Picture};

use super::frame::{FrameContent, FrameSpec, TestImage};
use crate::outputs::FrameImage;
use crate::safety::black_image::{black_picture, write_note};

/// The image of a frame that shows no scene. `camera` is the text of the test picture with the name.
pub(super) fn image(spec: &FrameSpec, encoding: Encoding, camera: &str) -> FrameImage {
    let shown_px = spec.orientation.size_px(spec.content.size_px());
    let lit = spec.grant.clone().and_then(|grant| match &spec.content {
        FrameContent::Scene { .. } | FrameContent::Black { .. } => None,
        FrameContent::Note { size_px, dark } => {
            let mut picture = black_picture(*size_px, encoding);
            write_note(&mut picture, &dark.why);
            grant.light(picture, &mut Picture::default())
        }
        FrameContent::Test { test, .. } => grant.light_turned(test_image(test, shown_px, encoding, camera)),
    });
    lit.map_or_else(|| FrameImage::black(shown_px, encoding), FrameImage::lit)
}

/// The grant of a pattern, which is shown for a while only.
pub(super) fn grant_of(test: &TestImage, grant: Grant) -> Grant {
    match test {
        TestImage::Picture(_) => grant,
        TestImage::Pattern(pattern) => grant.until_at_most(pattern.until()),
    }
}

/// A test picture or a pattern as it stands on the projector, not turned.
fn test_image(test: &TestImage, size_px: [u32; 2], encoding: Encoding, camera: &str) -> Picture {
    let drawn = match test {
        TestImage::Picture(test) => Arc::new(test.draw(size_px, camera).data),
        TestImage::Pattern(pattern) => pattern.levels(),
    };
    let mut picture = Picture::default();
    picture.reset(size_px[0], size_px[1], encoding);
    let step = picture.step().max(1);
    let mut row = Vec::with_capacity(size_px[0] as usize);
    for (to, from) in picture.data.chunks_mut(step).zip(drawn.chunks(size_px[0].max(1) as usize)) {
        row.clear();
        row.extend(from.iter().map(|level| [*level, *level, *level, u8::MAX]));
        encoding.write_row(&row, to);
    }
    picture
}
