//! Focal length of an otherwise known lens, solved for together with its pose.
//!
//! Before a single plane, only an affine distortion tells a zoom from a motion: of about the zoom's change times the
//! squared slope of the plane, seen from the projector. A smooth depth error looks alike. So the estimate is a
//! generalised least squares (Aitken 1935), whose covariance of the samples has the smooth errors of depth cameras,
//! which residuals of so few samples do not show. Then the deviation tells whether a scene determines the zoom.

use nalgebra::{DMatrix, DVector, Point2, SVector, Vector2};
use rayon::prelude::*;

use super::adjust::{self, Adjusted};
use super::consensus::{self, Score};
use super::input::Observations;
use super::levenberg_marquardt::inverse_of_positive;
use super::model::Free;
use super::noise::{cauchy_weight, error_and_slope, Noise};
use super::normal_equations::equations;
use crate::{Lens, Sample};

/// Tried zooms, in steps of this share of the lens's focal length.
const STARTS: std::ops::RangeInclusive<i32> = -9..=11;
const START_STEP: f64 = 0.025;
/// Rounds of the robust adjustment.
const ROUNDS: usize = 4;
/// Distance in the camera's plane z = 1 over which depth errors are alike: the standard deviation of a Gaussian.
const SMOOTH_RANGE: f64 = 0.25;
/// Number of unknowns: the focal length and a pose.
const UNKNOWNS: usize = 7;

/// Focal length compared with that of a lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ZoomEstimate {
    /// Change of the focal length, as a share of it.
    pub(crate) change: f64,
    /// Standard deviation of the change; infinite if the samples do not determine it.
    pub(crate) sigma: f64,
    /// Share of the samples that agree.
    pub(crate) agreeing: f64,
}

/// Estimates the change of a lens's focal length from samples of one pose. `None` if they fit no pose.
pub(crate) fn zoom(samples: &[Sample], lens: &Lens) -> Option<ZoomEstimate> {
    let mut observations = Observations::new(samples, lens.size_px).ok()?;
    // With square pixels, a zoom changes both focal lengths by the same.
    let aspect = lens.focal_px.x / lens.focal_px.y;
    observations.all.iter_mut().for_each(|observation| observation.pixel.y *= aspect);
    let focal_px = lens.focal_px.x;
    let center_px = Point2::new(lens.center_px.x, lens.center_px.y * aspect);
    let free = Free::zoom();
    let from_zoom = |step: i32| {
        let focal_px = Vector2::repeat(focal_px * (1.0 + START_STEP * f64::from(step)));
        let first = consensus::pose(&observations, &Lens { focal_px, center_px, ..*lens }, 0)?;
        let noise = Noise::first(first.score.near, observations.all.len());
        let adjusted = adjust::robustly(&observations, &first.state, &free, noise, ROUNDS);
        let score = Score::new(&observations.all, &adjusted.state, &mut Vec::new());
        Some((adjusted, score.mean))
    };
    let found: Vec<_> = STARTS.into_par_iter().filter_map(from_zoom).collect();
    let (adjusted, _) = found.into_iter().min_by(|one, other| one.1.total_cmp(&other.1))?;
    let used = adjusted.weights.iter().filter(|weight| weight.is_used()).count();
    let (step_px, sigma_px) = generalised(&observations, &adjusted, &free).unwrap_or((0.0, f64::INFINITY));
    Some(ZoomEstimate {
        change: (adjusted.state.lens.focal_px.x + step_px) / focal_px - 1.0,
        sigma: sigma_px / focal_px,
        agreeing: used as f64 / samples.len() as f64,
    })
}

/// Equation of a sample along or across its epipolar line, in deviations.
struct Equation {
    slopes: SVector<f64, UNKNOWNS>,
    residual: f64,
    /// Variance of the sample's own error.
    variance: f64,
    /// Deviation by the smooth error of the depth camera, and the place in the camera's plane z = 1.
    smooth: f64,
    place: Vector2<f64>,
}

impl Equation {
    /// Covariance with another equation by the smooth error.
    fn shared(&self, other: &Self) -> f64 {
        let apart = (self.place - other.place) / SMOOTH_RANGE;
        self.smooth * other.smooth * (-0.5 * apart.norm_squared()).exp()
    }
}

