//! Sizes as a user types them: two values with an x between them.

use crate::capture::MOST_PIXELS;

/// Width and height, pixels: `1280x800`.
///
/// # Errors
/// The fault, as a phrase.
pub fn size_px(text: &str) -> Result<[u32; 2], String> {
    let [width, height] = pair(text).ok_or("not a size such as 1280x800")?;
    let side = |text: &str| match text.parse() {
        Ok(side) if (1..=MOST_PIXELS).contains(&side) => Ok(side),
        _ => Err(format!("'{text}' is not a number of pixels from 1 to {MOST_PIXELS}")),
    };
    Ok([side(width)?, side(height)?])
}

/// The two sides of an x, a comma or white space.
pub fn pair(text: &str) -> Option<[&str; 2]> {
    let (first, second) =
        text.trim().split_once(['x', 'X', '×', ',', ';']).or_else(|| text.trim().split_once(char::is_whitespace))?;
    Some([first.trim(), second.trim()])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_whole_pixels() {
        for text in ["1280x800", " 1280 x 800 ", "1280×800", "1280,800", "1280 800", "1280X800"] {
            assert_eq!(size_px(text), Ok([1280, 800]), "{text}");
        }
        for text in ["", "1280", "1280x", "0x800", "1280x-8", "1280x800x3", "1e3x8", "99999x800", "1280.5x800"] {
            assert!(size_px(text).is_err(), "{text}");
        }
    }
}
