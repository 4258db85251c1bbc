//! Images in place of the scene's: black ones, notes, test images and patterns of a calibration.

use std::sync::Arc;

use rcs_light::Grant;
use rcs_scene::{Encoding, Image};

use super::frame::{FrameContent, FrameSpec, TestContent};
use crate::outputs::FrameImage;
use crate::safety::black_image::{black_image, write_note};

/// The image of a frame that shows no scene. `camera` is the text of the test image with the name.
pub(super) fn image(spec: &FrameSpec, encoding: Encoding, camera: &str) -> FrameImage {
    let shown_px = spec.orientation.size_px(spec.content.size_px());
    let lit = spec.grant.clone().and_then(|grant| match &spec.content {
        FrameContent::Scene { .. } | FrameContent::Black { .. } => None,
        FrameContent::Note { size_px, dark } => {
            let mut image = black_image(*size_px, encoding);
            write_note(&mut image, &dark.why);
            grant.light(image, &mut Image::default())
        }
        FrameContent::Test { test, .. } => grant.light_turned(test_image(test, shown_px, encoding, camera)),
    });
    lit.map_or_else(|| FrameImage::black(shown_px, encoding), FrameImage::lit)
}

/// The grant of a pattern, which is shown for a while only.
pub(super) fn grant_of(test: &TestContent, grant: Grant) -> Grant {
    match test {
        TestContent::Image(_) => grant,
        TestContent::Pattern(pattern) => grant.until_at_most(pattern.until()),
    }
}

/// A test image or a pattern as it stands on the projector, not turned.
fn test_image(test: &TestContent, size_px: [u32; 2], encoding: Encoding, camera: &str) -> Image {
    let drawn = match test {
        TestContent::Image(test) => Arc::new(test.draw(size_px, camera).data),
        TestContent::Pattern(pattern) => pattern.levels(),
    };
    let mut image = Image::default();
    image.reset(size_px[0], size_px[1], encoding);
    let step = image.step().max(1);
    let mut row = Vec::with_capacity(size_px[0] as usize);
    for (to, from) in image.data.chunks_mut(step).zip(drawn.chunks(size_px[0].max(1) as usize)) {
        row.clear();
        row.extend(from.iter().map(|level| [*level, *level, *level, u8::MAX]));
        encoding.write_row(&row, to);
    }
    image
}
