//! How an image is turned for the way in which its projector is mounted.

use std::fmt;
use std::str::FromStr;

use rayon::prelude::*;
use rcs_scene::{resize_block, Image};

/// Rows that a thread writes at once where rows become columns: as many cells as are read together.
const ROWS: usize = 32;

/// The image is first mirrored, left to right, if it is, and then turned clockwise by quarters.
///
/// ```
/// use rcs_render::Orientation;
///
/// let rear: Orientation = "mirrored".parse()?;
/// assert_eq!(rear.size_px([1280, 800]), [1280, 800]);
/// let on_its_side: Orientation = "mirrored-90".parse()?;
/// assert_eq!(on_its_side.size_px([1280, 800]), [800, 1280]);
/// assert!("45".parse::<Orientation>().is_err());
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Orientation {
    /// Left and right are swapped, before it is turned.
    pub is_mirrored: bool,
    /// Quarters that it is turned by, clockwise: 0 to 3.
    quarters: u8,
}

impl FromStr for Orientation {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (is_mirrored, angle) = match text.strip_prefix("mirrored") {
            Some("") => (true, "0"),
            Some(rest) => (true, rest.strip_prefix('-').unwrap_or("")),
            None => (false, text),
        };
        let quarters = ["0", "90", "180", "270"].iter().position(|known| *known == angle);
        let quarters = quarters.ok_or_else(|| {
            format!("{text} is not 0, 90, 180 or 270, mirrored, mirrored-90, mirrored-180 or mirrored-270")
        })?;
        Ok(Self { is_mirrored, quarters: quarters as u8 })
    }
}

impl fmt::Display for Orientation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.is_mirrored, self.degrees()) {
            (true, 0) => f.write_str("mirrored"),
            (true, degrees) => write!(f, "mirrored-{degrees}"),
            (false, degrees) => write!(f, "{degrees}"),
        }
    }
}

impl Orientation {
    /// By how many degrees the image is turned, clockwise: 0, 90, 180 or 270.
    pub fn degrees(self) -> u32 {
        u32::from(self.quarters) * 90
    }

    /// The size of an image of this size when it is turned.
    pub fn size_px(self, [width, height]: [u32; 2]) -> [u32; 2] {
        if self.quarters.is_multiple_of(2) {
            [width, height]
        } else {
            [height, width]
        }
    }

    /// Writes the turned image to another one.
    pub fn turn(self, from: &Image, to: &mut Image) {
        let [width, height] = self.size_px([from.width_px, from.height_px]);
        to.reset(width, height, from.encoding);
        let size_px = [from.width_px, from.height_px];
        self.turn_cells(size_px, from.encoding.bytes_per_pixel(), &from.data, &mut to.data);
    }

    /// As [`Self::turn`], for an image of this size with 1 to 4 bytes for each pixel, row by row.
    pub fn turn_cells(self, size_px: [u32; 2], cell_bytes: usize, from: &[u8], to: &mut Vec<u8>) {
        resize_block(to, from.len(), 0);
        match cell_bytes {
            1 => self.turn_cells_of::<1>(size_px, from, to),
            2 => self.turn_cells_of::<2>(size_px, from, to),
            3 => self.turn_cells_of::<3>(size_px, from, to),
            _ => self.turn_cells_of::<4>(size_px, from, to),
        }
    }

    fn turn_cells_of<const N: usize>(self, size_px: [u32; 2], from: &[u8], to: &mut [u8]) {
        let [width, height] = size_px.map(|side| side as usize);
        let (source, _) = from.as_chunks::<N>();
        let (target, _) = to.as_chunks_mut::<N>();
        if source.is_empty() {
            return;
        }
        let is_upside_down = self.quarters == 2;
        if self.quarters.is_multiple_of(2) {
            // Turned by half, a row is read backwards; mirrored, too; both, forwards.
            let is_backwards = is_upside_down != self.is_mirrored;
            target.par_chunks_mut(width).enumerate().for_each(|(row, to)| {
                let row = if is_upside_down { height - 1 - row } else { row };
                let from = source.get(row * width..(row + 1) * width).unwrap_or_default();
                if is_backwards {
                    to.iter_mut().zip(from.iter().rev()).for_each(|(to, from)| *to = *from);
                } else {
                    to.copy_from_slice(from);
                }
            });
            return;
        }
        // A row is a column of the source, from its bottom up if the image is turned right.
        let is_up = self.quarters == 1;
        let is_from_right = (self.quarters == 3) != self.is_mirrored;
        target.par_chunks_mut(height * ROWS).enumerate().for_each(|(strip, to)| {
            let rows = to.len() / height;
            for column in 0..height {
                let row = if is_up { height - 1 - column } else { column };
                let first = strip * ROWS;
                let first = if is_from_right { width - first - rows } else { first };
                let cells = source.get(row * width + first..row * width + first + rows).unwrap_or_default();
                for (index, cell) in cells.iter().enumerate() {
                    let index = if is_from_right { rows - 1 - index } else { index };
                    if let Some(to) = to.get_mut(index * height + column) {
                        *to = *cell;
                    }
                }
            }
        });
    }
}
