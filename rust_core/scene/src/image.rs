//! A finished image in one of the encodings of a `sensor_msgs/Image`, and its depths.

use fearless_simd::prelude::*;
use fearless_simd::{dispatch, u8x16, Level};

/// The longest side of an image, in pixels.
pub const MAX_SIDE_PX: u32 = 16384;

/// The encodings that a CameraPub display offers, by their names in `sensor_msgs/image_encodings`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Encoding {
    /// Red, green, blue, 8 bits each.
    #[default]
    Rgb8,
    /// Red, green, blue, alpha (always 255), 8 bits each.
    Rgba8,
    /// Blue, green, red, 8 bits each.
    Bgr8,
    /// Blue, green, red, alpha (always 255), 8 bits each.
    Bgra8,
    /// The red channel, 8 bits (Ogre takes red for luminance).
    Mono8,
    /// The red channel, 16 bits, little endian.
    Mono16,
}

/// Order of a drawn pixel's four bytes; the last one is alpha.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum PixelOrder {
    /// Red first.
    #[default]
    Rgba,
    /// Blue first.
    Bgra,
}

impl Encoding {
    /// All of them, in the order of rviz's menu.
    pub const ALL: [Self; 6] = [Self::Rgb8, Self::Rgba8, Self::Bgr8, Self::Bgra8, Self::Mono8, Self::Mono16];

    /// The name in `sensor_msgs/image_encodings`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Rgb8 => "rgb8",
            Self::Rgba8 => "rgba8",
            Self::Bgr8 => "bgr8",
            Self::Bgra8 => "bgra8",
            Self::Mono8 => "mono8",
            Self::Mono16 => "mono16",
        }
    }

    /// The encoding of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|encoding| encoding.name() == name)
    }

    /// Bytes of one pixel.
    pub const fn bytes_per_pixel(self) -> usize {
        match self {
            Self::Mono8 => 1,
            Self::Mono16 => 2,
            Self::Rgb8 | Self::Bgr8 => 3,
            Self::Rgba8 | Self::Bgra8 => 4,
        }
    }

    /// Writes one row of RGBA pixels in this encoding. `row` holds [`Self::bytes_per_pixel`] bytes for each pixel;
    /// bytes and pixels past the end of the shorter one are left alone.
    pub fn write_row(self, pixels: &[[u8; 4]], row: &mut [u8]) {
        self.write_row_from(PixelOrder::Rgba, pixels, row);
    }

    /// Like [`Self::write_row`], for pixels in another byte order.
    pub fn write_row_from(self, order: PixelOrder, pixels: &[[u8; 4]], row: &mut [u8]) {
        // Compiled for each of the processor's instruction sets, of which some shuffle bytes much faster than others;
        // and for each order, so that channels are constants.
        dispatch!(Level::new(), simd => match order {
            PixelOrder::Rgba => self.write_row_with(simd, pixels, row, [0, 1, 2]),
            PixelOrder::Bgra => self.write_row_with(simd, pixels, row, [2, 1, 0]),
        });
    }

    /// Writes a row of pixels; red, green and blue are at these indices.
    #[inline(always)]
    fn write_row_with<S: Simd>(self, simd: S, pixels: &[[u8; 4]], row: &mut [u8], [r, g, b]: [u8; 3]) {
        // Cells of a fixed size are copied without a call for each.
        #[inline(always)]
        fn write<const N: usize>(pixels: &[[u8; 4]], row: &mut [u8], cell: impl Fn(&[u8; 4]) -> [u8; N]) {
            for (to, pixel) in row.as_chunks_mut::<N>().0.iter_mut().zip(pixels) {
                *to = cell(pixel);
            }
        }
        let [red, green, blue] = [r, g, b].map(usize::from);
        match self {
            Self::Rgb8 => write_triples(simd, pixels, row, [r, g, b]),
            Self::Rgba8 => write(pixels, row, |p| [p[red], p[green], p[blue], 255]),
            Self::Bgr8 => write_triples(simd, pixels, row, [b, g, r]),
            Self::Bgra8 => write(pixels, row, |p| [p[blue], p[green], p[red], 255]),
            Self::Mono8 => write(pixels, row, |p| [p[red]]),
            Self::Mono16 => write(pixels, row, |p| (u16::from(p[red]) * 257).to_le_bytes()),
        }
    }
}

/// Writes these three channels of each pixel.
#[inline(always)]
fn write_triples<S: Simd>(simd: S, pixels: &[[u8; 4]], row: &mut [u8], channels: [u8; 3]) {
    const PIXELS: usize = 4;
    // Four pixels at once, moved together; the four bytes after them are written, too, and then written over.
    let order = u8x16::from_fn(simd, |i| (i / 3 % PIXELS * 4) as u8 + channels[i % 3]);
    let (mut done, mut rest) = (0, row);
    for pixels in pixels.as_chunks::<PIXELS>().0 {
        let Some(room) = rest.first_chunk_mut() else { break };
        u8x16::from_slice(simd, pixels.as_flattened()).swizzle_dyn_within_blocks(order).store_array(room);
        rest = rest.get_mut(3 * PIXELS..).unwrap_or(&mut []);
        done += PIXELS;
    }
    for (to, pixel) in rest.as_chunks_mut::<3>().0.iter_mut().zip(pixels.iter().skip(done)) {
        *to = [pixel[usize::from(channels[0])], pixel[usize::from(channels[1])], pixel[usize::from(channels[2])]];
    }
}

