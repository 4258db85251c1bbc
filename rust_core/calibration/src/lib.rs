//! Projector calibration: lens models, patterns, decoding, solving, reports.
//!
//! No ROS, no files, no windows, no drawing: numbers in, numbers out. Pixels are those of ROS and OpenCV (u right, v
//! down, integers at pixel centres), lengths are metres, frames are optical frames (z along the light or view, x right,
//! y down). Transforms are named `target_from_source`.

#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod blend;
pub mod board;
mod crossings;
mod decode;
mod distortion;
mod keystone;
mod lens;
pub mod manual;
pub mod patterns;
mod plane;
mod points;
mod report;
mod reprojection;
mod sample;
mod solve;
pub mod statistics;
mod table;
mod verification;

pub use blend::{blend_weights, BlendProblem, BlendWeights, PlacedProjector};
use crossings::crossings;
pub use decode::{decode, DecodeError, Decoded, DecodedPixel, ImageFault, Images, Quality, ScanProblem, WrongImage};
pub use distortion::{Distorted, Distortion, DistortionModel, DistortionProblem};
pub use keystone::Keystone;
pub use lens::{Lens, ProjectedPoint};
pub use points::{points, DepthImageError};
pub use report::{Coverage, Report, Verdict};
pub use reprojection::ReprojectionError;
pub use sample::Sample;
pub use solve::{
    solve, DistortionTerms, Estimate, FocalLengths, Parameter, Refusal, Residual, ScanPose, Skew, Solution,
    SolveOptions,
};
pub use table::{Table, TableProblem};
pub use verification::{
    ErrorStatistics, LightMap, PoseRefinement, RefinedPose, RefinementProblem, VerificationPlan, VerificationProblem,
    VerificationResult, VerificationScene, VerifiedPoint, Zoom,
};
