//! Projector intrinsics from a tape measure: the paper's jig.
//!
//! The projector stands still and throws its image onto a flat wall at right angles to its optical axis. Measured are
//! the image's width W and height H, the distance Z from the lens to the wall, and the intersection (X, Y) of the
//! optical axis and the wall, from the image's top left corner: X to the right, Y down, all in metres. For an image of
//! w×h pixels
//!
//! ```text
//! fx = w·Z/W    fy = h·Z/H    cx = w·X/W    cy = h·Y/H
//! ```
//!
//! The light's origin inside the housing is not visible from outside; an error of a centimetre at a metre makes f wrong
//! by 1 %. A second distance cancels it, since the image grows in proportion to the *difference*:
//!
//! ```text
//! fx = w·(Z2 − Z1)/(W2 − W1)    fy = h·(Z2 − Z1)/(H2 − H1)
//! ```
//!
//! The principal point does not depend on that origin. Each distance gives c/w = X/W; of two, the least-squares value
//! counts: c/w = (X1·W1 + X2·W2)/(W1² + W2²), which gives the larger image, whose pixels are larger in comparison with
//! the tape's errors, more weight. (The difference, w·(X2 − X1)/(W2 − W1), would be several times less certain.) c is
//! never clamped to the image: many projectors throw upwards, with the axis below the image.
//!
//! Edges are not rounded to pixel centres: half a pixel is a third of a millimetre in such an image, less than the tape
//! shows.

mod measures;
mod solve;
#[cfg(test)]
mod tests;
mod warning;

pub use measures::{ManualError, ManualMeasures, WallMeasures};
pub use solve::{solve, ManualAccuracy, ManualLens};
pub use warning::{compare_matrices, ManualWarning, MatrixDifference};
