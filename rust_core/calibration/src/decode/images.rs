//! Input of the decoder, its errors, and a decoded pixel.

use crate::patterns::Pattern;

/// Images of a scan.
#[derive(Debug, Clone)]
pub struct Images<'a> {
    /// Width and height of the camera's images, pixels.
    pub size_px: [u32; 2],
    /// Projected pattern of each image.
    pub patterns: &'a [Pattern],
    /// Images in the order of the patterns: grey levels, row by row.
    pub levels: Vec<&'a [u8]>,
}

/// Failure to decode a scan.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DecodeError {
    /// A required image is missing.
    #[error("{0} is missing")]
    Missing(&'static str),
    /// Stripes along an axis, `x` or `y`, of a bit (0 is the most significant) have no inverse.
    #[error("bit {1} of the stripes along {0} has no inverse")]
    NoInverse(&'static str, u32),
    /// A bit of the code along an axis is missing although a finer one exists.
    #[error("bit {1} of the code along {0} is missing")]
    MissingBit(&'static str, u32),
    /// The code has fewer values than the projector has columns or rows.
    #[error("the code along {axis} has {codes} values, too few for the {size_px} pixels of the projector: is it of another size?")]
    ShortCode {
        /// `x` or `y`.
        axis: &'static str,
        /// Number of values.
        codes: u64,
        /// Pixels of the projector along the axis.
        size_px: u32,
    },
    /// Stripes or their most significant bit are missing.
    #[error("no code along {0}: its most significant bit is missing")]
    NoCode(&'static str),
    /// More stripes than supported.
    #[error("{count} different stripes along {axis}, at most {most} can be used")]
    TooMany {
        /// `x` or `y`.
        axis: &'static str,
        /// Number of different stripes.
        count: usize,
        /// Supported number.
        most: usize,
    },
    /// An image differs in size.
    #[error("picture {index} has {count} pixels, not {expected}")]
    Size {
        /// Index of the image.
        index: usize,
        /// Number of its pixels.
        count: usize,
        /// Expected number.
        expected: usize,
    },
    /// The numbers of images and patterns differ.
    #[error("{0} pictures, but {1} patterns: give the size and the step of those that were shown")]
    Count(usize, usize),
}

/// Projector pixel that lights a camera pixel; all values are NaN if it is unknown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DecodedPixel {
    /// Subpixel column and row.
    pub at: [f32; 2],
    /// Standard deviations, projector pixels.
    pub sigma: [f32; 2],
}

impl DecodedPixel {
    /// Unknown pixel.
    pub const NONE: Self = Self { at: [f32::NAN; 2], sigma: [f32::NAN; 2] };

    /// `true` if the pixel is known.
    pub fn is_decoded(&self) -> bool {
        !self.at[0].is_nan()
    }
}
