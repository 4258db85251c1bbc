//! A received image in the format of the window's surface.
//!
//! [`ScreenImage`] holds one `u32` a pixel, `0x00RRGGBB`. It is made from the fields of a `sensor_msgs/Image`, in any
//! [`Encoding`] of a camera stream. Alpha is dropped, as in `image_view`. Sixteen bits of grey become eight with
//! rounding, so an eight-bit image widened to sixteen bits comes back exactly.
//!
//! [`ScreenImage::draw_unscaled`] copies it to a surface of any size: image pixel (u, v) is surface pixel (u, v),
//! the rest is cropped or black.

use rcs_scene::{Encoding, Image};

/// An image of one `0x00RRGGBB` value a pixel, rows from the top, no padding.
///
/// ```
/// use rcs_window::{ReceivedImage, ScreenImage};
///
/// let received = ReceivedImage {
///     width_px: 2,
///     height_px: 1,
///     step_bytes: 6,
///     encoding: "bgr8",
///     is_bigendian: false,
///     data: &[0, 0, 255, 0, 0, 255],
/// };
/// assert_eq!(ScreenImage::from_received(&received)?, ScreenImage::from_fn(2, 1, |_, _| [255, 0, 0]));
/// # Ok::<(), rcs_window::ImageError>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ScreenImage {
    width_px: u32,
    height_px: u32,
    pixels: Vec<u32>,
}

/// The borrowed fields of a `sensor_msgs/Image`.
#[derive(Debug, Clone, Copy)]
pub struct ReceivedImage<'a> {
    /// Columns.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// Bytes from the start of one row to the start of the next.
    pub step_bytes: u32,
    /// Name of the pixel format, as in `sensor_msgs/image_encodings.h`.
    pub encoding: &'a str,
    /// `true` if pixels of more than eight bits a channel have their high byte first.
    pub is_bigendian: bool,
    /// The pixels.
    pub data: &'a [u8],
}

impl<'a> From<&'a Image> for ReceivedImage<'a> {
    fn from(image: &'a Image) -> Self {
        Self {
            width_px: image.width_px,
            height_px: image.height_px,
            // No image with data has rows beyond u32.
            step_bytes: u32::try_from(image.step()).unwrap_or(u32::MAX),
            encoding: image.encoding.name(),
            is_bigendian: false,
            data: &image.data,
        }
    }
}

/// A received image whose fields contradict each other, or whose encoding is not an [`Encoding`].
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ImageError(String);

/// Appends the pixels of one row's bytes.
type ReadRow = fn(&[u8], &mut Vec<u32>);

/// The bits of the three channels.
const RGB: u32 = 0x00ff_ffff;

/// Packs three channels into `0x00RRGGBB`.
fn pack([r, g, b]: [u8; 3]) -> u32 {
    u32::from_be_bytes([0, r, g, b])
}

/// Sixteen bits of grey as eight, rounded: the inverse of `v8 * 257`.
fn narrow(grey16: u16) -> u8 {
    let rounded = (u32::from(grey16) + 128) / 257;
    u8::try_from(rounded).unwrap_or(u8::MAX)
}

/// Reads a row of pixels of `N` bytes.
fn row<const N: usize>(bytes: &[u8], pixels: &mut Vec<u32>, to_rgb: impl Fn([u8; N]) -> [u8; 3]) {
    pixels.extend(bytes.as_chunks().0.iter().map(|pixel| pack(to_rgb(*pixel))));
}

/// Reads a row of pixels of three bytes, four pixels at once, which is faster.
fn row_of_three(
    bytes: &[u8],
    pixels: &mut Vec<u32>,
    four: impl Fn([u8; 8], [u8; 4]) -> [u32; 4],
    to_rgb: impl Fn([u8; 3]) -> [u8; 3],
) {
    let (fours, rest) = bytes.as_chunks::<12>();
    pixels.extend(
        fours.iter().flat_map(|[a, b, c, d, e, f, g, h, last @ ..]| four([*a, *b, *c, *d, *e, *f, *g, *h], *last)),
    );
    row(rest, pixels, to_rgb);
}

