//! The normal equations of the weighted, robust least squares: sums over samples, in parallel.
//!
//! A sample depends on the lens and on one pose, so it adds to a small dense block; a chunk of samples of one scan is
//! summed by one thread, and the chunks are put into the large matrix in their order (Triggs et al., "Bundle
//! adjustment: a modern synthesis", 2000, section 6). So the sums do not depend on the number of threads.

use std::ops::Range;

use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use rayon::prelude::*;

use super::depth_errors::{equations, Equations};
use super::input::Observations;
use super::model::{Free, State, LOCAL};
use super::noise::{cauchy_loss, cauchy_weight, Weight};

/// The squared residual, in deviations, that a sample counts with which the lens cannot project.
const LOST: f64 = 1e4;

/// The normal equations at a state.
#[derive(Debug, Clone)]
pub(super) struct NormalEquations {
    /// Gauss and Newton's approximation of the second derivatives of half the cost.
    pub(super) hessian: DMatrix<f64>,
    /// Minus the first derivatives of half the cost.
    pub(super) descent: DVector<f64>,
    /// The sum of the losses.
    pub(super) cost: f64,
}

/// What the samples of a chunk add.
#[derive(Debug, Clone)]
struct Block {
    scan: usize,
    hessian: SMatrix<f64, LOCAL, LOCAL>,
    descent: SVector<f64, LOCAL>,
    cost: f64,
}

impl NormalEquations {
    /// Sums over all samples that take part.
    pub(super) fn new(observations: &Observations, weights: &[Weight], state: &State, free: &Free) -> Self {
        let chunks = observations.chunks();
        let blocks: Vec<Block> =
            chunks.par_iter().map(|chunk| Block::new(observations, weights, state, chunk.clone())).collect();
        let size = free.len();
        let mut sums = Self { hessian: DMatrix::zeros(size, size), descent: DVector::zeros(size), cost: 0.0 };
        for block in &blocks {
            let columns = free.columns(block.scan);
            for (parameter, unknown) in &columns {
                sums.descent[*unknown] += block.descent[*parameter];
                for (other_parameter, other_unknown) in &columns {
                    sums.hessian[(*unknown, *other_unknown)] += block.hessian[(*parameter, *other_parameter)];
                }
            }
            sums.cost += block.cost;
        }
        sums
    }
}

impl Block {
    fn new(observations: &Observations, weights: &[Weight], state: &State, chunk: Range<usize>) -> Self {
        let scan = observations.all[chunk.start].scan;
        let mut block = Self { scan, hessian: SMatrix::zeros(), descent: SVector::zeros(), cost: 0.0 };
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
