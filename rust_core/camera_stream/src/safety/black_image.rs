//! A black image, and one small line of text that says why.

use rcs_scene::{letters, Encoding, Image, Letter, LETTER_ASCENT_EM, LETTER_DESCENT_EM};

/// Height of the text as a share of the image's, within limits.
const HEIGHT_SHARE: f32 = 1.0 / 40.0;
const EM_PX: std::ops::RangeInclusive<f32> = 9.0..=28.0;
/// Level of the text: grey, because it is light, too.
const BRIGHTEST: u32 = 140;

/// A black image.
pub(crate) fn black_image([width_px, height_px]: [u32; 2], encoding: Encoding) -> Image {
    let mut image = Image::default();
    image.reset(width_px, height_px, encoding);
    let black = vec![[0, 0, 0, 255]; width_px as usize];
    let step = image.step();
    for row in image.data.chunks_mut(step.max(1)) {
        encoding.write_row(&black, row);
    }
    image
}

/// Writes a note at the image's lower left, cut off at the right edge.
pub(crate) fn write_note(image: &mut Image, text: &str) {
    let em_px = (image.height_px as f32 * HEIGHT_SHARE).clamp(*EM_PX.start(), *EM_PX.end());
    let margin = em_px / 2.0;
    let baseline = image.height_px as f32 - margin - LETTER_DESCENT_EM * em_px;
    if baseline < LETTER_ASCENT_EM * em_px {
        return;
    }
    let mut at = margin;
    for letter in letters(text, em_px) {
        stamp(image, &letter, at.round() as i64, baseline.round() as i64);
        at += letter.advance_px;
    }
}

/// Draws a letter with this origin.
fn stamp(image: &mut Image, letter: &Letter, x: i64, baseline: i64) {
    let (encoding, step) = (image.encoding, image.step());
    let cell = encoding.bytes_per_pixel();
    let rows = letter.coverage.chunks(letter.width_px.max(1) as usize);
    for (row, coverage) in (baseline + i64::from(letter.top_px)..).zip(rows) {
        for (column, covered) in (x + i64::from(letter.left_px)..).zip(coverage) {
            let (Ok(row), Ok(column)) = (usize::try_from(row), usize::try_from(column)) else { continue };
            if column >= image.width_px as usize || *covered == 0 {
                continue;
            }
            let level = (u32::from(*covered) * BRIGHTEST / 255) as u8;
            let begin = row * step + column * cell;
            if let Some(pixel) = image.data.get_mut(begin..begin + cell) {
                encoding.write_row(&[[level, level, level, 255]], pixel);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of pixels that are not black, and the bytes of the first pixel.
    fn lit(encoding: Encoding, note: Option<&str>) -> (usize, Vec<u8>) {
        let mut image = black_image([320, 200], encoding);
        note.into_iter().for_each(|note| write_note(&mut image, note));
        assert_eq!((image.width_px, image.height_px, image.encoding), (320, 200, encoding));
        let cells = image.data.chunks(encoding.bytes_per_pixel());
        let black = image.data[..encoding.bytes_per_pixel()].to_vec();
        (cells.filter(|cell| **cell != *black).count(), black)
    }

    #[test]
    fn it_is_black_in_every_encoding_and_its_note_is_small() {
        for encoding in Encoding::ALL {
            let mut black = vec![0; encoding.bytes_per_pixel()];
            encoding.write_row(&[[0, 0, 0, 255]], &mut black);
            assert_eq!(lit(encoding, None), (0, black.clone()), "{encoding:?}");
            let (with_note, corner) = lit(encoding, Some("cloud: no data on /cloud of the last 1 s"));
            assert!((300..3000).contains(&with_note) && corner == black, "{encoding:?}: {with_note}");
        }
    }

    #[test]
    fn a_image_that_is_too_small_has_no_note_and_a_long_one_is_cut() {
        let has_note = |size_px, note: &str| {
            let mut image = black_image(size_px, Encoding::Mono8);
            write_note(&mut image, note);
            image.data.iter().any(|level| *level > 0)
        };
        assert!(!has_note([100, 5], "why") && has_note([100, 50], &"why ".repeat(1000)));
    }
}
