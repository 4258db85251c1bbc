//! Solving: from samples to the projector's lens and pose.
//!
//! The steps, each a file: `input` checks and sorts the samples; `consensus` finds a first lens and pose among gross
//! errors by linear solutions (`dlt`) or, for a known lens, by three points (`p3p`, `quartic`); `adjust` makes all of
//! it fit best in the sense of `noise` and `depth_errors`, on the equations of `normal_equations` for the unknowns of
//! `model`; `left_out` chooses the distortion; `covariance`, by the sums of `cells` and what `correlation` sees in
//! them, says how certain the result is, and `skew` whether it is a lens at all. `spread`, `orientation`, `moved`
//! and `motion` find the scenes and scans that are to be refused. `solver` has the order of the steps.
//!
//! The result depends on the samples, the options and the seed alone: sums are formed in the same order whatever the
//! number of threads.

use std::fmt;

use nalgebra::{Isometry3, Vector2};

use crate::Lens;

mod adjust;
mod cells;
mod consensus;
mod correlation;
mod covariance;
mod depth_errors;
mod dlt;
mod input;
mod left_out;
mod model;
mod motion;
mod moved;
mod noise;
mod normal_equations;
mod orientation;
mod p3p;
mod quartic;
mod random;
mod refusal;
mod skew;
mod solver;
mod spread;
#[cfg(test)]
pub(crate) mod synthetic;
#[cfg(test)]
mod tests;

pub(crate) use dlt::skew_of_all;
pub use refusal::Refusal;
pub use solver::solve;

/// Which terms of Brown and Conrady's distortion are solved for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DistortionTerms {
    /// Those that make the prediction of left-out points better.
    #[default]
    Auto,
    /// None: a pinhole.
    None,
    /// k1.
    K1,
    /// k1 and k2.
    K1K2,
    /// k1, k2, p1, p2 and k3.
    PlumbBob,
}

/// How many focal lengths are solved for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FocalLengths {
    /// fx = fy.
    One,
    /// fx and fy.
    #[default]
    Two,
}

/// A parameter of the lens.
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
    /// All of them.
    pub const ALL: [Self; 9] =
        [Self::Fx, Self::Fy, Self::Cx, Self::Cy, Self::K1, Self::K2, Self::P1, Self::P2, Self::K3];

    /// The name that K and D are explained with: fx, fy, cx, cy, k1, k2, p1, p2, k3.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fx => "fx",
            Self::Fy => "fy",
            Self::Cx => "cx",
            Self::Cy => "cy",
            Self::K1 => "k1",
            Self::K2 => "k2",
            Self::P1 => "p1",
            Self::P2 => "p2",
            Self::K3 => "k3",
        }
    }

    /// The parameter of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|parameter| parameter.name() == name)
    }
}

impl fmt::Display for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What is solved for, and what is known already.
#[derive(Debug, Clone, PartialEq)]
pub struct SolveOptions {
    /// Width and height of the projector's picture, pixels.
    pub size_px: [u32; 2],
    /// The terms of the distortion.
    pub distortion: DistortionTerms,
    /// The focal lengths.
    pub focal: FocalLengths,
    /// Parameters that are known and stay as they are.
    pub fixed: Vec<(Parameter, f64)>,
    /// A lens to start from instead of one from a linear solution.
    pub initial: Option<Lens>,
    /// A lens that is known: only the pose is solved for, for which a flat scene suffices.
    pub known_lens: Option<Lens>,
    /// The seed of random choices; the same samples and seed give the same solution.
    pub seed: u64,
}

impl SolveOptions {
    /// Everything is to be found.
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

    /// The same with all terms of the distortion, none of them fixed; unchanged if they are chosen anyway.
    pub(crate) fn with_all_terms(&self) -> Self {
        let mut options = self.clone();
        options.fixed.retain(|(parameter, _)| (*parameter as usize) < Parameter::K1 as usize);
        if options.distortion != DistortionTerms::Auto {
            options.distortion = DistortionTerms::PlumbBob;
        }
        options
    }
}

/// The pose of one scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanPose {
    /// The number of the scan, see [`crate::Sample::scan`].
    pub scan: u32,
    /// From the optical frame of the camera to that of the projector.
    pub projector_from_camera: Isometry3<f64>,
    /// Standard deviations of the projector's position in the camera's optical frame, metres.
    pub position_sigma_m: [f64; 3],
    /// Standard deviations of the projector's orientation: turns about the axes of its own optical frame, radians.
    pub orientation_sigma_rad: [f64; 3],
    /// How many samples of this scan are inliers.
    pub inliers: usize,
}

/// A parameter of the lens as it was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Which one.
    pub parameter: Parameter,
    /// Its value, in the parameter's unit.
    pub value: f64,
    /// Its standard deviation; 0 if it was fixed.
    pub sigma: f64,
}

/// A skew (the second number of K's first row) that the samples would be explained with better. No lens has one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Skew {
    /// Its value, pixels.
    pub value_px: f64,
    /// Its standard deviation.
    pub sigma_px: f64,
}

/// A motion during a scan that is too small to refuse the scan for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SuspectedMotion {
    /// The number of the scan.
    pub scan: u32,
    /// By how much it moved the light, root of the mean square over the samples, pixels.
    pub apart_px: f64,
}

/// How far the light of a sample's pixel lands from its point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residual {
    /// The index of the sample.
    pub sample: usize,
    /// The pixel that was seen less the pixel that the solution predicts, pixels.
    pub error_px: Vector2<f64>,
    /// The same as a distance at the point's depth, metres.
    pub error_m: Vector2<f64>,
    /// Depth of the point in the projector's optical frame, metres.
    pub depth_m: f64,
    /// Whether the sample took part in the solution.
    pub is_inlier: bool,
}

/// The projector's lens and where the camera saw it from.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// The lens.
    pub lens: Lens,
    /// All parameters of the lens, fixed ones included.
    pub estimates: Vec<Estimate>,
    /// Which terms of the distortion were solved for, never `Auto`.
    pub distortion: DistortionTerms,
    /// One for each scan, in rising order of their numbers.
    pub poses: Vec<ScanPose>,
    /// One for each sample, in their order. Samples that the solution cannot project (behind the projector) have none.
    pub residuals: Vec<Residual>,
    /// Root of the mean squared distance of the inliers from their prediction, pixels.
    pub rms_px: f64,
    /// The same for points that were left out while the rest was solved for, in turns, so that each was left out once.
    pub held_out_rms_px: f64,
    /// The farthest inlier, pixels.
    pub max_px: f64,
    /// How many samples took part.
    pub inliers: usize,
    /// Standard deviation of where a point's light is predicted, by the uncertainty of lens and pose alone, pixels:
    /// root of the mean square over the whole picture and the depths of the inliers.
    pub prediction_sigma_px: f64,
    /// How skewed the picture seems; none if the lens was not solved for.
    pub skew: Option<Skew>,
    /// The largest small motion during a scan; none if nothing seems to have moved.
    pub motion: Option<SuspectedMotion>,
}
