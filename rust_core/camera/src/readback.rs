//! An image as read back from a graphics library: rows that may be padded, upside down, and in another channel order.

use rcs_scene::{Encoding, PixelOrder};

/// Bytes of a pixel.
const CELL: usize = 4;

/// A drawn image of four bytes a pixel.
#[derive(Clone, Copy, Debug)]
pub struct Readback<'a> {
    bytes: &'a [u8],
    width: usize,
    height: usize,
    row_bytes: usize,
    order: PixelOrder,
    is_bottom_up: bool,
}

/// Mismatch of bytes and image size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReadbackProblem {
    /// Bytes from one row to the next, the pixels of a row that do not fit, and their bytes.
    #[error("{0} bytes from one row to the next, where {1} pixels need at least {2}")]
    ShortRows(usize, u32, usize),
    /// Number of bytes, the image's size, and the bytes that it needs.
    #[error("{0} bytes, where {w}x{h} pixels need at least {2}", w = .1[0], h = .1[1])]
    ShortImage(usize, [u32; 2], usize),
    /// The bytes of a size and of its rows overflow.
    #[error("{w}x{h} pixels in rows of {1} bytes are more than a memory holds", w = .0[0], h = .0[1])]
    TooLarge([u32; 2], usize),
}

impl<'a> Readback<'a> {
    /// Bytes from the first row's first pixel to the last row's last one of an image of this size with `row_bytes`
    /// from one row to the next.
    ///
    /// # Errors
    /// Rows that are too short for their pixels; a size that overflows.
    pub fn needed_bytes([width_px, height_px]: [u32; 2], row_bytes: usize) -> Result<usize, ReadbackProblem> {
        let too_large = || ReadbackProblem::TooLarge([width_px, height_px], row_bytes);
        let needed = (width_px as usize).checked_mul(CELL).ok_or_else(too_large)?;
        if row_bytes < needed {
            return Err(ReadbackProblem::ShortRows(row_bytes, width_px, needed));
        }
        let Some(rows_before) = (height_px as usize).checked_sub(1) else { return Ok(0) };
        let bytes = rows_before.checked_mul(row_bytes).and_then(|bytes| bytes.checked_add(needed));
        bytes.filter(|bytes| isize::try_from(*bytes).is_ok()).ok_or_else(too_large)
    }

    /// The image of this size in these bytes; surplus bytes are ignored.
    ///
    /// # Errors
    /// See [`ReadbackProblem`].
    pub fn new(
        bytes: &'a [u8],
        [width_px, height_px]: [u32; 2],
        row_bytes: usize,
        order: PixelOrder,
        is_bottom_up: bool,
    ) -> Result<Self, ReadbackProblem> {
        let needed = Self::needed_bytes([width_px, height_px], row_bytes)?;
        if bytes.len() < needed {
            return Err(ReadbackProblem::ShortImage(bytes.len(), [width_px, height_px], needed));
        }
        Ok(Self { bytes, width: width_px as usize, height: height_px as usize, row_bytes, order, is_bottom_up })
    }

    /// Writes the image in an encoding, from the top, without padding; bytes and rows past the end of `to` are left
    /// out.
    pub fn write(&self, encoding: Encoding, to: &mut [u8]) {
        let step = (self.width * encoding.bytes_per_pixel()).max(1);
        for (row, to) in to.chunks_mut(step).take(self.height).enumerate() {
            encoding.write_row_from(self.order, self.row(row), to);
        }
    }

    /// The pixels of a row, counted from the top.
    fn row(&self, row: usize) -> &'a [[u8; CELL]] {
        let stored = if self.is_bottom_up { self.height - 1 - row } else { row };
        let begin = stored * self.row_bytes;
        let row = self.bytes.get(begin..begin + self.width * CELL).unwrap_or_default();
        row.as_chunks().0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three rows of two pixels, each with its row and column for colours, and a padding of three bytes.
    fn bytes(order: PixelOrder, is_bottom_up: bool) -> Vec<u8> {
        let mut bytes = Vec::new();
        for stored in 0..3 {
            let row = if is_bottom_up { 2 - stored } else { stored };
            for column in 0..2 {
                let [r, g, b] = [10 + row, 20 + column, 30];
                bytes.extend(match order {
                    PixelOrder::Rgba => [r, g, b, 7],
                    PixelOrder::Bgra => [b, g, r, 7],
                });
            }
            bytes.extend([99; 3]);
        }
        bytes.truncate(bytes.len() - 3);
        bytes
    }

    #[test]
    fn all_orders_and_encodings_show_the_same_image() {
        for encoding in Encoding::ALL {
            let cell = encoding.bytes_per_pixel();
            let mut expected = Vec::new();
            for (row, column) in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)] {
                let mut pixel = vec![0; cell];
                encoding.write_row(&[[10 + row, 20 + column, 30, 255]], &mut pixel);
                expected.extend(pixel);
            }
            for order in [PixelOrder::Rgba, PixelOrder::Bgra] {
                for is_bottom_up in [false, true] {
                    let bytes = bytes(order, is_bottom_up);
                    let image = Readback::new(&bytes, [2, 3], 11, order, is_bottom_up).unwrap();
                    let mut written = vec![0; 6 * cell];
                    image.write(encoding, &mut written);
                    assert_eq!(written, expected, "{encoding:?}, {order:?}, {is_bottom_up}");
                    let mut short = vec![0; 3 * cell];
                    image.write(encoding, &mut short);
                    assert_eq!(short, expected[..3 * cell], "what does not fit is left out");
                }
            }
        }
    }

    #[test]
    fn sizes_are_checked_without_overflow() {
        let problem = |length: usize, size_px, row_bytes| {
            Readback::new(&vec![0; length], size_px, row_bytes, PixelOrder::Rgba, false).unwrap_err().to_string()
        };
        assert!(problem(30, [2, 3], 7).starts_with("7 bytes from one row"));
        assert!(problem(29, [2, 3], 11).starts_with("29 bytes, where 2x3 pixels need at least 30"));
        assert!(problem(8, [u32::MAX, u32::MAX], usize::MAX).contains("more than a memory holds"));
        assert!(problem(8, [1, 3], usize::MAX / 2).contains("more than a memory holds"));
        for size_px in [[0, 0], [0, 5], [5, 0]] {
            let mut nothing = [];
            Readback::new(&[], size_px, 20, PixelOrder::Rgba, true)
                .map(|empty| empty.write(Encoding::Rgb8, &mut nothing))
                .ok();
        }
    }
}
