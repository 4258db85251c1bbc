//! Cross-validation: errors of held-out samples, and the comparison of models by them.
//!
//! Neighbouring samples share errors, so whole blocks are held out: cells of the projector's image times near and far
//! (block cross-validation; Roberts et al., "Cross-validation strategies for data with temporal, spatial, hierarchical,
//! or phylogenetic structure", 2017). Each of five folds has blocks from all over the image.

use nalgebra::Vector2;
use rayon::prelude::*;

use super::adjust;
use super::input::Observations;
use super::model::{Free, SolverState};
use super::noise::Weight;
use crate::statistics::median;

const FOLDS: usize = 5;
/// Blocks along u and v.
const BLOCKS: [usize; 2] = [8, 6];
/// Maximum steps of an adjustment without a fold, from the solution with it.
const STEPS: usize = 6;
/// Maximum squared error, in deviations, in comparisons.
const MOST: f64 = 25.0;
/// Maximum RMS ratio to a simpler model.
const NOTICEABLE: f64 = 0.99;
/// Minimum mean gain of the blocks, standard errors.
const SIGNIFICANT: f64 = 2.0;

/// Assignment of samples to blocks, and of blocks to folds.
#[derive(Debug, Clone)]
pub(super) struct Blocks {
    of: Vec<usize>,
    fold_of: Vec<usize>,
}

impl Blocks {
    /// Divides samples into blocks by pixel, depth and scan.
    pub(super) fn new(observations: &Observations, size_px: [u32; 2]) -> Self {
        let scans = observations.scans.len();
        let median_m: Vec<f64> = (0..scans).map(|scan| median(&mut observations.depths(scan))).collect();
        let cell = |value: f64, size: u32, count: usize| {
            ((value + 0.5) / f64::from(size) * count as f64).clamp(0.0, count as f64 - 1.0) as usize
        };
        let [columns, rows] = BLOCKS;
        let of = observations
            .all
            .iter()
            .map(|observation| {
                let column = cell(observation.pixel.x, size_px[0], columns);
                let row = cell(observation.pixel.y, size_px[1], rows);
                let is_far = usize::from(observation.point.z > median_m[observation.scan]);
                ((observation.scan * 2 + is_far) * rows + row) * columns + column
            })
            .collect();
        // A knight's move from one block of a fold to the next.
        let fold_of = (0..scans * 2 * rows * columns)
            .map(|block| (block % columns + 2 * (block / columns % rows) + 3 * (block / (columns * rows))) % FOLDS)
            .collect();
        Self { of, fold_of }
    }
}

#[derive(Debug, Clone)]
pub(super) struct HeldOut {
    /// Errors of the used samples, pixels.
    errors: Vec<Option<Vector2<f64>>>,
}

impl HeldOut {
    /// Holds out each fold in turn.
    pub(super) fn new(
        observations: &Observations,
        weights: &[Weight],
        blocks: &Blocks,
        state: &SolverState,
        free: &Free,
    ) -> Self {
        let fold_of = |i: usize| blocks.fold_of[blocks.of[i]];
        let states: Vec<SolverState> = (0..FOLDS)
            .into_par_iter()
            .map(|fold| {
                let rest: Vec<Weight> = weights
                    .iter()
                    .enumerate()
                    .map(|(i, weight)| if fold_of(i) == fold { Weight::default() } else { *weight })
                    .collect();
                adjust::minimise(observations, &rest, state, free, STEPS)
            })
            .collect();
        let errors = (observations.all.iter().zip(weights).enumerate())
            .map(|(i, (observation, weight))| {
                if !weight.is_used() {
                    return None;
                }
                // A point that cannot be projected has an error of the whole image.
                let far = || Vector2::from(states[fold_of(i)].lens.size_px.map(f64::from));
                let predicted = states[fold_of(i)].project(observation.scan, &observation.point);
                Some(predicted.map_or_else(far, |predicted| observation.pixel - predicted))
            })
            .collect();
        Self { errors }
    }

    pub(super) fn rms_px(&self) -> f64 {
        let (sum, count) =
            self.errors.iter().flatten().fold((0.0, 0), |(sum, count), error| (sum + error.norm_squared(), count + 1));
        (sum / f64::from(count.max(1))).sqrt()
    }

    /// `true` if the errors are significantly smaller than those of a simpler model.
    pub(super) fn is_better_than(&self, simpler: &Self, weights: &[Weight], blocks: &Blocks) -> bool {
        let mut gains = vec![(0.0, 0.0); blocks.fold_of.len()];
        let (mut own, mut others) = (0.0, 0.0);
        for (i, weight) in weights.iter().enumerate() {
            let (Some(error), Some(other)) = (self.errors[i], simpler.errors[i]) else { continue };
            let squared = weight.whitened(error).norm_squared().min(MOST);
            let other = weight.whitened(other).norm_squared().min(MOST);
            own += squared;
            others += other;
            let (gain, count) = &mut gains[blocks.of[i]];
            *gain += other - squared;
            *count += 1.0;
        }
        gains.retain(|(_, count)| *count > 0.0);
        let total: f64 = gains.iter().map(|(gain, _)| gain).sum();
        let samples: f64 = gains.iter().map(|(_, count)| count).sum();
        let mean = total / samples;
        // Standard error of a ratio of sums over blocks.
        let spread: f64 = gains.iter().map(|(gain, count)| (gain - mean * count).powi(2)).sum();
        own < NOTICEABLE * NOTICEABLE * others && total > SIGNIFICANT * spread.sqrt()
    }
}
