//! Limits of images that are read, checked before they are decoded: a run of equal pixels takes a few bytes, so that
//! the length of a file does not limit them.

use std::fs::File;
use std::path::Path;

use image::{ImageDecoder, Limits};
use rcs_scene::MAX_SIDE_PX;

use crate::FileError;

/// Most bytes of a file.
const MOST_FILE_BYTES: u64 = 512 << 20;
/// Most bytes of a pixel: four channels of 16 bits.
const MOST_PIXEL_BYTES: u64 = 8;

/// Limits of a kind of images, besides [`MAX_SIDE_PX`] a side.
pub(crate) struct ImageLimits {
    /// Most pixels.
    pub(crate) most_px: u64,
    /// Advice about a larger one.
    pub(crate) to_do: &'static str,
}

impl ImageLimits {
    /// Opens a file.
    ///
    /// # Errors
    /// The system's, and files that are not regular or too large.
    pub(crate) fn open(&self, path: &Path) -> Result<File, FileError> {
        let opened = rcs_user_files::open_limited(path, MOST_FILE_BYTES);
        opened.map_err(|error| FileError::new(path, format_args!("cannot read it: {error}")))
    }

    /// Limits of the decoder's memory.
    pub(crate) fn of_decoder(&self) -> Limits {
        let mut limits = Limits::default();
        limits.max_alloc = Some(2 * MOST_PIXEL_BYTES * self.most_px);
        limits
    }

    /// Checks the size, which a decoder knows before it decodes the pixels.
    ///
    /// # Errors
    /// The size and the limit that it exceeds.
    pub(crate) fn check(&self, path: &Path, decoder: &impl ImageDecoder) -> Result<(), FileError> {
        let (width, height) = decoder.dimensions();
        let limit = if width.max(height) > MAX_SIDE_PX {
            format!("{MAX_SIDE_PX} a side")
        } else if u64::from(width) * u64::from(height) > self.most_px {
            format!("{} in all", self.most_px)
        } else {
            return Ok(());
        };
        let to_do = self.to_do;
        let problem = format!("cannot read it: {width}x{height} pixels, more than {limit}; {to_do}");
        Err(FileError::new(path, problem))
    }
}
