//! How far samples miss by chance, and how much each therefore counts.
//!
//! A decoded pixel errs in any direction; the depth of a point errs along the camera's ray, which is a line in the
//! projector's picture (the epipolar line). Across that line only the pixel's error shows, along it both. So the
//! residuals tell the two apart, and their scales are measured from them: medians, which gross errors do not move
//! (Huber, "Robust Statistics", 1981, ch. 5). Each sample is then weighted by the inverse of its 2×2 covariance.

use nalgebra::Vector2;
use rayon::prelude::*;

use super::input::Observations;
use super::model::State;

/// Samples that miss by more deviations are outliers (1 in 3000 of a two-dimensional normal distribution).
pub(super) const LIMIT: f64 = 4.0;
/// The constant of Cauchy's loss, deviations: residuals beyond it count less and less.
pub(super) const CAUCHY: f64 = 3.0;
/// Residuals that the scales are measured from, at most.
const MEASURED: usize = 6000;
/// Scales of pixel errors are not believed to be smaller.
const LEAST_SCALE: f64 = 0.003;
/// Fewer samples are few: things that a crosshair was steered onto, not pixels of a camera.
const FEW: usize = 24;
/// The median of the square of a standard normal variable.
const MEDIAN_OF_SQUARE: f64 = 0.454_936;

/// The scales of the samples' deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Noise {
    /// Of the pixels'.
    pub(super) pixel: f64,
    /// Of the depths'.
    pub(super) depth: f64,
}

/// How a sample counts.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Weight {
    /// The direction in the projector's picture in which the point moves with its depth; a unit vector.
    pub(super) direction: Vector2<f64>,
    /// The inverse of the deviation along that direction, 1/pixels; 0 for a sample that does not take part.
    pub(super) along: f64,
    /// The same across.
    pub(super) across: f64,
    /// The deviation of the point's depth, metres.
    pub(super) depth_m: f64,
}

impl Weight {
    /// That of a pixel and a depth with these deviations; `by_depth` is how the pixel moves with the depth.
    pub(super) fn new(by_depth: Vector2<f64>, sigma_px: f64, depth_m: f64) -> Self {
        let slope = by_depth.norm();
        let direction = if slope > 1e-9 { by_depth / slope } else { Vector2::x() };
        let along = (sigma_px * sigma_px + (depth_m * slope).powi(2)).sqrt();
        Self { direction, along: 1.0 / along, across: 1.0 / sigma_px, depth_m }
    }

    /// That of a pixel with this deviation and an exact depth.
    pub(super) fn of_pixels(sigma_px: f64) -> Self {
        Self::new(Vector2::x(), sigma_px, 0.0)
    }

    /// Whether the sample takes part.
    pub(super) fn is_used(&self) -> bool {
        self.along > 0.0
    }

    /// A residual in deviations, along and across.
    pub(super) fn whitened(&self, miss: Vector2<f64>) -> Vector2<f64> {
        let d = self.direction;
        Vector2::new((d.x * miss.x + d.y * miss.y) * self.along, (d.x * miss.y - d.y * miss.x) * self.across)
    }
}

/// The factor by which Cauchy's loss reduces the weight of a residual of this squared size.
pub(super) fn cauchy_weight(squared: f64) -> f64 {
    1.0 / (1.0 + squared / (CAUCHY * CAUCHY))
}

/// Cauchy's loss.
pub(super) fn cauchy_loss(squared: f64) -> f64 {
    CAUCHY * CAUCHY * (1.0 + squared / (CAUCHY * CAUCHY)).ln()
}

impl Noise {
    /// Errors of pixels only.
    pub(super) fn of_pixels(scale: f64) -> Self {
        Self { pixel: scale.max(LEAST_SCALE), depth: 0.0 }
    }

    /// The errors of pixels by the distance within which some of so many samples lie from a first solution. A solution
    /// through three of a few samples says nothing of their errors: then the given deviations are believed at least.
    pub(super) fn first(near: f64, samples: usize) -> Self {
        Self::of_pixels(if samples < FEW { near.max(1.0) } else { near })
    }

