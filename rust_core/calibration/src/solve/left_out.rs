//! How well samples are predicted that were left out, and which terms of the distortion that speaks for.
//!
//! Neighbouring samples share errors, so whole blocks are left out: cells of the projector's picture times near and far
//! (block cross-validation; Roberts et al., "Cross-validation strategies for data with temporal, spatial, hierarchical,
//! or phylogenetic structure", 2017). Each of five parts has blocks from all over the picture.

use nalgebra::Vector2;
use rayon::prelude::*;

use super::adjust::{self, Effort};
use super::input::Observations;
use super::model::{Free, State};
use super::noise::{quantile, Weight};

/// Parts that are left out in turns.
const PARTS: usize = 5;
/// Blocks along u and v.
const BLOCKS: [usize; 2] = [8, 6];
/// Steps of an adjustment without a part, from the solution with it.
const STEPS: usize = 6;
/// The squared miss, in deviations, that counts at most when models are compared.
const MOST: f64 = 25.0;
/// A model with more terms has to miss by so much less.
const NOTICEABLE: f64 = 0.99;
/// By so many standard errors its blocks have to be better on the average.
const SIGNIFICANT: f64 = 2.0;

/// The block of each sample and how many there are.
#[derive(Debug, Clone)]
pub(super) struct Blocks {
    of: Vec<usize>,
    part_of: Vec<usize>,
}

impl Blocks {
    /// Blocks of samples by pixel, distance and scan.
    pub(super) fn new(observations: &Observations, size_px: [u32; 2]) -> Self {
        let scans = observations.scans.len();
        let median_m: Vec<f64> = (0..scans)
            .map(|scan| {
                let mut depths: Vec<f64> =
                    observations.all[observations.range(scan)].iter().map(|o| o.point.z).collect();
                quantile(&mut depths, 0.5)
            })
            .collect();
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
        // A knight's move from one block of a part to the next.
        let part_of = (0..scans * 2 * rows * columns)
            .map(|block| (block % columns + 2 * (block / columns % rows) + 3 * (block / (columns * rows))) % PARTS)
            .collect();
        Self { of, part_of }
    }
}

/// Misses of samples that were left out.
#[derive(Debug, Clone)]
pub(super) struct LeftOut {
    /// For each sample that takes part.
    misses: Vec<Option<Vector2<f64>>>,
}

impl LeftOut {
    /// Leaves out each part in turn.
    pub(super) fn new(
        observations: &Observations,
        weights: &[Weight],
        blocks: &Blocks,
        state: &State,
        free: &Free,
    ) -> Self {
        let part_of = |i: usize| blocks.part_of[blocks.of[i]];
        let states: Vec<State> = (0..PARTS)
            .into_par_iter()
            .map(|part| {
                let rest: Vec<Weight> = weights
                    .iter()
                    .enumerate()
                    .map(|(i, weight)| if part_of(i) == part { Weight::default() } else { *weight })
                    .collect();
                adjust::minimise(observations, &rest, state, free, Effort { most_steps: STEPS, ..Effort::FULL })
            })
            .collect();
        let misses = (observations.all.iter().zip(weights).enumerate())
            .map(|(i, (observation, weight))| {
                if !weight.is_used() {
                    return None;
                }
                // What the solution without its part cannot project at all misses by the whole picture.
                let far = || Vector2::from(states[part_of(i)].lens.size_px.map(f64::from));
                let predicted = states[part_of(i)].project(observation.scan, &observation.point);
                Some(predicted.map_or_else(far, |predicted| observation.pixel - predicted))
            })
            .collect();
        Self { misses }
    }

    /// Root of the mean squared miss, pixels.
    pub(super) fn rms_px(&self) -> f64 {
        let (sum, count) =
            self.misses.iter().flatten().fold((0.0, 0), |(sum, count), miss| (sum + miss.norm_squared(), count + 1));
        (sum / f64::from(count.max(1))).sqrt()
    }

    /// Whether these misses are noticeably smaller than those of a simpler model.
    pub(super) fn is_better_than(&self, simpler: &Self, weights: &[Weight], blocks: &Blocks) -> bool {
        let mut gains = vec![(0.0, 0.0); blocks.part_of.len()];
        let (mut own, mut others) = (0.0, 0.0);
        for (i, weight) in weights.iter().enumerate() {
            let (Some(miss), Some(other)) = (self.misses[i], simpler.misses[i]) else { continue };
            let squared = weight.whitened(miss).norm_squared().min(MOST);
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
        // The error of a ratio of sums over blocks.
        let spread: f64 = gains.iter().map(|(gain, count)| (gain - mean * count).powi(2)).sum();
        own < NOTICEABLE * NOTICEABLE * others && total > SIGNIFICANT * spread.sqrt()
    }
}