/// Four pixels, red first.
fn four_rgb(first: [u8; 8], last: [u8; 4]) -> [u32; 4] {
    let (first, last) = (u64::from_be_bytes(first), u32::from_be_bytes(last));
    let third = (first as u32) << 8 | last >> 24;
    [(first >> 40) as u32, (first >> 16) as u32 & RGB, third & RGB, last & RGB]
}

/// Four pixels, blue first.
fn four_bgr(first: [u8; 8], last: [u8; 4]) -> [u32; 4] {
    let (first, last) = (u64::from_le_bytes(first), u32::from_le_bytes(last));
    let third = (first >> 48) as u32 | last << 16;
    [first as u32 & RGB, (first >> 24) as u32 & RGB, third & RGB, last >> 8]
}

/// The function that reads rows of an encoding.
fn read_row(encoding: Encoding, is_bigendian: bool) -> ReadRow {
    match encoding {
        Encoding::Rgb8 => |bytes, pixels| row_of_three(bytes, pixels, four_rgb, |[r, g, b]| [r, g, b]),
        Encoding::Rgba8 => |bytes, pixels| row(bytes, pixels, |[r, g, b, _]| [r, g, b]),
        Encoding::Bgr8 => |bytes, pixels| row_of_three(bytes, pixels, four_bgr, |[b, g, r]| [r, g, b]),
        Encoding::Bgra8 => |bytes, pixels| row(bytes, pixels, |[b, g, r, _]| [r, g, b]),
        Encoding::Mono8 => |bytes, pixels| row(bytes, pixels, |[grey]| [grey; 3]),
        Encoding::Mono16 if is_bigendian => {
            |bytes, pixels| row(bytes, pixels, |grey| [narrow(u16::from_be_bytes(grey)); 3])
        }
        Encoding::Mono16 => |bytes, pixels| row(bytes, pixels, |grey| [narrow(u16::from_le_bytes(grey)); 3]),
    }
}

impl ScreenImage {
    /// Reads a received image.
    ///
    /// # Errors
    /// [`ImageError`] if the encoding is unknown, the image is empty, or the data are shorter than the header
    /// claims. Data beyond the last row are ignored, as image_transport's viewers ignore them.
    pub fn from_received(received: &ReceivedImage<'_>) -> Result<Self, ImageError> {
        let mut image = Self::default();
        image.read(received)?;
        Ok(image)
    }

    /// Replaces the image by a received one, in the same memory. Unchanged on an error.
    ///
    /// # Errors
    /// As for [`Self::from_received`].
    pub fn read(&mut self, received: &ReceivedImage<'_>) -> Result<(), ImageError> {
        let ReceivedImage { width_px, height_px, step_bytes, encoding, is_bigendian, data } = *received;
        let Some(known) = Encoding::from_name(encoding) else {
            return Err(ImageError(format!(
                "unsupported encoding '{encoding}'; supported: rgb8, rgba8, bgr8, bgra8, mono8, mono16"
            )));
        };
        if width_px == 0 || height_px == 0 {
            return Err(ImageError(format!("the picture is {width_px}x{height_px} pixels")));
        }
        let row_bytes = u64::from(width_px) * known.bytes_per_pixel() as u64;
        if u64::from(step_bytes) < row_bytes {
            return Err(ImageError(format!(
                "a row of {width_px} pixels in {encoding} takes {row_bytes} bytes, but step is {step_bytes}"
            )));
        }
        let needed_bytes = u64::from(height_px - 1) * u64::from(step_bytes) + row_bytes;
        if (data.len() as u64) < needed_bytes {
            return Err(ImageError(format!(
                "{height_px} rows of {step_bytes} bytes need {needed_bytes} bytes of data, but there are {}",
                data.len()
            )));
        }
        // The data hold `needed_bytes`, so all sizes below fit memory.
        let row_bytes = width_px as usize * known.bytes_per_pixel();
        (self.width_px, self.height_px) = (width_px, height_px);
        self.pixels.clear();
        self.pixels.reserve(width_px as usize * height_px as usize);
        let read_row = read_row(known, is_bigendian);
        for row in data.chunks(step_bytes as usize).take(height_px as usize) {
            read_row(row.get(..row_bytes).unwrap_or(row), &mut self.pixels);
        }
        Ok(())
    }

