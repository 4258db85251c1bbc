//! Calibrating a projector: lens models, patterns, decoding, solving, and what a report says.
//!
//! No ROS, no files, no windows, no drawing: numbers in, numbers out. Pixels are those of ROS and OpenCV (u right, v
//! down, an integer is a pixel's centre), lengths are metres, frames are optical frames (z along the light or view, x
//! right, y down). Transforms are named `target_from_source`.

#![forbid(unsafe_code)]

mod decode;
mod distortion;
mod lens;
pub mod patterns;
mod plane;
mod points;
mod sample;

pub use decode::{decode, DecodeError, Decoded, DecodedPixel, Pictures, Quality, ScanProblem};
pub use distortion::{Distorted, Distortion, DistortionModel, DistortionProblem};
pub use lens::{Landing, Lens};
pub use points::{points, PointsError};
pub use sample::Sample;
