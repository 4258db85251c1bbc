//! Solver: from samples to the projector's lens and pose.
//!
//! `solver` runs the steps: `input` checks and sorts the samples; `consensus` finds a first lens and pose among gross
//! errors by linear solutions (`dlt`) or, for a known lens, by three points (`p3p`); `adjust` is the robust
//! least-squares adjustment by `levenberg_marquardt` with the error model of `noise`, the equations of
//! `normal_equations` and the unknowns of `model`; `held_out` selects the distortion terms by cross-validation;
//! `covariance` estimates the uncertainty from the sums of `cells` and their `correlation`; `skew` tests whether the
//! result is a lens at all. `zoom` estimates the focal length of an otherwise known lens. `spread`, `orientation`,
//! `moved` and `motion` detect scenes and scans to refuse.
//!
//! The result depends on samples, options and seed alone: sums are formed in the same order for any number of threads.

use std::fmt;

use nalgebra::{Isometry3, Vector2};

use crate::Lens;

mod adjust;
mod cells;
mod consensus;
mod correlation;
mod covariance;
mod dlt;
mod held_out;
mod input;
mod levenberg_marquardt;
mod model;
mod motion;
mod moved;
mod noise;
mod normal_equations;
mod orientation;
mod p3p;
pub(crate) mod random;
mod refusal;
mod skew;
mod solver;
mod spread;
#[cfg(test)]
mod tests;
mod zoom;

pub(crate) use dlt::skew_of_all;
pub(crate) use levenberg_marquardt::{inverse_of_positive, levenberg_marquardt, MOST_STEPS};
pub(crate) use model::{lens_of, lens_values, moved_pose, SolverState, LENS};
pub(crate) use noise::{cauchy_loss, cauchy_weight};
pub(crate) use normal_equations::NormalEquations;
pub use refusal::Refusal;
pub use solver::solve;
pub(crate) use spread::LargestPlane;
pub(crate) use zoom::{zoom, ZoomEstimate};

/// Terms of Brown and Conrady's distortion to solve for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DistortionTerms {
    /// Terms that improve the prediction of held-out points.
    #[default]
    Auto,
    /// Pinhole.
    None,
    /// k1.
    K1,
    /// k1 and k2.
    K1K2,
    /// k1, k2, p1, p2 and k3.
    PlumbBob,
}

/// Number of focal lengths to solve for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FocalLengths {
    /// fx = fy.
    One,
    /// fx and fy.
    #[default]
    Two,
}

/// Lens parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Parameter {
    /// Focal length along u, pixels.
    Fx,
    /// Focal length along v, pixels.
    Fy,
    /// Principal point along u, pixels.
    Cx,
    /// Principal point along v, pixels.
    Cy,
    /// Radial distortion.
    K1,
    /// Radial distortion.
    K2,
    /// Tangential distortion.
    P1,
    /// Tangential distortion.
    P2,
    /// Radial distortion.
    K3,
}

impl Parameter {
    /// All parameters.
    pub const ALL: [Self; 9] =
        [Self::Fx, Self::Fy, Self::Cx, Self::Cy, Self::K1, Self::K2, Self::P1, Self::P2, Self::K3];

    /// Name: fx, fy, cx, cy, k1, k2, p1, p2, k3.
    pub const fn name(self) -> &'static str {
        ["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"][self as usize]
    }

    /// Parameter of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|parameter| parameter.name() == name)
    }
}

impl fmt::Display for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Unknowns and known values.
#[derive(Debug, Clone, PartialEq)]
pub struct SolveOptions {
    /// Width and height of the projector's image, pixels.
    pub size_px: [u32; 2],
    /// Distortion terms.
    pub distortion: DistortionTerms,
    /// Focal lengths.
    pub focal: FocalLengths,
    /// Fixed parameters.
    pub fixed: Vec<(Parameter, f64)>,
    /// Initial lens, instead of a linear solution.
    pub initial: Option<Lens>,
    /// Known lens: only the pose is solved for, for which a flat scene suffices.
    pub known_lens: Option<Lens>,
    /// Seed of random choices; the same samples and seed give the same solution.
    pub seed: u64,
}

impl SolveOptions {
    /// Creates options with everything unknown.
    pub fn new(size_px: [u32; 2]) -> Self {
        Self {
            size_px,
            distortion: DistortionTerms::Auto,
            focal: FocalLengths::Two,
            fixed: Vec::new(),
            initial: None,
            known_lens: None,
            seed: 0,
        }
    }

    /// Options with all distortion terms, none of them fixed; unchanged if they are selected anyway.
    pub(crate) fn with_all_terms(&self) -> Self {
        let mut options = self.clone();
        options.fixed.retain(|(parameter, _)| (*parameter as usize) < Parameter::K1 as usize);
        if options.distortion != DistortionTerms::Auto {
            options.distortion = DistortionTerms::PlumbBob;
        }
        options
    }
}

/// Pose of one scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanPose {
    /// Number of the scan, see [`crate::Sample::scan`].
    pub scan: u32,
    /// Pose, from the camera's optical frame to the projector's.
    pub projector_from_camera: Isometry3<f64>,
    /// Standard deviations of the projector's position in the camera's optical frame, metres.
    pub position_sigma_m: [f64; 3],
    /// Standard deviations of the projector's orientation about the axes of its own optical frame, radians.
    pub orientation_sigma_rad: [f64; 3],
    /// Number of inliers.
    pub inliers: usize,
}

/// Estimated lens parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Parameter.
    pub parameter: Parameter,
    /// Value, in the parameter's unit.
    pub value: f64,
    /// Standard deviation; 0 if fixed.
    pub sigma: f64,
}

/// Estimated skew (K's second entry). No lens has one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Skew {
    /// Value, pixels.
    pub value_px: f64,
    /// Standard deviation, pixels.
    pub sigma_px: f64,
}

/// Residual of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residual {
    /// Index of the sample.
    pub sample: usize,
    /// Observed minus predicted pixel.
    pub error_px: Vector2<f64>,
    /// Error at the point's depth, metres.
    pub error_m: Vector2<f64>,
    /// Depth in the projector's optical frame, metres.
    pub depth_m: f64,
    /// `true` if the sample was used.
    pub is_inlier: bool,
}

/// Lens and poses with their uncertainty.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// Lens.
    pub lens: Lens,
    /// All lens parameters, fixed ones included.
    pub estimates: Vec<Estimate>,
    /// Distortion terms that were solved for, never `Auto`.
    pub distortion: DistortionTerms,
    /// Poses by rising scan number.
    pub poses: Vec<ScanPose>,
    /// Residuals in the samples' order. Samples that cannot be projected have none.
    pub residuals: Vec<Residual>,
    /// RMS error of the inliers, pixels.
    pub rms_px: f64,
    /// Held-out RMS error by cross-validation, pixels.
    pub held_out_rms_px: f64,
    /// Maximum error of an inlier, pixels.
    pub max_px: f64,
    /// Number of inliers.
    pub inliers: usize,
    /// Standard deviation of predicted pixels by the uncertainty of lens and pose alone: RMS over the image and the
    /// inliers' depths.
    pub prediction_sigma_px: f64,
    /// Estimated skew; `None` if the lens was not solved for.
    pub skew: Option<Skew>,
}