/// Equations of the used samples.
fn all_equations(observations: &Observations, adjusted: &Adjusted, free: &Free) -> Vec<Equation> {
    let (state, columns) = (&adjusted.state, free.columns(0));
    let used = observations.all.iter().zip(&adjusted.weights).filter(|(_, weight)| weight.is_used());
    let of_sample = used.filter_map(|(observation, weight)| {
        let linear = equations(state, observation, weight)?;
        let (_, by_depth) = error_and_slope(observation, state)?;
        let smooth = by_depth.norm() * observation.sigma_m * weight.along;
        let variance = 1.0 / cauchy_weight(linear.residual.norm_squared());
        Some([(0, smooth), (1, 0.0)].map(|(direction, smooth)| {
            let mut slopes = SVector::zeros();
            for (parameter, unknown) in &columns {
                slopes[*unknown] += linear.slopes[direction][*parameter];
            }
            let residual = linear.residual[direction];
            Equation { slopes, residual, variance, smooth, place: observation.ray.xy() }
        }))
    });
    of_sample.flatten().collect()
}

/// Step of the focal length from an adjusted state, and its deviation, pixels; `None` if it is undetermined.
fn generalised(observations: &Observations, adjusted: &Adjusted, free: &Free) -> Option<(f64, f64)> {
    let equations = all_equations(observations, adjusted, free);
    let count = equations.len();
    let covariance = DMatrix::from_fn(count, count, |row, column| {
        let own = if row == column { equations[row].variance } else { 0.0 };
        own + equations[row].shared(&equations[column])
    });
    let slopes = DMatrix::from_fn(count, UNKNOWNS, |row, unknown| equations[row].slopes[unknown]);
    let residuals = DVector::from_fn(count, |row, _| equations[row].residual);
    let weighted = covariance.cholesky()?.solve(&slopes);
    let inverse = inverse_of_positive(&(slopes.tr_mul(&weighted)))?;
    let step = &inverse * weighted.tr_mul(&residuals);
    let variance = inverse[(0, 0)];
    (variance.is_finite() && variance >= 0.0).then(|| (step[0], variance.sqrt()))
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Point3, Vector3};

    use super::*;
    use crate::solve::random::SplitMix64;
    use crate::{Distortion, DistortionModel};

    /// Samples of a wall with a slope, by a lens with distortion and pixels that are not square.
    fn wall(slope: f64) -> (Vec<Sample>, Lens) {
        let distortion = [0.4, -0.05, 1e-3, -5e-4, 0.01, 0.5, -0.02, 0.01];
        let distortion = Distortion::new(DistortionModel::RationalPolynomial, &distortion).unwrap();
        let lens = Lens { distortion, ..Lens::pinhole([1280, 800], [1500.0, 1380.0], [640.0, 420.0]) };
        let pose = Isometry3::new(Vector3::new(0.2, -0.05, 0.03), Vector3::new(0.02, -0.12, 0.01));
        let mut random = SplitMix64::new(5, 5);
        let mut noise = |size: f64| size * (random.unit() - 0.5);
        let sample = |i: usize| {
            let (x, y) = (0.07 * (i % 8) as f64 - 0.245, 0.06 * (i / 8) as f64 - 0.21);
            let depth = 1.3 / (1.0 - slope * x);
            let pixel = lens.project(&(pose * Point3::new(x * depth, y * depth, depth))).unwrap();
            let depth = depth + noise(1e-3);
            Sample::new(pixel + Vector2::new(noise(0.2), noise(0.2)), Point3::new(x * depth, y * depth, depth))
        };
        ((0..64).map(sample).collect(), lens)
    }

    #[test]
    fn a_slanted_wall_tells_a_zoom_and_a_facing_one_does_not() {
        for by in [0.85, 0.97, 1.0, 1.02, 1.2] {
            let estimate = |slope: f64| {
                let (samples, lens) = wall(slope);
                zoom(&samples, &Lens { focal_px: lens.focal_px * by, ..lens }).unwrap()
            };
            let slanted = estimate(0.8);
            let error = slanted.change - (1.0 / by - 1.0);
            assert!(slanted.sigma < 0.003 && error.abs() < 4.0 * slanted.sigma, "{by}: {error} {slanted:?}");
            let facing = estimate(-0.12);
            assert!(facing.sigma > 0.005, "{by}: {facing:?}");
        }
    }
}
