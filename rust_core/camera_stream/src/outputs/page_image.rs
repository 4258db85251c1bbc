//! Encoding of images for the operator's page: JPEG of half the size, or PNG of a small image.

use rcs_files::image_file::{encode, Coding};
use rcs_scene::{Encoding, Image};
use rcs_web::{ImageFile, ImageFormat};

/// Most pixels of a small image.
const SMALL_PX: u64 = 640 * 480;
/// Quality of JPEG images, at which text is readable.
const JPEG_QUALITY: u8 = 80;

/// Encodes an image.
///
/// # Errors
/// The encoder's.
pub(super) fn image_file(image: &Image, stamp_secs: f64) -> Result<ImageFile, String> {
    let full_size_px = [image.width_px, image.height_px];
    let is_small = u64::from(image.width_px) * u64::from(image.height_px) <= SMALL_PX;
    let (format, encoded, size_px) = if is_small {
        (ImageFormat::Png, encode(image, Coding::Png { level: 1 }), full_size_px)
    } else {
        let half = half(image);
        let encoded = encode(&half, Coding::Jpeg { quality: JPEG_QUALITY });
        (ImageFormat::Jpeg, encoded, [half.width_px, half.height_px])
    };
    let bytes = encoded.map_err(|error| error.to_string())?;
    Ok(ImageFile { format, size_px, full_size_px, stamp_secs, bytes })
}

/// A mask of half the size; `None` if it cannot be encoded. One that allows all light everywhere is a single pixel.
pub(super) fn mask_file(mask: &Image, stamp_secs: f64) -> Option<ImageFile> {
    let full_size_px = [mask.width_px, mask.height_px];
    let mut small = half(mask);
    if mask.data.iter().all(|level| *level == u8::MAX) {
        small.reset(1, 1, Encoding::Mono8);
        small.data.fill(u8::MAX);
    }
    let size_px = [small.width_px, small.height_px];
    let bytes = encode(&small, Coding::Png { level: 1 });
    let bytes = bytes.map_err(|error| log::error!("the page: cannot encode a mask: {error}")).ok()?;
    Some(ImageFile { format: ImageFormat::Png, size_px, full_size_px, stamp_secs, bytes })
}

/// The image at half its width and height, each pixel the mean of four. 16-bit greys become 8-bit ones.
fn half(image: &Image) -> Image {
    let channels = image.encoding.bytes_per_pixel();
    let encoding = if image.encoding == Encoding::Mono16 { Encoding::Mono8 } else { image.encoding };
    let size = |side: u32| (side / 2).max(1);
    let mut small = Image::default();
    small.reset(size(image.width_px), size(image.height_px), encoding);
    let (step, small_step) = (image.step(), small.step().max(1));
    // The high byte of a 16-bit value is its 8-bit one.
    let skip = channels - encoding.bytes_per_pixel();
    for (row, to) in small.data.chunks_exact_mut(small_step).enumerate() {
        let rows = [2 * row, (2 * row + 1).min(image.height_px.max(1) as usize - 1)];
        let [above, below] = rows.map(|row| image.data.get(row * step..(row + 1) * step).unwrap_or_default());
        let pairs = above.chunks(2 * channels).zip(below.chunks(2 * channels));
        for (to, (above, below)) in to.chunks_exact_mut(encoding.bytes_per_pixel()).zip(pairs) {
            for (channel, to) in to.iter_mut().enumerate() {
                let at = |row: &[u8], pixel| {
                    u16::from(row.get(pixel * channels + channel + skip).copied().unwrap_or(row[channel + skip]))
                };
                *to = ((at(above, 0) + at(above, 1) + at(below, 0) + at(below, 1) + 2) / 4) as u8;
            }
        }
    }
    small
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(encoding: Encoding, width_px: u32, height_px: u32, data: &[u8]) -> Image {
        Image { width_px, height_px, encoding, data: data.to_owned() }
    }

    #[test]
    fn half_a_image_has_the_means_of_four_pixels() {
        let grey = half(&image(Encoding::Mono8, 4, 2, &[0, 10, 50, 50, 20, 30, 50, 50]));
        assert_eq!((grey.width_px, grey.height_px, &*grey.data), (2, 1, &[15, 50][..]));
        let color = half(&image(Encoding::Rgb8, 3, 3, &[9; 27]));
        assert_eq!((color.width_px, color.height_px, &*color.data), (1, 1, &[9; 3][..]));
        let deep = half(&image(Encoding::Mono16, 2, 2, &[0xff, 8, 0xff, 8, 0, 8, 0, 8]));
        assert_eq!((deep.encoding, &*deep.data), (Encoding::Mono8, &[8][..]));
        let single = half(&image(Encoding::Rgba8, 1, 1, &[1, 2, 3, 4]));
        assert_eq!((single.width_px, &*single.data), (1, &[1, 2, 3, 4][..]));
    }

    #[test]
    fn a_small_image_is_a_png_and_a_larger_one_a_jpeg_of_half_the_size() {
        for (width_px, format, size_px) in [(640, ImageFormat::Png, [640, 480]), (642, ImageFormat::Jpeg, [321, 240])] {
            let image = image(Encoding::Mono8, width_px, 480, &vec![100; width_px as usize * 480]);
            let file = image_file(&image, 2.5).unwrap();
            let described = (file.format, file.size_px, file.full_size_px, file.stamp_secs);
            assert_eq!(described, (format, size_px, [width_px, 480], 2.5));
        }
        let mask = |level| mask_file(&image(Encoding::Mono8, 4, 4, &[level; 16]), 1.0).unwrap().size_px;
        assert_eq!((mask(255), mask(254)), ([1, 1], [2, 2]));
    }
}
