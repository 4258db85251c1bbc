//! Normal equations of the weighted robust least squares, summed in parallel.
//!
//! A sample depends on the lens and on one pose, so it adds to a small dense block. A task sums a chunk of one scan's
//! samples, and the chunks are added to the large matrix in their order, independent of the number of threads (Triggs
//! et al., "Bundle adjustment: a modern synthesis", 2000, section 6).
//!
//! A sample's depth errs, too. Its point is moved along the camera's ray to where it and its pixel fit best: the cost
//! is the minimum sum of both squared errors in their deviations, with the slopes at that place (orthogonal distance
//! regression; Fuller, "Measurement error models", 1987, 3.2). With slopes at the observed point, errors of points and
//! slopes would be correlated, and a lens from weak relief would be off by more than its deviation.

use std::ops::Range;

use nalgebra::{DMatrix, DVector, SVector, Vector2};
use rayon::prelude::*;

use super::input::{Observation, Observations};
use super::model::{Block, Free, SolverState, LOCAL};
use super::noise::{cauchy_loss, cauchy_weight, Weight};

/// Squared residual, in deviations, of a sample that cannot be projected.
const LOST: f64 = 1e4;

/// Maximum displacement of a point, deviations of its depth.
const MOST_MOVED: f64 = 3.0;

#[derive(Debug, Clone)]
pub(crate) struct NormalEquations {
    /// Gauss-Newton approximation of the second derivatives of half the cost.
    pub(crate) hessian: DMatrix<f64>,
    /// Negative gradient of half the cost.
    pub(crate) descent: DVector<f64>,
    pub(crate) cost: f64,
}

#[derive(Debug, Clone)]
struct ChunkSums {
    scan: usize,
    hessian: Block,
    descent: SVector<f64, LOCAL>,
    cost: f64,
}

impl NormalEquations {
    /// Equations of this number of unknowns without any sample.
    pub(crate) fn zeros(size: usize) -> Self {
        Self { hessian: DMatrix::zeros(size, size), descent: DVector::zeros(size), cost: 0.0 }
    }

    pub(super) fn new(observations: &Observations, weights: &[Weight], state: &SolverState, free: &Free) -> Self {
        let chunks = observations.chunks();
        let blocks: Vec<ChunkSums> =
            chunks.par_iter().map(|chunk| ChunkSums::new(observations, weights, state, chunk.clone())).collect();
        let mut sums = Self::zeros(free.len());
        for block in &blocks {
            for (parameter, unknown) in free.columns(block.scan) {
                sums.descent[unknown] += block.descent[parameter];
            }
            free.add_block(&mut sums.hessian, block.scan, &block.hessian);
            sums.cost += block.cost;
        }
        sums
    }
}

impl ChunkSums {
    fn new(observations: &Observations, weights: &[Weight], state: &SolverState, chunk: Range<usize>) -> Self {
        let scan = observations.all[chunk.start].scan;
        let mut block = Self { scan, hessian: Block::zeros(), descent: SVector::zeros(), cost: 0.0 };
        for (observation, weight) in observations.all[chunk.clone()].iter().zip(&weights[chunk]) {
            if !weight.is_used() {
                continue;
            }
            let Some(equations) = equations(state, observation, weight) else {
                block.cost += cauchy_loss(LOST);
                continue;
            };
            let squared = equations.residual.norm_squared();
            block.cost += cauchy_loss(squared);
            block.add(&equations, cauchy_weight(squared));
        }
        for row in 0..LOCAL {
            for column in 0..row {
                block.hessian[(column, row)] = block.hessian[(row, column)];
            }
        }
        block
    }

    /// Adds a sample to the lower triangle.
    fn add(&mut self, equations: &Equations, factor: f64) {
        for (row, residual) in equations.slopes.iter().zip(equations.residual.iter()) {
            let scaled = row * factor;
            for column in 0..LOCAL {
                let by = row[column];
                for below in column..LOCAL {
                    self.hessian[(below, column)] += scaled[below] * by;
                }
                self.descent[column] += scaled[column] * residual;
            }
        }
    }
}

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