    /// Converts a drawn image.
    ///
    /// # Errors
    /// [`ImageError`] if the image is empty, or has less data than its size needs.
    pub fn from_image(image: &Image) -> Result<Self, ImageError> {
        Self::from_received(&image.into())
    }

    /// An image whose pixel (u, v) is `color(u, v)`, each `[red, green, blue]`.
    pub fn from_fn(width_px: u32, height_px: u32, mut color: impl FnMut(u32, u32) -> [u8; 3]) -> Self {
        let mut pixels = Vec::with_capacity(width_px as usize * height_px as usize);
        for v in 0..height_px {
            pixels.extend((0..width_px).map(|u| pack(color(u, v))));
        }
        Self { width_px, height_px, pixels }
    }

    /// `true` if all pixels are black.
    pub fn is_black(&self) -> bool {
        self.pixels.iter().all(|pixel| *pixel == 0)
    }

    /// The pixels, `0x00RRGGBB`, rows from the top.
    pub(crate) fn pixels(&self) -> &[u32] {
        &self.pixels
    }

    /// Columns and rows, in pixels.
    pub fn size_px(&self) -> (u32, u32) {
        (self.width_px, self.height_px)
    }

    /// Copies the image to the top left of a surface `surface_width_px` wide, without scaling. The rest becomes
    /// black.
    pub fn draw_unscaled(&self, surface: &mut [u32], surface_width_px: u32) {
        if surface_width_px == 0 {
            return;
        }
        let shown = self.width_px.min(surface_width_px) as usize;
        let mut rows = self.pixels.chunks(self.width_px.max(1) as usize);
        for out in surface.chunks_mut(surface_width_px as usize) {
            let row = rows.next().and_then(|row| row.get(..shown)).unwrap_or(&[]);
            let (covered, rest) = out.split_at_mut(row.len().min(out.len()));
            covered.copy_from_slice(row.get(..covered.len()).unwrap_or(&[]));
            rest.fill(0);
        }
    }
}

