//! Reading the images of a capture. Their size is known from the CameraInfo before anything is decoded, so that a
//! small file cannot announce a large image.

use std::io::BufReader;
use std::path::Path;

use image::{ColorType, ImageDecoder, ImageReader, Limits};

use super::error::CaptureError;

/// Memory of a decoder besides the pixels, bytes.
const DECODER_BYTES: u64 = 64 << 20;

/// Brightness of each pixel of an 8-bit image: the luma of BT.601, rounded, without opacity.
pub(super) fn read_grey(path: &Path, size_px: [u32; 2]) -> Result<Vec<u8>, CaptureError> {
    let (color, bytes) = read_image(path, size_px, |color| match color {
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => None,
        _ => Some("8 bits"),
    })?;
    Ok(match color {
        ColorType::La8 => bytes.chunks_exact(2).map(|pixel| pixel[0]).collect(),
        ColorType::Rgb8 => bytes.chunks_exact(3).map(|pixel| luma(pixel[0], pixel[1], pixel[2])).collect(),
        ColorType::Rgba8 => bytes.chunks_exact(4).map(|pixel| luma(pixel[0], pixel[1], pixel[2])).collect(),
        _ => bytes,
    })
}

/// Luma of ITU-R BT.601, rounded to the nearest.
fn luma(red: u8, green: u8, blue: u8) -> u8 {
    let [red, green, blue] = [red, green, blue].map(u32::from);
    // At most 255, since the weights add up to 1000.
    ((299 * red + 587 * green + 114 * blue + 500) / 1000) as u8
}

/// Depth of each pixel of a 16-bit grey image of this size, metres; 0 for none. `scale_m` are metres of the depth 1.
///
/// # Errors
/// [`CaptureError`]: the file cannot be read, or is another image.
pub fn read_depth(path: &Path, size_px: [u32; 2], scale_m: f64) -> Result<Vec<f32>, CaptureError> {
    let (_, bytes) = read_image(path, size_px, |color| match color {
        ColorType::L16 => None,
        _ => Some("16-bit grey"),
    })?;
    // The decoder yields the machine's byte order.
    let values = bytes.chunks_exact(2).map(|pair| u16::from_ne_bytes([pair[0], pair[1]]));
    Ok(values.map(|value| (f64::from(value) * scale_m) as f32).collect())
}

/// Pixels of an image of this size. `wanted` names the format needed instead of an unsupported one.
fn read_image(
    path: &Path,
    camera_px: [u32; 2],
    wanted: impl Fn(ColorType) -> Option<&'static str>,
) -> Result<(ColorType, Vec<u8>), CaptureError> {
    let decode_error = |source| CaptureError::Decode { path: path.to_owned(), source };
    let (file, _) =
        rcs_user_files::open(path).map_err(|source| CaptureError::Read { path: path.to_owned(), source })?;
    let mut limits = Limits::default();
    limits.max_alloc = Some(DECODER_BYTES + 8 * u64::from(camera_px[0]) * u64::from(camera_px[1]));
    let reader = ImageReader::new(BufReader::new(file)).with_guessed_format();
    let mut reader = reader.map_err(|source| CaptureError::Read { path: path.to_owned(), source })?;
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(decode_error)?;
    let (width, height) = decoder.dimensions();
    if [width, height] != camera_px {
        return Err(CaptureError::Size { path: path.to_owned(), size_px: [width, height], camera_px });
    }
    let color = decoder.color_type();
    if let Some(wanted) = wanted(color) {
        let found = format!(
            "{} channel{} of {} bits",
            color.channel_count(),
            if color.channel_count() == 1 { "" } else { "s" },
            8 * u16::from(color.bytes_per_pixel()) / u16::from(color.channel_count())
        );
        return Err(CaptureError::Pixels { path: path.to_owned(), found, wanted });
    }
    // In range: the size is that of the CameraInfo, which has been checked.
    let mut bytes = vec![0; decoder.total_bytes() as usize];
    decoder.read_image(&mut bytes).map_err(decode_error)?;
    Ok((color, bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn luma_is_that_of_opencv() {
        assert_eq!(luma(255, 255, 255), 255);
        assert_eq!((luma(255, 0, 0), luma(0, 255, 0), luma(0, 0, 255)), (76, 150, 29));
        assert_eq!(luma(1, 2, 3), 2);
    }
}
