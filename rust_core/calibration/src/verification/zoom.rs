//! Check that a projector still has the zoom of its file.
//!
//! A zoom scales the image, and so does a motion along the axis, at one depth. They differ in the motion of farther and
//! nearer points. Where depth hardly varies, and on a tilted plane, where a turn does the same, they look alike.

use nalgebra::{Matrix3, Vector2, Vector3};
use rayon::prelude::*;

use crate::solve::pose_error;
use crate::statistics::{median, quantile};
use crate::{solve, DistortionTerms, FocalLengths, Lens, Parameter, Refusal, Sample, SolveOptions};

/// Minimum variation of depth that tells a zoom from a motion, as a share of the depth.
const LEAST_VARIATION: f64 = 0.15;
/// Shares of the points that are nearer and farther than the range that counts as the variation.
const ENDS: [f64; 2] = [0.05, 0.95];
/// Maximum change of the focal length of an unchanged zoom: in deviations, and as a share.
const SURE: f64 = 4.0;
const NEGLIGIBLE: f64 = 0.01;
/// Maximum deviation of the focal length of an unchanged zoom, as a share.
const MOST_SIGMA: f64 = 0.005;
/// Minimum share of samples that agree with the lens's own zoom: with a wrong one, only those at one depth do.
const AGREEING: f64 = 0.85;
/// Zooms to search if fewer agree, each half a percent of the lens's focal length.
const STARTS: std::ops::Range<i32> = 156..256;

/// Projector's zoom compared with that of its file.
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
    /// The scene is too flat to tell, or there are too few samples.
    Undecidable {
        /// Variation of depth as a share of it, or that about the plane that fits best, if it is less.
        variation: f64,
    },
}

/// Compares the zoom with that of a lens. `None` if the samples fit no zoom of it.
pub(super) fn check(samples: &[Sample], lens: &Lens) -> Option<Zoom> {
    let mut depths: Vec<f64> = samples.iter().map(|sample| sample.point.z).collect();
    let [near, far] = ENDS.map(|share| quantile(&mut depths, share));
    let variation = (far - near) / median(&mut depths);
    let undecidable = Zoom::Undecidable { variation: variation.min(variation_off_plane(samples)) };
    if variation.is_nan() || variation < LEAST_VARIATION {
        return Some(undecidable);
    }
    let [change, sigma] = match focal_change(samples, lens) {
        Ok(found) => found?,
        // Too few samples, or a tilted plane: a turn looks like a zoom there.
        Err(Refusal::TooFew { .. } | Refusal::BadlySpread(_) | Refusal::Undetermined { .. } | Refusal::Flat) => {
            return Some(undecidable);
        }
        Err(_) => return None,
    };
    Some(if change.abs() > NEGLIGIBLE.max(SURE * sigma) {
        Zoom::Changed { change, sigma }
    } else if sigma > MOST_SIGMA {
        undecidable
    } else {
        Zoom::Unchanged { sigma }
    })
}

/// Variation of depth about the plane that fits best, as a share of the depth. On a plane, inverse depth is linear in
/// the image.
fn variation_off_plane(samples: &[Sample]) -> f64 {
    let rows: Vec<(Vector3<f64>, f64)> =
        samples.iter().map(|sample| (sample.point.coords / sample.point.z, 1.0 / sample.point.z)).collect();
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for (row, inverse) in &rows {
        normal += row * row.transpose();
        right += row * *inverse;
    }
    // Fewer than three samples have a plane.
    let Some(plane) = normal.try_inverse().map(|inverse| inverse * right) else { return 0.0 };
    let mut shares: Vec<f64> = rows.iter().map(|(row, inverse)| row.dot(&plane) / inverse - 1.0).collect();
    let [near, far] = ENDS.map(|share| quantile(&mut shares, share));
    far - near
}

/// Change of the focal length and its deviation, as shares, with everything else of the lens as it is.
fn focal_change(samples: &[Sample], lens: &Lens) -> Result<Option<[f64; 2]>, Refusal> {
    let of_lens = from_zoom(samples, lens, 1.0);
    if of_lens.as_ref().is_ok_and(|(_, agreeing)| *agreeing > AGREEING) {
        return of_lens.map(|(change, _)| change);
    }
    let errors = STARTS.into_par_iter().map(|half_percent| 0.005 * f64::from(half_percent)).map(|zoom| {
        let error = pose_error(samples, &zoomed(lens, zoom)).unwrap_or(f64::INFINITY);
        (zoom, error)
    });
    let best = errors.min_by(|(_, one), (_, other)| one.total_cmp(other));
    best.map_or(Ok(None), |(zoom, _)| from_zoom(samples, lens, zoom).map(|(change, _)| change))
}

/// Solves for the focal length from a zoom: its change as in [`focal_change`], and the share of samples that agree.
fn from_zoom(samples: &[Sample], lens: &Lens, zoom: f64) -> Result<(Option<[f64; 2]>, f64), Refusal> {
    // Without distortion, whatever its model, and with one focal length.
    let start = zoomed(lens, zoom);
    let focal_px = (start.focal_px.x * start.focal_px.y).sqrt();
    let planes: Vec<_> = samples.iter().map(|sample| start.plane(sample.pixel).map(|plane| plane * focal_px)).collect();
    let extreme =
        |axis: usize, of: fn(f64, f64) -> f64, first: f64| planes.iter().flatten().map(|at| at[axis]).fold(first, of);
    let least = [0, 1].map(|axis| extreme(axis, f64::min, f64::INFINITY).floor());
    let size_px = [0, 1].map(|axis| (extreme(axis, f64::max, f64::NEG_INFINITY) - least[axis]).ceil() as u32 + 1);
    let center_px = least.map(|least| -least);
    let ideal = samples.iter().zip(&planes).filter_map(|(sample, plane)| {
        let pixel = (*plane)? - Vector2::from(least);
        Some(Sample { pixel, ..*sample })
    });
    let ideal: Vec<Sample> = ideal.collect();
    let options = SolveOptions {
        focal: FocalLengths::One,
        distortion: DistortionTerms::None,
        fixed: vec![(Parameter::Cx, center_px[0]), (Parameter::Cy, center_px[1])],
        initial: Some(Lens::pinhole(size_px, [focal_px; 2], center_px)),
        ..SolveOptions::new(size_px)
    };
    let solution = solve(&ideal, &options)?;
    let focal = solution.estimates.iter().find(|estimate| estimate.parameter == Parameter::Fx);
    let change = focal.map(|focal| [zoom * focal.value / focal_px - 1.0, zoom * focal.sigma / focal_px]);
    Ok((change, solution.inliers as f64 / ideal.len() as f64))
}

/// The lens with another focal length; distortion scales with the image.
fn zoomed(lens: &Lens, zoom: f64) -> Lens {
    Lens { focal_px: lens.focal_px * zoom, ..*lens }
}
