//! How skewed the picture seems to be: a skew as one more unknown, estimated by a step of Gauss and Newton from the
//! solution without it.
//!
//! No projector's lens has a skew, but a picture that its electronics distort does: a keystone correction is a
//! homography of the picture, which leaves a pinhole a pinhole, whose matrix K then has a skew and two focal lengths
//! (Hartley, Zisserman, "Multiple View Geometry in Computer Vision", 2nd edition, 2004, 6.2.4).

use super::adjust::{solve_positive, Adjusted};
use super::covariance::{Correlations, Errors};
use super::input::Observations;
use super::model::Free;
use super::normal_equations::NormalEquations;
use super::Skew;

/// A skew that leaves the errors nearly as they are, as a share of the focal length.
const SMALL: f64 = 0.002;

/// The skew that the samples ask for; none if the lens is not solved for or they do not determine a skew.
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
        // What the skew explains is no error.
        let errors = Errors::after(observations, adjusted, &free, &step);
        errors.covariance(&equations, &free, &errors.correlations(&equations, &free)?)
    };
    let skew = Skew { value_px: step[column], sigma_px: covariance?[(column, column)].sqrt() };
    (skew.value_px.is_finite() && skew.sigma_px.is_finite()).then_some(skew)
}