/// Resizes `data`, with any of its old elements or `blank`. Keeps its memory, unless that is several times too large.
pub fn resize_block<T: Copy>(data: &mut Vec<T>, len: usize, blank: T) {
    if data.capacity() / 4 > len || data.capacity() < len {
        // Not one that grows: what it holds is not needed, and would be copied.
        *data = Vec::with_capacity(len);
    }
    data.resize(len, blank);
}

/// An image whose bytes are laid out as in a `sensor_msgs/Image`: rows from the top, no padding, little endian.
///
/// ```
/// use rcs_scene::{Encoding, Image};
///
/// let mut image = Image::default();
/// image.reset(4, 3, Encoding::Bgr8);
/// assert_eq!((image.step(), image.data.len()), (12, 36));
///
/// let step = image.step();
/// image.encoding.write_row(&[[255, 0, 0, 255]; 4], &mut image.data[..step]);
/// assert_eq!(image.data[..3], [0, 0, 255]);
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Image {
    /// Pixels in a row.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// The meaning of the bytes.
    pub encoding: Encoding,
    /// `height · step` bytes.
    pub data: Vec<u8>,
}

impl AsRef<[u8]> for Image {
    fn as_ref(&self) -> &[u8] {
        &self.data
    }
}

impl Image {
    /// Gives it a size and encoding; the bytes may hold anything. Keeps its memory, unless that is several times too
    /// large: a single huge image must not occupy it for ever.
    pub fn reset(&mut self, width_px: u32, height_px: u32, encoding: Encoding) {
        *self = Self { width_px, height_px, encoding, data: std::mem::take(&mut self.data) };
        let bytes = self.step() * height_px as usize;
        resize_block(&mut self.data, bytes, 0);
    }

    /// Bytes of a row.
    pub fn step(&self) -> usize {
        self.width_px as usize * self.encoding.bytes_per_pixel()
    }
}

/// Metres along the optical axis for each pixel, row by row from the top; NaN where nothing is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DepthImage {
    /// Pixels in a row.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// `width · height` depths.
    pub depths_m: Vec<f32>,
}

impl DepthImage {
    /// Gives it a size, empty. Keeps its memory, unless that is several times too large.
    pub fn reset(&mut self, width_px: u32, height_px: u32) {
        (self.width_px, self.height_px) = (width_px, height_px);
        resize_block(&mut self.depths_m, width_px as usize * height_px as usize, f32::NAN);
        self.depths_m.fill(f32::NAN);
    }

    /// Leaves it without pixels; keeps its memory.
    pub fn clear(&mut self) {
        (self.width_px, self.height_px) = (0, 0);
        self.depths_m.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_encoding_is_found_by_its_name_and_writes_its_bytes() {
        let expected: [&[u8]; 6] = [&[1, 2, 3], &[1, 2, 3, 255], &[3, 2, 1], &[3, 2, 1, 255], &[1], &[1, 1]];
        for (encoding, bytes) in Encoding::ALL.into_iter().zip(expected) {
            assert_eq!(Encoding::from_name(encoding.name()), Some(encoding));
            let mut row = vec![0; encoding.bytes_per_pixel()];
            encoding.write_row(&[[1, 2, 3, 4]], &mut row);
            assert_eq!(row, bytes, "{encoding:?}");
        }
        assert_eq!(Encoding::from_name("yuv422"), None);
    }

    #[test]
    fn a_huge_image_does_not_occupy_its_memory_for_ever() {
        let mut image = Image::default();
        image.reset(4096, 4096, Encoding::Rgb8);
        let huge = image.data.capacity();
        image.reset(3000, 3000, Encoding::Rgb8);
        assert_eq!(image.data.capacity(), huge, "of similar sizes, it is kept");
        image.reset(640, 480, Encoding::Rgb8);
        assert!(image.data.capacity() < 2 * 640 * 480 * 3);
    }

    #[test]
    fn rows_of_any_width_are_written_whole_and_nothing_behind_them() {
        for encoding in Encoding::ALL {
            for width in 0..40_u8 {
                let pixels: Vec<[u8; 4]> = (0..width).map(|x| [x, 100 + x, 200 + x, 7]).collect();
                let bytes = pixels.len() * encoding.bytes_per_pixel();
                let mut row = vec![99; bytes + 20];
                encoding.write_row(&pixels, &mut row[..bytes]);
                let mut one_by_one = Vec::new();
                for pixel in &pixels {
                    let mut cell = vec![0; encoding.bytes_per_pixel()];
                    encoding.write_row(std::slice::from_ref(pixel), &mut cell);
                    one_by_one.extend(cell);
                }
                one_by_one.extend([99; 20]);
                assert_eq!(row, one_by_one, "{encoding:?}, {width} pixels");
            }
        }
    }
}
