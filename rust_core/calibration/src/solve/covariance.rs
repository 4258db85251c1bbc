//! Covariance of lens and poses, with errors that neighbouring samples share.
//!
//! A sandwich estimate (Huber 1967; White 1980): H⁻¹ M H⁻¹, where H is the curvature of the loss and M the covariance
//! of its slope. Depth cameras err smoothly, so M has terms between samples, as for spatially correlated errors
//! (Conley, "GMM estimation with cross sectional dependence", 1999). Samples are binned into square cells of the
//! camera's image (`cells`), whose residuals give the `correlation`, separately along the epipolar lines, where depth
//! errors show, and across. Errors of few points count as independent.

use nalgebra::{DMatrix, DVector, Point2, SVector};
use rayon::prelude::*;

use super::adjust::Adjusted;
use super::cells::{over_scans, sums_of, ScanSums};
use super::correlation::{correlation, shared_slopes, Correlation, CorrelationTable};
use super::input::Observations;
use super::levenberg_marquardt::inverse_of_positive;
use super::model::{Free, SolverState};
use super::normal_equations::NormalEquations;

/// Covariance functions along the epipolar lines and across.
pub(super) struct Correlations([Correlation; 2]);

/// Residual sums of all scans at a solution.
pub(super) struct Errors(Vec<ScanSums>);

impl Errors {
    /// Sums over the used samples.
    pub(super) fn new(observations: &Observations, adjusted: &Adjusted) -> Self {
        let none = SVector::zeros();
        let scans = 0..observations.scans.len();
        Self(scans.into_par_iter().map(|scan| sums_of(observations, adjusted, scan, &none)).collect())
    }

    /// Sums after a step of the unknowns, to first order.
    pub(super) fn after(observations: &Observations, adjusted: &Adjusted, free: &Free, step: &DVector<f64>) -> Self {
        let of_scan = |scan: usize| {
            let mut local = SVector::zeros();
            for (parameter, unknown) in free.columns(scan) {
                local[parameter] = step[unknown];
            }
            sums_of(observations, adjusted, scan, &local)
        };
        Self((0..observations.scans.len()).into_par_iter().map(of_scan).collect())
    }

    /// Estimates the covariance functions; `None` if the samples do not determine the unknowns.
    pub(super) fn correlations(&self, equations: &NormalEquations, free: &Free) -> Option<Correlations> {
        let inverse = self.inverse(equations)?;
        let used: f64 = self.0.iter().flat_map(|sums| &sums.cells).map(|cell| cell.count).sum();
        Some(Correlations([0, 1].map(|direction| correlation(&self.0, direction, used, free, &inverse))))
    }

    fn inverse(&self, equations: &NormalEquations) -> Option<DMatrix<f64>> {
        let (curvature, weight) = self.0.iter().fold((0.0, 0.0), |(c, w), sums| (c + sums.curvature, w + sums.weight));
        inverse_of_positive(&(&equations.hessian * (curvature / weight)))
    }

    /// Covariance of the unknowns of these equations; `None` if the samples do not determine them.
    pub(super) fn covariance(
        &self,
        equations: &NormalEquations,
        free: &Free,
        correlations: &Correlations,
    ) -> Option<DMatrix<f64>> {
        let sums = &self.0;
        let inverse = self.inverse(equations)?;
        let mut slope_covariance = DMatrix::zeros(free.len(), free.len());
        for (direction, correlation) in correlations.0.iter().enumerate() {
            let table = CorrelationTable::new(correlation.range);
            slope_covariance += over_scans(sums, free, |sums| {
                shared_slopes(sums, direction, &table) * correlation.shared
                    + sums.fine_products[direction] * correlation.near
                    + sums.products[direction] * correlation.own
            });
        }
        let covariance = &inverse * slope_covariance * &inverse;
        covariance.iter().all(|value| value.is_finite()).then_some(covariance)
    }
}

/// RMS standard deviation of predicted pixels over the image, between two distances from the projector.
pub(super) fn prediction_sigma_px(
    state: &SolverState,
    free: &Free,
    covariance: &DMatrix<f64>,
    depth_m: [f64; 2],
) -> f64 {
    let [width, height] = state.lens.size_px.map(f64::from);
    let (mut sum, mut count) = (0.0, 0.0);
    for (scan, pose) in state.poses.iter().enumerate().take(4) {
        let covariance = free.block(covariance, scan);
        for place in 0..9 * 7 {
            let pixel =
                Point2::new(width * f64::from(place % 9) / 8.0 - 0.5, height * f64::from(place / 9) / 6.0 - 0.5);
            let Some(ray) = state.lens.ray(pixel) else { continue };
            for depth in [depth_m[0], (depth_m[0] * depth_m[1]).sqrt(), depth_m[1]] {
                let point = pose.inverse_transform_point(&(ray * depth).into());
                let Some(prediction) = state.predict(scan, &point) else { continue };
                sum += (prediction.jacobian * covariance * prediction.jacobian.transpose()).trace();
                count += 1.0;
            }
        }
    }
    if count == 0.0 {
        f64::INFINITY
    } else {
        (sum / count).max(0.0).sqrt()
    }
}