/// Three bytes a pixel, red first, of surface pixels (`0x00RRGGBB`).
pub(crate) fn rgb_bytes(pixels: &[u32]) -> Vec<u8> {
    pixels
        .iter()
        .flat_map(|pixel| {
            let [_, r, g, b] = pixel.to_be_bytes();
            [r, g, b]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn received<'a>(encoding: &'a str, width_px: u32, step_bytes: u32, data: &'a [u8]) -> ReceivedImage<'a> {
        ReceivedImage { width_px, height_px: 2, step_bytes, encoding, is_bigendian: false, data }
    }

    #[test]
    fn rows_of_any_width_are_read_pixel_by_pixel() {
        for width_px in 1..30_u8 {
            let row: Vec<u8> = (0..3 * width_px).map(|i| i.wrapping_mul(37).wrapping_add(200)).collect();
            let step = 3 * u32::from(width_px);
            for encoding in ["rgb8", "bgr8"] {
                let data = [row.clone(), row.iter().rev().copied().collect()].concat();
                let read = ScreenImage::from_received(&received(encoding, u32::from(width_px), step, &data)).unwrap();
                let expected = ScreenImage::from_fn(u32::from(width_px), 2, |u, v| {
                    let at = (v * step + 3 * u) as usize;
                    let [a, b, c] = [data[at], data[at + 1], data[at + 2]];
                    if encoding == "rgb8" {
                        [a, b, c]
                    } else {
                        [c, b, a]
                    }
                });
                assert_eq!(read, expected, "{encoding}, {width_px} pixels");
            }
        }
    }

    #[test]
    fn every_encoding_is_read_in_its_channel_order() {
        let cases: [(&str, &[u8], u32); 6] = [
            ("rgb8", &[1, 2, 3], 0x010203),
            ("rgba8", &[1, 2, 3, 200], 0x010203),
            ("bgr8", &[1, 2, 3], 0x030201),
            ("bgra8", &[1, 2, 3, 200], 0x030201),
            ("mono8", &[7], 0x070707),
            ("mono16", &[0x12, 0x34], 0x343434),
        ];
        for (encoding, pixel, expected) in cases {
            let data = pixel.repeat(4);
            let step = u32::try_from(pixel.len() * 2).unwrap();
            let image = ScreenImage::from_received(&received(encoding, 2, step, &data)).unwrap();
            assert_eq!(image.pixels, vec![expected; 4], "{encoding}");
            assert_eq!(image.size_px(), (2, 2));
        }
    }

    #[test]
    fn mono16_honours_the_byte_order_and_inverts_widening_exactly() {
        let mut image = received("mono16", 1, 2, &[0x12, 0x34, 0x12, 0x34]);
        image.is_bigendian = true;
        assert_eq!(ScreenImage::from_received(&image).unwrap().pixels, vec![0x121212; 2]);
        for grey in 0..=u8::MAX {
            assert_eq!(narrow(u16::from(grey) * 257), grey);
        }
        assert_eq!(narrow(u16::MAX), 255);
    }

    #[test]
    fn padding_between_rows_is_skipped_and_missing_after_the_last() {
        let data = [1, 2, 3, 99, 99, 4, 5, 6];
        let image = ScreenImage::from_received(&received("rgb8", 1, 5, &data)).unwrap();
        assert_eq!(image.pixels, vec![0x010203, 0x040506]);
    }

    #[test]
    fn data_shorter_than_claimed_is_refused_not_read_past() {
        let error = |image: &ReceivedImage<'_>| ScreenImage::from_received(image).unwrap_err().to_string();
        let short = error(&received("rgb8", 1, 3, &[0; 5]));
        assert!(short.ends_with("need 6 bytes of data, but there are 5"), "{short}");
        let narrow = error(&received("bgra8", 2, 7, &[0; 64]));
        assert!(narrow.ends_with("takes 8 bytes, but step is 7"), "{narrow}");
        let huge = ReceivedImage {
            width_px: u32::MAX,
            height_px: u32::MAX,
            step_bytes: u32::MAX,
            encoding: "mono8",
            is_bigendian: false,
            data: &[0; 8],
        };
        assert!(error(&huge).ends_with("bytes of data, but there are 8"));
    }

    #[test]
    fn unknown_encodings_and_empty_images_are_named() {
        let error = ScreenImage::from_received(&received("bayer_rggb8", 1, 1, &[0; 2])).unwrap_err();
        assert!(error.to_string().contains("bayer_rggb8"));
        let error = ScreenImage::from_received(&received("mono8", 0, 0, &[])).unwrap_err();
        assert_eq!(error.to_string(), "the picture is 0x2 pixels");
    }

    #[test]
    fn a_smaller_image_lies_at_the_top_left_and_the_rest_is_black() {
        let image = ScreenImage::from_fn(2, 2, |u, v| [u as u8 + 1, v as u8 + 1, 9]);
        let mut surface = vec![0x00ff_ffff; 12];
        image.draw_unscaled(&mut surface, 4);
        assert_eq!(surface, [0x010109, 0x020109, 0, 0, 0x010209, 0x020209, 0, 0, 0, 0, 0, 0]);
    }

    #[test]
    fn a_larger_image_is_cut_off_at_the_right_and_bottom() {
        let image = ScreenImage::from_fn(4, 3, |u, v| [u as u8, v as u8, 0]);
        let mut surface = vec![0x00ff_ffff; 4];
        image.draw_unscaled(&mut surface, 2);
        assert_eq!(surface, [0x000000, 0x010000, 0x000100, 0x010100]);
        assert_eq!(rgb_bytes(&surface), [0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0]);
    }
}
