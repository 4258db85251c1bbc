//! Error model of the samples, and their weights.
//!
//! A decoded pixel errs in any direction; a depth errs along the camera's ray, the epipolar line in the projector's
//! image. Only the pixel's error shows across that line, both show along it. So the residuals separate the two, and
//! their scales are estimated by medians, which are robust to gross errors (Huber, "Robust Statistics", 1981, ch. 5).
//! Each sample is weighted by the inverse of its 2×2 covariance.

use nalgebra::Vector2;
use rayon::prelude::*;

use super::input::{Observation, Observations};
use super::model::SolverState;
use crate::statistics::{bisect, median};

/// Outlier limit, deviations (1 in 3000 of a two-dimensional normal distribution).
pub(super) const LIMIT: f64 = 4.0;
/// Scale of Cauchy's loss, deviations.
pub(super) const CAUCHY: f64 = 3.0;
/// Maximum number of residuals for the scales.
const MEASURED: usize = 6000;
/// Lower bound of the pixel scale.
const LEAST_SCALE: f64 = 0.003;
/// Below this number, samples are points that a crosshair was steered onto, not pixels of a camera.
const FEW: usize = 24;
/// Median of the square of a standard normal variable.
const MEDIAN_OF_SQUARE: f64 = 0.454_936;

/// Scales of the samples' deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Noise {
    /// Scale of pixel deviations.
    pub(super) pixel: f64,
    /// Scale of depth deviations.
    pub(super) depth: f64,
}

#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Weight {
    /// Unit vector along the epipolar line.
    pub(super) direction: Vector2<f64>,
    /// Inverse deviation along the line, 1/pixels; 0 for an unused sample.
    pub(super) along: f64,
    /// Inverse deviation across the line, 1/pixels.
    pub(super) across: f64,
    /// Depth deviation, metres.
    pub(super) depth_m: f64,
}

impl Weight {
    /// Weight by the deviations of pixel and depth; `by_depth` is the pixel's derivative by depth.
    pub(super) fn new(by_depth: Vector2<f64>, sigma_px: f64, depth_m: f64) -> Self {
        let slope = by_depth.norm();
        let direction = if slope > 1e-9 { by_depth / slope } else { Vector2::x() };
        let along = (sigma_px * sigma_px + (depth_m * slope).powi(2)).sqrt();
        Self { direction, along: 1.0 / along, across: 1.0 / sigma_px, depth_m }
    }

    pub(super) fn is_used(&self) -> bool {
        self.along > 0.0
    }

    /// Residual in deviations, along and across the epipolar line.
    pub(super) fn whitened(&self, error: Vector2<f64>) -> Vector2<f64> {
        let d = self.direction;
        Vector2::new((d.x * error.x + d.y * error.y) * self.along, (d.x * error.y - d.y * error.x) * self.across)
    }
}

/// Weight factor of Cauchy's loss for a squared residual.
pub(crate) fn cauchy_weight(squared: f64) -> f64 {
    1.0 / (1.0 + squared / (CAUCHY * CAUCHY))
}

pub(crate) fn cauchy_loss(squared: f64) -> f64 {
    CAUCHY * CAUCHY * (1.0 + squared / (CAUCHY * CAUCHY)).ln()
}

impl Noise {
    /// Initial noise by the agreement `near` of a first solution. A solution through three of a few samples says
    /// nothing about their errors, so the given deviations are a lower bound then.
    pub(super) fn first(near: f64, samples: usize) -> Self {
        Self { pixel: near.max(if samples < FEW { 1.0 } else { LEAST_SCALE }), depth: 0.0 }
    }

    /// Weights of samples; residuals beyond `limit` deviations are unused.
    pub(super) fn weights(&self, observations: &Observations, state: &SolverState, limit: f64) -> Vec<Weight> {
        observations
            .all
            .par_iter()
            .map(|observation| {
                let Some((error, by_ray)) = error_and_slope(observation, state) else { return Weight::default() };
                let (sigma_px, depth_m) = (self.pixel * observation.sigma_px, self.depth * observation.sigma_m);
                let weight = Weight::new(by_ray, sigma_px, depth_m);
                if weight.whitened(error).norm() <= limit {
                    weight
                } else {
                    Weight::default()
                }
            })
            .collect()
    }

    /// Estimates the scales from the residuals of used samples, to which `unknowns` were adjusted.
    pub(super) fn measured(
        observations: &Observations,
        state: &SolverState,
        weights: &[Weight],
        unknowns: usize,
    ) -> Self {
        let step = (observations.all.len() / MEASURED).max(1);
        let residuals: Vec<_> = (observations.all.iter().zip(weights).step_by(step))
            .filter(|(_, weight)| weight.is_used())
            .filter_map(|(observation, _)| {
                let (error, by_ray) = error_and_slope(observation, state)?;
                let slope = by_ray.norm();
                let direction = if slope > 1e-9 { by_ray / slope } else { Vector2::x() };
                let along = direction.dot(&error);
                let across = direction.perp(&error);
                Some((along, across, observation.sigma_px, observation.sigma_m * slope))
            })
            .collect();
        let mut squares: Vec<f64> = residuals.iter().map(|(_, across, sigma, _)| (across / sigma).powi(2)).collect();
        let pixel = (median(&mut squares) / MEDIAN_OF_SQUARE).sqrt().max(LEAST_SCALE);
        let mut excess = |depth: f64| {
            squares.clear();
            squares.extend(residuals.iter().map(|(along, _, sigma_px, sigma_by_depth_px)| {
                along * along / ((pixel * sigma_px).powi(2) + (depth * sigma_by_depth_px).powi(2))
            }));
            median(&mut squares) - MEDIAN_OF_SQUARE
        };
        let (mut low, mut high) = (0.0, 1e-3);
        if excess(0.0) > 0.0 {
            while high < 1e4 && excess(high) > 0.0 {
                (low, high) = (high, 4.0 * high);
            }
            [_, high] = bisect([low, high], 12, |depth| excess(depth) > 0.0);
        } else {
            high = 0.0;
        }
        // Small-sample correction (Rousseeuw and Leroy, "Robust regression and outlier detection", 1987, p. 202).
        let count = weights.iter().filter(|weight| weight.is_used()).count() as f64;
        let (left, unknowns) = ((count - 0.5 * unknowns as f64).max(1.0), unknowns as f64);
        let missing = (1.0 + 5.0 / left) * (2.0 * count / (2.0 * count - unknowns).max(1.0)).sqrt();
        // Without a baseline, nothing limits the depth's scale.
        Self { pixel: pixel * missing, depth: if high < 1e4 { high * missing } else { 0.0 } }
    }
}

/// Residual of a sample, and its pixel's derivative by depth.
pub(super) fn error_and_slope(observation: &Observation, state: &SolverState) -> Option<(Vector2<f64>, Vector2<f64>)> {
    let pose = &state.poses[observation.scan];
    let projected = state.lens.project_with_jacobian(&(pose * observation.point))?;
    Some((observation.pixel - projected.pixel, projected.by_point * (pose.rotation * observation.ray)))
}
