//! Whether a projector still has the zoom of its file.
//!
//! A zoom scales the image, and so does a motion along the axis, at one depth. They differ in how much farther and
//! nearer points move; where depth hardly varies, nothing can tell them apart.

use rayon::prelude::*;

use crate::solve::pose_error;
use crate::statistics::{median, quantile};
use crate::{solve, DistortionTerms, FocalLengths, Lens, Parameter, Sample, Solution, SolveOptions};

/// Minimum variation of depth that tells a zoom from a motion, as a share of the depth.
const LEAST_VARIATION: f64 = 0.15;
/// Shares of the points that are nearer and farther than the range that counts as the variation.
const ENDS: [f64; 2] = [0.05, 0.95];
/// Changes of the focal length that are no change: deviations, and a share.
const SURE: f64 = 4.0;
const NEGLIGIBLE: f64 = 0.01;
/// Minimum share of spots that agree with the lens's own zoom, roughly: with a wrong one, only those of one depth do.
const AGREEING: f64 = 0.85;
/// Else the focal lengths to start from, half a percent of the lens's each.
const STARTS: std::ops::Range<i32> = 156..256;

/// Zoom of a projector, compared with its file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Zoom {
    /// It is as in the file, within this deviation: a share of the focal length.
    Unchanged {
        /// Standard deviation, as a share of the focal length.
        sigma: f64,
    },
    /// It differs.
    Changed {
        /// Change as a share of the focal length.
        change: f64,
        /// Standard deviation of that.
        sigma: f64,
    },
    /// Depths vary too little to tell.
    Undecidable {
        /// Variation of depth, as a share of the depth.
        variation: f64,
    },
}

/// Compares the zoom with that of a lens.
pub(super) fn check(samples: &[Sample], lens: &Lens) -> Zoom {
    let mut depths: Vec<f64> = samples.iter().map(|sample| sample.point.z).collect();
    let [near, far] = ENDS.map(|share| quantile(&mut depths, share));
    let variation = (far - near) / median(&mut depths);
    let undecidable = Zoom::Undecidable { variation };
    if variation.is_nan() || variation < LEAST_VARIATION {
        return undecidable;
    }
    focal_change(samples, lens).map_or(undecidable, |[change, sigma]| {
        if change.abs() > NEGLIGIBLE.max(SURE * sigma) {
            Zoom::Changed { change, sigma }
        } else {
            Zoom::Unchanged { sigma }
        }
    })
}

/// Change of the focal length and its deviation, as shares, with everything else of the lens as it is.
fn focal_change(samples: &[Sample], lens: &Lens) -> Option<[f64; 2]> {
    // Without distortion, whatever its model, and with one focal length.
    let focal_px = (lens.focal_px.x * lens.focal_px.y).sqrt();
    let planes = samples.iter().map(|sample| lens.plane(sample.pixel));
    let planes: Vec<_> = planes.map(|plane| plane.map(|plane| plane * focal_px)).collect();
    let known = || planes.iter().flatten();
    let extreme = |axis: usize, of: fn(f64, f64) -> f64, start: f64| known().map(|at| at[axis]).fold(start, of);
    let least = [0, 1].map(|axis| extreme(axis, f64::min, f64::INFINITY).floor());
    let size_px = [0, 1].map(|axis| (extreme(axis, f64::max, f64::NEG_INFINITY) - least[axis]).ceil() as u32 + 1);
    let center_px = least.map(|least| -least);
    let ideal = samples.iter().zip(&planes).filter_map(|(sample, plane)| {
        let pixel = (*plane)? - nalgebra::Vector2::from(least);
        Some(Sample { pixel, ..*sample })
    });
    let ideal: Vec<Sample> = ideal.collect();
    let scaled = |by: f64| Lens::pinhole(size_px, [by * focal_px; 2], center_px);
    let solve_from = |start: f64| {
        let options = SolveOptions {
            focal: FocalLengths::One,
            distortion: DistortionTerms::None,
            fixed: vec![(Parameter::Cx, center_px[0]), (Parameter::Cy, center_px[1])],
            initial: Some(scaled(start)),
            ..SolveOptions::new(size_px)
        };
        solve(&ideal, &options).ok()
    };
    let agrees = |solution: &Solution| solution.inliers as f64 > AGREEING * ideal.len() as f64;
    let searched = || {
        let errors = STARTS.into_par_iter().map(|half_percent| 0.005 * f64::from(half_percent)).map(|by| {
            let error = pose_error(&ideal, &scaled(by)).unwrap_or(f64::INFINITY);
            (by, error)
        });
        let (best, _) = errors.min_by(|(_, one), (_, other)| one.total_cmp(other))?;
        solve_from(best)
    };
    let solution = solve_from(1.0).filter(agrees).or_else(searched)?;
    let focal = solution.estimates.iter().find(|estimate| estimate.parameter == Parameter::Fx)?;
    Some([focal.value / focal_px - 1.0, focal.sigma / focal_px])
}
