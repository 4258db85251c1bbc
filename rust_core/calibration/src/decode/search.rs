//! Coordinate of a pixel along one axis: where blurred stripes explain its levels best.
//!
//! The code's signs lead to a neighbourhood of a few pixels: a wrong bit has an edge nearby, and a Gray code's finer
//! bits are mirrored about it. In that neighbourhood every place is compared with all stripes. The share of direct
//! light is free for each pixel, so interreflections do no harm (Nayar, Krishnan, Grossberg, Raskar, "Fast separation
//! of direct and global components", 2006).

use super::blur::{self, Contrasts, PER_PIXEL};
use super::channels::{AxisChannels, MOST_CHANNELS};

/// Differences of stripes and inverse over that of white and black, padded with zeros.
pub(super) type Differences = [f32; MOST_CHANNELS];

/// Model error of the blurred stripes, as a share of the contrast.
const MODEL_ERROR: f32 = 0.04;
/// Maximum number of compared places.
const MOST_PLACES: usize = 192;
/// Minimum contrast of a readable bit, in multiples of the noise.
const VISIBLE: f32 = 2.0;

/// Search in a tile.
pub(super) struct Search<'a> {
    pub(super) channels: &'a AxisChannels,
    pub(super) contrasts: &'a Contrasts,
    /// Standard deviation of the blur, projector pixels.
    pub(super) blur_px: f32,
    /// RMS contrast of each channel.
    pub(super) visible: &'a [f32],
}

/// Best place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Found {
    /// Projector coordinate, pixels.
    pub(super) at: f32,
    /// Standard deviation, pixels.
    pub(super) sigma: f32,
    /// Margin to the next best place that is not a neighbour: difference of squared residuals over the noise's
    /// variance.
    pub(super) margin: f32,
    /// Mean squared residual over the expected variance.
    pub(super) misfit: f32,
    /// Explained squares, in units of `margin`.
    pub(super) explained: f32,
}

impl Search<'_> {
    /// Range of coordinates that the readable bits leave, pixels.
    fn read_code(&self, differences: &Differences, noise: f32) -> (f32, f32) {
        let (mut code, mut bit, mut read) = (0_u32, 0_u32, 0_u32);
        for (index, channel) in self.channels.all[..self.channels.code_bits].iter().enumerate() {
            if index > 0 && self.visible[index] < VISIBLE * noise && channel.stripes.width_px() < 60.0 {
                break;
            }
            bit ^= u32::from(differences[index] > 0.0);
            code = (code << 1) | bit;
            read += 1;
        }
        let stripes = self.channels.all[0].stripes;
        let width = (u64::from(stripes.step) << (stripes.bits - read)) as f32;
        let low = code as f32 * width - stripes.offset as f32 - 0.5;
        (low, low + width)
    }

    /// Best place for differences with a standard deviation of `noise`.
    pub(super) fn find(&self, differences: &Differences, noise: f32) -> Option<Found> {
        let (low, high) = self.read_code(differences, noise);
        let reach = 1.5 + 3.0 * self.blur_px;
        self.find_between(differences, noise, low - reach, high + reach)
    }

    /// Best place between two coordinates.
    pub(super) fn find_between(&self, differences: &Differences, noise: f32, low: f32, high: f32) -> Option<Found> {
        let last = self.contrasts.places - 1;
        let first = blur::place(low).max(0.0) as usize;
        let end = (blur::place(high).max(0.0) as usize).min(last);
        if first >= end {
            return None;
        }
        let stride = ((end - first) / (MOST_PLACES - 1) + 1).max(PER_PIXEL / 2);
        let variance = noise * noise + MODEL_ERROR * MODEL_ERROR;
        let mut scores = [0.0_f32; MOST_PLACES];
        let count = (end - first) / stride + 1;
        for (index, score) in scores[..count].iter_mut().enumerate() {
            *score = self.explained(differences, first + index * stride);
        }
        let best = argmax(&scores[..count]);
        let apart = ((1.0 + 1.5 * self.blur_px) * PER_PIXEL as f32 / stride as f32).ceil() as usize;
        let others = scores[..count].iter().enumerate().filter(|(index, _)| index.abs_diff(best) > apart);
        let next = others.map(|(_, score)| *score).fold(0.0, f32::max);
        let (at, sigma, explained) = self.refine(differences, variance, first + best * stride, stride);
        let total: f32 = differences.iter().map(|difference| difference * difference).sum();
        let freedom = (self.channels.all.len().max(3) - 2) as f32;
        Some(Found {
            at,
            sigma,
            margin: (explained - next) / variance,
            misfit: (total - explained) / (variance * freedom),
            explained: explained / variance,
        })
    }

    /// Squares explained by the stripes at a place, with the best share of direct light.
    #[inline]
    fn explained(&self, differences: &Differences, place: usize) -> f32 {
        let (along, square) = products(differences, self.contrasts.at(place));
        let along = along.max(0.0);
        along * along / square.max(1e-3)
    }

    /// Mean, deviation and explained squares of the likelihood around the best place.
    fn refine(&self, differences: &Differences, variance: f32, best: usize, stride: usize) -> (f32, f32, f32) {
        let reach = stride.max(PER_PIXEL / 2) + PER_PIXEL;
        let (first, end) = (best.saturating_sub(reach), (best + reach).min(self.contrasts.places - 1));
        let mut scores = [0.0_f32; 2 * (MOST_PLACES + PER_PIXEL) + 1];
        let scores = &mut scores[..=(end - first)];
        for (index, score) in scores.iter_mut().enumerate() {
            *score = self.explained(differences, first + index);
        }
        let top = argmax(scores);
        let (mut weights, mut mean, mut square) = (0.0, 0.0, 0.0);
        for (index, score) in scores.iter().enumerate() {
            let behind = (scores[top] - score) / (2.0 * variance);
            if behind < 9.0 {
                let (weight, at) = ((-behind).exp(), index as f32 - top as f32);
                weights += weight;
                mean += weight * at;
                square += weight * at * at;
            }
        }
        mean /= weights;
        // Variance of the table's spacing.
        let mut spread = (square / weights - mean * mean).max(0.0) + 1.0 / 12.0;
        if spread < 1.1 && top > 0 && top + 1 < scores.len() {
            // Narrower than the table's spacing: vertex of a parabola.
            let (before, after) = (scores[top - 1], scores[top + 1]);
            let bend = 2.0 * scores[top] - before - after;
            if bend > 1e-9 {
                mean = (0.5 * (after - before) / bend).clamp(-0.5, 0.5);
                spread = spread.min(variance / bend);
            }
        }
        let at = blur::coordinate((first + top) as f32 + mean);
        (at, spread.sqrt() / PER_PIXEL as f32, scores[top])
    }
}

/// Index of the first maximum.
fn argmax(scores: &[f32]) -> usize {
    (1..scores.len()).fold(0, |best, index| if scores[index] > scores[best] { index } else { best })
}

/// Σ d m and Σ m².
#[inline]
fn products(differences: &Differences, contrasts: &[f32]) -> (f32, f32) {
    let (mut along, mut square) = ([0.0_f32; 8], [0.0_f32; 8]);
    for (differences, contrasts) in differences.chunks_exact(8).zip(contrasts.chunks_exact(8)) {
        for lane in 0..8 {
            along[lane] += differences[lane] * contrasts[lane];
            square[lane] += contrasts[lane] * contrasts[lane];
        }
    }
    (along.iter().sum(), square.iter().sum())
}
