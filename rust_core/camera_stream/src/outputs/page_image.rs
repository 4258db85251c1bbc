//! Encoding of images for the operator's page: PNG, or JPEG of half the size, whichever costs less.
//!
//! An image costs the time that its encoding takes and the time that its bytes take on the way, at [`BYTES_PER_SEC`].
//! Each image is encoded in the format whose last image cost less; the other format is tried again with each
//! [`TRY_EVERY`]th, because the content decides: lines on black are small as PNG, a photograph is not.

use std::time::Instant;

use rcs_files::picture_file::{encode, Coding};
use rcs_scene::{Encoding, Picture};
use rcs_web::{ImageFile, ImageFormat};

/// Images after which the other format is tried.
const TRY_EVERY: u32 = 50;
/// Rate of a wireless network, in bytes.
const BYTES_PER_SEC: f64 = 5e6;
/// Quality of JPEG images, at which text is readable.
const JPEG_QUALITY: u8 = 80;

/// Costs of both formats.
#[derive(Debug, Default)]
pub(super) struct Costs {
    /// Seconds that the last PNG and the last JPEG image cost.
    last_secs: [Option<f64>; 2],
    images: u32,
}

impl Costs {
    /// Encodes an image in the cheaper format.
    ///
    /// # Errors
    /// The encoder's.
    pub(super) fn encode(&mut self, picture: &Picture, stamp_secs: f64) -> Result<ImageFile, String> {
        let format = self.choose();
        let begun = Instant::now();
        let file = file(picture, format, stamp_secs)?;
        let secs = begun.elapsed().as_secs_f64() + file.bytes.len() as f64 / BYTES_PER_SEC;
        self.last_secs[index(format)] = Some(secs);
        Ok(file)
    }

    fn choose(&mut self) -> ImageFormat {
        self.images = self.images.wrapping_add(1);
        let cheaper = match self.last_secs {
            [Some(png), Some(jpeg)] if jpeg < png => ImageFormat::Jpeg,
            [Some(_), None] => ImageFormat::Jpeg,
            _ => ImageFormat::Png,
        };
        match (self.images % TRY_EVERY, cheaper) {
            (0, ImageFormat::Png) => ImageFormat::Jpeg,
            (0, ImageFormat::Jpeg) => ImageFormat::Png,
            _ => cheaper,
        }
    }
}

fn index(format: ImageFormat) -> usize {
    match format {
        ImageFormat::Png => 0,
        ImageFormat::Jpeg => 1,
    }
}

fn file(picture: &Picture, format: ImageFormat, stamp_secs: f64) -> Result<ImageFile, String> {
    let full_size_px = [picture.width_px, picture.height_px];
    let (encoded, size_px) = match format {
        ImageFormat::Png => (encode(picture, Coding::Png { level: 1 }), full_size_px),
        ImageFormat::Jpeg => {
            let half = half(picture);
            (encode(&half, Coding::Jpeg { quality: JPEG_QUALITY }), [half.width_px, half.height_px])
        }
    };
    let bytes = encoded.map_err(|error| error.to_string())?;
    Ok(ImageFile { format, size_px, full_size_px, stamp_secs, bytes })
}

/// A mask of half the size; `None` if it cannot be encoded. One that allows all light everywhere is a single pixel.
pub(super) fn mask_file(mask: &Picture, stamp_secs: f64) -> Option<ImageFile> {
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

/// The picture at half its width and height, each pixel the mean of four. 16-bit greys become 8-bit ones.
fn half(picture: &Picture) -> Picture {
    let channels = picture.encoding.bytes_per_pixel();
    let encoding = if picture.encoding == Encoding::Mono16 { Encoding::Mono8 } else { picture.encoding };
    let size = |side: u32| (side / 2).max(1);
    let mut small = Picture::default();
    small.reset(size(picture.width_px), size(picture.height_px), encoding);
    let (step, small_step) = (picture.step(), small.step().max(1));
    // The high byte of a 16-bit value is its 8-bit one.
    let skip = channels - encoding.bytes_per_pixel();
    for (row, to) in small.data.chunks_exact_mut(small_step).enumerate() {
        let rows = [2 * row, (2 * row + 1).min(picture.height_px.max(1) as usize - 1)];
        let [above, below] = rows.map(|row| picture.data.get(row * step..(row + 1) * step).unwrap_or_default());
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

    fn picture(encoding: Encoding, width_px: u32, height_px: u32, data: &[u8]) -> Picture {
        Picture { width_px, height_px, encoding, data: data.to_owned() }
    }

    #[test]
    fn half_a_picture_has_the_means_of_four_pixels() {
        let grey = half(&picture(Encoding::Mono8, 4, 2, &[0, 10, 50, 50, 20, 30, 50, 50]));
        assert_eq!((grey.width_px, grey.height_px, &*grey.data), (2, 1, &[15, 50][..]));
        let color = half(&picture(Encoding::Rgb8, 3, 3, &[9; 27]));
        assert_eq!((color.width_px, color.height_px, &*color.data), (1, 1, &[9; 3][..]));
        let deep = half(&picture(Encoding::Mono16, 2, 2, &[0xff, 8, 0xff, 8, 0, 8, 0, 8]));
        assert_eq!((deep.encoding, &*deep.data), (Encoding::Mono8, &[8][..]));
        let single = half(&picture(Encoding::Rgba8, 1, 1, &[1, 2, 3, 4]));
        assert_eq!((single.width_px, &*single.data), (1, &[1, 2, 3, 4][..]));
    }

    #[test]
    fn the_cheaper_format_is_used_and_the_other_tried_again() {
        let mut costs = Costs::default();
        assert_eq!(costs.choose(), ImageFormat::Png);
        costs.last_secs[0] = Some(0.1);
        assert_eq!(costs.choose(), ImageFormat::Jpeg, "not known yet");
        costs.last_secs[1] = Some(0.2);
        let chosen: Vec<_> = (0..100).map(|_| costs.choose()).collect();
        assert_eq!(chosen.iter().filter(|format| **format == ImageFormat::Jpeg).count(), 2);
        costs.last_secs[1] = Some(0.05);
        assert_eq!(costs.choose(), ImageFormat::Jpeg);
    }

    #[test]
    fn both_formats_tell_the_whole_size() {
        let image = picture(Encoding::Bgr8, 8, 4, &[100; 96]);
        for (format, size_px) in [(ImageFormat::Png, [8, 4]), (ImageFormat::Jpeg, [4, 2])] {
            let file = file(&image, format, 2.5).unwrap();
            assert_eq!((file.format, file.size_px, file.full_size_px, file.stamp_secs), (format, size_px, [8, 4], 2.5));
        }
        let mask = |level| mask_file(&picture(Encoding::Mono8, 4, 4, &[level; 16]), 1.0).unwrap().size_px;
        assert_eq!((mask(255), mask(254)), ([1, 1], [2, 2]));
    }
}
