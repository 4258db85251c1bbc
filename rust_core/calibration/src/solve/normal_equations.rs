//! Normal equations of the weighted robust least squares, summed in parallel.
//!
//! A sample depends on the lens and on one pose, so it adds to a small dense block. A task sums a chunk of one scan's
//! samples, and the chunks are added to the large matrix in their order, independent of the number of threads (Triggs et
//! al., "Bundle adjustment: a modern synthesis", 2000, section 6).

use std::ops::Range;

use nalgebra::{DMatrix, DVector, SVector};
use rayon::prelude::*;

use super::depth_errors::{equations, Equations};
use super::input::Observations;
use super::model::{Block, Free, SolverState, LOCAL};
use super::noise::{cauchy_loss, cauchy_weight, Weight};

/// Squared residual, in deviations, of a sample that cannot be projected.
const LOST: f64 = 1e4;

/// Normal equations at a state.
#[derive(Debug, Clone)]
pub(super) struct NormalEquations {
    /// Gauss-Newton approximation of the second derivatives of half the cost.
    pub(super) hessian: DMatrix<f64>,
    /// Negative gradient of half the cost.
    pub(super) descent: DVector<f64>,
    /// Sum of the losses.
    pub(super) cost: f64,
}

/// Sums of a chunk.
#[derive(Debug, Clone)]
struct ChunkSums {
    scan: usize,
    hessian: Block,
    descent: SVector<f64, LOCAL>,
    cost: f64,
}

impl NormalEquations {
    /// Sums over all used samples.
    pub(super) fn new(observations: &Observations, weights: &[Weight], state: &SolverState, free: &Free) -> Self {
        let chunks = observations.chunks();
        let blocks: Vec<ChunkSums> =
            chunks.par_iter().map(|chunk| ChunkSums::new(observations, weights, state, chunk.clone())).collect();
        let size = free.len();
        let mut sums = Self { hessian: DMatrix::zeros(size, size), descent: DVector::zeros(size), cost: 0.0 };
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
