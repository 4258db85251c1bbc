//! Equations of a sample with an error of its depth.
//!
//! The point is moved along the camera's ray to where it and its pixel fit best: the cost of a sample is the minimum sum
//! of both squared errors in their deviations, with the slopes at that place (orthogonal distance regression; Fuller,
//! "Measurement error models", 1987, 3.2). With slopes at the observed point, errors of points and slopes would be
//! correlated, and a lens from weak relief would be off by more than its deviation.

use nalgebra::{SVector, Vector2};

use super::input::Observation;
use super::model::{SolverState, LOCAL};
use super::noise::Weight;

/// Maximum displacement of a point, deviations of its depth.
const MOST_MOVED: f64 = 3.0;

/// Equations of a sample, slopes · unknowns = residual, in deviations: along and across the epipolar line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Equations {
    pub(super) residual: Vector2<f64>,
    pub(super) slopes: [SVector<f64, LOCAL>; 2],
}

/// Equations of a sample at a state; `None` where the lens cannot project its point.
pub(super) fn equations(state: &SolverState, observation: &Observation, weight: &Weight) -> Option<Equations> {
    let pose = &state.poses[observation.scan];
    let sigma_px = 1.0 / weight.across;
    let turned_ray = pose.rotation * observation.ray;
    let mut moved_m = 0.0;
    if weight.depth_m > 0.0 {
        let seen = state.lens.project_with_jacobian(&(pose * observation.point))?;
        let by_depth = seen.by_point * turned_ray;
        let stiffness = by_depth.norm_squared() + (sigma_px / weight.depth_m).powi(2);
        let most_m = MOST_MOVED * weight.depth_m;
        moved_m = (by_depth.dot(&(observation.pixel - seen.pixel)) / stiffness).clamp(-most_m, most_m);
    }
    let prediction = state.predict(observation.scan, &(observation.point + observation.ray * moved_m))?;
    let by_depth = prediction.by_point * turned_ray;
    // The error of the observed point, linearised at the moved one.
    let error = observation.pixel - prediction.pixel + by_depth * moved_m;
    let whitening = Weight::new(by_depth, sigma_px, weight.depth_m);
    let d = whitening.direction;
    let (mut along, mut across) = (SVector::zeros(), SVector::zeros());
    for column in 0..LOCAL {
        let (u, v) = (prediction.jacobian[(0, column)], prediction.jacobian[(1, column)]);
        along[column] = (d.x * u + d.y * v) * whitening.along;
        across[column] = (d.x * v - d.y * u) * whitening.across;
    }
    Some(Equations { residual: whitening.whitened(error), slopes: [along, across] })
}
