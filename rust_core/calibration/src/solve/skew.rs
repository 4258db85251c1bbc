//! Skew estimate: one Gauss-Newton step with the skew as an additional unknown.
//!
//! No lens has a skew, but a keystone correction is a homography of the image, after which a pinhole's matrix K has a
//! skew and two focal lengths (Hartley, Zisserman, "Multiple View Geometry in Computer Vision", 2nd edition, 2004,
//! 6.2.4).

use super::adjust::Adjusted;
use super::covariance::{Correlations, Errors};
use super::input::Observations;
use super::levenberg_marquardt::solve_positive;
use super::model::Free;
use super::normal_equations::NormalEquations;
use super::Skew;

/// Skew that hardly changes the residuals, as a share of the focal length.
const SMALL: f64 = 0.002;

/// Estimates the skew; `None` if the lens is not solved for or the samples do not determine a skew.
pub(super) fn skew(
    observations: &Observations,
    adjusted: &Adjusted,
    free: &Free,
    errors: &Errors,
    correlations: &Correlations,
) -> Option<Skew> {
    if free.lens.is_empty() {
        return None;
    }
    let free = free.with_skew();
    let column = free.lens.len() - 1;
    let equations = NormalEquations::new(observations, &adjusted.weights, &adjusted.state, &free);
    let step = solve_positive(&equations.hessian, &equations.descent)?;
    let covariance = if step[column].abs() < SMALL * adjusted.state.lens.focal_px.min() {
        errors.covariance(&equations, &free, correlations)
    } else {
        // The residuals without the skew's effect.
        let errors = Errors::after(observations, adjusted, &free, &step);
        errors.covariance(&equations, &free, &errors.correlations(&equations, &free)?)
    };
    let skew = Skew { value_px: step[column], sigma_px: covariance?[(column, column)].sqrt() };
    (skew.value_px.is_finite() && skew.sigma_px.is_finite()).then_some(skew)
}