    /// The weights of samples; those that miss by more than `limit` deviations do not take part.
    pub(super) fn weights(&self, observations: &Observations, state: &State, limit: f64) -> Vec<Weight> {
        observations
            .all
            .par_iter()
            .map(|observation| {
                let Some((miss, by_ray)) = miss_and_slope(observation, state) else { return Weight::default() };
                let (sigma_px, depth_m) = (self.pixel * observation.sigma_px, self.depth * observation.sigma_m);
                let weight = Weight::new(by_ray, sigma_px, depth_m);
                if weight.whitened(miss).norm() <= limit {
                    weight
                } else {
                    Weight::default()
                }
            })
            .collect()
    }

    /// The scales that the residuals of the samples that take part show, after so many unknowns were adjusted to them.
    pub(super) fn measured(observations: &Observations, state: &State, weights: &[Weight], unknowns: usize) -> Self {
        let step = (observations.all.len() / MEASURED).max(1);
        let residuals: Vec<_> = (observations.all.iter().zip(weights).step_by(step))
            .filter(|(_, weight)| weight.is_used())
            .filter_map(|(observation, _)| {
                let (miss, by_ray) = miss_and_slope(observation, state)?;
                let slope = by_ray.norm();
                let direction = if slope > 1e-9 { by_ray / slope } else { Vector2::x() };
                let along = direction.dot(&miss);
                let across = direction.perp(&miss);
                Some((along, across, observation.sigma_px, observation.sigma_m * slope))
            })
            .collect();
        let mut squares: Vec<f64> = residuals.iter().map(|(_, across, sigma, _)| (across / sigma).powi(2)).collect();
        let pixel = (quantile(&mut squares, 0.5) / MEDIAN_OF_SQUARE).sqrt().max(LEAST_SCALE);
        let mut excess = |depth: f64| {
            squares.clear();
            squares.extend(residuals.iter().map(|(along, _, sigma_px, sigma_by_depth_px)| {
                along * along / ((pixel * sigma_px).powi(2) + (depth * sigma_by_depth_px).powi(2))
            }));
            quantile(&mut squares, 0.5) - MEDIAN_OF_SQUARE
        };
        let (mut low, mut high) = (0.0, 1e-3);
        if excess(0.0) > 0.0 {
            while high < 1e4 && excess(high) > 0.0 {
                (low, high) = (high, 4.0 * high);
            }
            for _ in 0..12 {
                let middle = 0.5 * (low + high);
                if excess(middle) > 0.0 {
                    low = middle;
                } else {
                    high = middle;
                }
            }
        } else {
            high = 0.0;
        }
        // Of few samples the unknowns take up much (the correction of Rousseeuw and Leroy, "Robust regression and
        // outlier detection", 1987, p. 202).
        let count = weights.iter().filter(|weight| weight.is_used()).count() as f64;
        let (left, unknowns) = ((count - 0.5 * unknowns as f64).max(1.0), unknowns as f64);
        let missing = (1.0 + 5.0 / left) * (2.0 * count / (2.0 * count - unknowns).max(1.0)).sqrt();
        // Without a slope of the epipolar line nothing limits the depth's scale.
        Self { pixel: pixel * missing, depth: if high < 1e4 { high * missing } else { 0.0 } }
    }
}

fn miss_and_slope(observation: &super::input::Observation, state: &State) -> Option<(Vector2<f64>, Vector2<f64>)> {
    let pose = &state.poses[observation.scan];
    let landing = state.lens.project_with_jacobian(&(pose * observation.point))?;
    Some((observation.pixel - landing.pixel, landing.by_point * (pose.rotation * observation.ray)))
}

/// The value below which a share of the values lies; NaN without values. Changes their order.
pub(super) fn quantile(values: &mut [f64], share: f64) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let index = ((values.len() as f64 * share) as usize).min(values.len() - 1);
    *values.select_nth_unstable_by(index, f64::total_cmp).1
}
