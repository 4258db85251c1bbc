//! Pictures as PNG files.

use std::path::Path;

use crate::png::{write_png, PngError, PngFormat};
use rcs_scene::{Encoding, Picture};

/// Writes a picture as a PNG: colours as RGB whatever the encoding's order, mono8 as grey, mono16 as 16-bit grey.
///
/// # Errors
/// When the file cannot be written.
pub fn write(path: &Path, picture: &Picture) -> Result<(), PngError> {
    let save = |format, bytes: &[u8]| write_png(path, picture.width_px, picture.height_px, format, bytes);
    let rgb = |order: [usize; 3], size: usize| -> Vec<u8> {
        picture.data.chunks_exact(size).flat_map(|pixel| order.map(|channel| pixel[channel])).collect()
    };
    match picture.encoding {
        Encoding::Rgb8 => save(PngFormat::Rgb8, &picture.data),
        Encoding::Rgba8 => save(PngFormat::Rgb8, &rgb([0, 1, 2], 4)),
        Encoding::Bgr8 => save(PngFormat::Rgb8, &rgb([2, 1, 0], 3)),
        Encoding::Bgra8 => save(PngFormat::Rgb8, &rgb([2, 1, 0], 4)),
        Encoding::Mono8 => save(PngFormat::Gray8, &picture.data),
        Encoding::Mono16 => {
            let native = picture.data.chunks_exact(2).flat_map(|b| u16::from_le_bytes([b[0], b[1]]).to_ne_bytes());
            save(PngFormat::Gray16, &native.collect::<Vec<u8>>())
        }
    }
}
