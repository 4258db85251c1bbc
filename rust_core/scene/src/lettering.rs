//! Letters of any size, for images that are drawn without a renderer: those of the built-in typeface of
//! [`crate::glyph_atlas`], unhinted and uncut, the same on every machine.

use skrifa::instance::{LocationRef, Size};
use skrifa::outline::DrawSettings;
use skrifa::{FontRef, MetadataProvider};

use crate::font::{rasterize, Bitmap, FONT};

/// Height of letters above the baseline, in em.
pub const LETTER_ASCENT_EM: f32 = 0.905;
/// Depth of letters below the baseline, in em.
pub const LETTER_DESCENT_EM: f32 = 0.212;

/// A letter's pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct Letter {
    /// From its origin to that of the next letter, pixels.
    pub advance_px: f32,
    /// From the origin to the bitmap's left edge, pixels to the right.
    pub left_px: i32,
    /// From the baseline to the bitmap's upper edge, pixels downwards.
    pub top_px: i32,
    /// Columns of the bitmap.
    pub width_px: u32,
    /// Rows of the bitmap.
    pub height_px: u32,
    /// Coverage of each pixel, 0 to 255, row by row from the top.
    pub coverage: Vec<u8>,
}

/// The letters of a text in this size; characters that the typeface lacks become its box for them.
pub fn letters(text: &str, em_px: f32) -> Vec<Letter> {
    let Ok(font) = FontRef::new(FONT) else { return Vec::new() };
    let (outlines, charmap, size) = (font.outline_glyphs(), font.charmap(), Size::new(em_px));
    let metrics = font.glyph_metrics(size, LocationRef::default());
    let letter = |character: char| {
        let id = charmap.map(character).unwrap_or_default();
        let settings = DrawSettings::unhinted(size, LocationRef::default());
        let Bitmap { left_px, top_px, width_px, height_px, coverage } = rasterize(&outlines, settings, id)?;
        let advance_px = metrics.advance_width(id)?;
        Some(Letter { advance_px, left_px, top_px, width_px, height_px, coverage })
    };
    text.chars().filter_map(letter).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_are_as_large_as_is_asked_for_and_whole() {
        for em_px in [8.0, 24.0, 200.0] {
            let [high, deep, space] = &letters("Hp ", em_px)[..] else { panic!("three letters") };
            let cap = 0.688 * em_px;
            assert!((high.height_px as f32 - cap).abs() < 1.5, "{em_px}: {}", high.height_px);
            assert_eq!(high.top_px + high.height_px as i32, 0, "it stands on the baseline");
            let below = deep.top_px + deep.height_px as i32;
            assert!((below as f32 / em_px - LETTER_DESCENT_EM).abs() < 0.15, "{em_px}: {below}");
            assert!(space.coverage.is_empty() && space.advance_px > 0.0);
        }
        assert_eq!(letters("\u{10ffff}", 24.0).len(), 1);
    }
}
