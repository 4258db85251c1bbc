//! Limits of a capture's size.

use std::path::Path;

use super::error::CaptureError;

/// Largest width and height of an image of a camera or a projector, pixels.
pub const MOST_PIXELS: u32 = 16_384;
/// Largest number of patterns of a capture.
pub const MOST_PATTERNS: usize = 1000;
/// Largest size of all images together, as grey, bytes.
pub const MOST_BYTES: u64 = 8 << 30;

/// Checks that the images fit into memory.
pub(super) fn check_amount(path: &Path, size_px: [u32; 2], patterns: usize) -> Result<(), CaptureError> {
    let [width, height] = size_px.map(u64::from);
    if size_px.iter().any(|size| *size > MOST_PIXELS) {
        return Err(CaptureError::TooLarge { path: path.to_owned(), size_px, most_px: MOST_PIXELS });
    }
    if width * height * patterns as u64 > MOST_BYTES {
        return Err(CaptureError::TooMuch { path: path.to_owned(), patterns, size_px, most_bytes: MOST_BYTES });
    }
    Ok(())
}
