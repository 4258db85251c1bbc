//! The two equations of a sample, whose point errs, too.
//!
//! A point that is seen too near or too far is put to where, along the camera's ray, it and its pixel fit best: the
//! cost of a sample is the least sum of the squares of both errors in their deviations, and its slopes are those at
//! that place (orthogonal distance regression; Fuller, "Measurement error models", 1987, 3.2). With slopes at the point
//! as it was seen, errors of points and slopes would go together, and a lens from weak relief would be wrong by more
//! than its deviation.

use nalgebra::{SVector, Vector2};

use super::input::Observation;
use super::model::{State, LOCAL};
use super::noise::Weight;

/// How far a point is moved at most, deviations of its depth.
const MOST_MOVED: f64 = 3.0;

/// The equations of a sample: slopes times unknowns is residual, each in deviations. The first is along the epipolar
/// line, the second across.
#[derive(Debug, Clone, Copy)]
pub(super) struct Equations {
    pub(super) residual: Vector2<f64>,
    pub(super) slopes: [SVector<f64, LOCAL>; 2],
}

/// The equations of a sample at a state; none where the lens cannot project its point.
pub(super) fn equations(state: &State, observation: &Observation, weight: &Weight) -> Option<Equations> {
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
    // The miss of the point as it was seen, on the tangent at the place that it was moved to.
    let miss = observation.pixel - prediction.pixel + by_depth * moved_m;
    let whitening = Weight::new(by_depth, sigma_px, weight.depth_m);
    let d = whitening.direction;
    let (mut along, mut across) = (SVector::zeros(), SVector::zeros());
    for column in 0..LOCAL {
        let (u, v) = (prediction.jacobian[(0, column)], prediction.jacobian[(1, column)]);
        along[column] = (d.x * u + d.y * v) * whitening.along;
        across[column] = (d.x * v - d.y * u) * whitening.across;
    }
    Some(Equations { residual: whitening.whitened(miss), slopes: [along, across] })
}
