//! Contrasts of an axis's blurred stripes at each place of the projector's image, and the blur in each tile of the
//! camera's image, from the remaining contrast of the fine stripes.
//!
//! The projector's defocus, the camera's pixels and its lens together blur nearly like a Gaussian. Blurred stripes are
//! sums of the Gaussian's integral at the edges.

use std::sync::OnceLock;

use super::channels::{AxisChannels, MOST_CHANNELS};

/// Table entries per projector pixel.
pub(super) const PER_PIXEL: usize = 4;
/// Smallest tabulated blur, a standard deviation; each level is larger by [`RATIO`].
const LEAST_BLUR_PX: f32 = 0.3;
const RATIO: f32 = 1.15;
pub(super) const LEVELS: usize = 27;
/// Reach of an edge's blur, standard deviations.
const REACH: f32 = 4.0;
/// Minimum width of stripes that blur does not affect.
const COARSE_FROM_PX: f64 = 60.0;
/// Weight of the whole image in a tile's sums, pixels.
const PIXELS_OF_ALL: f32 = 40.0;

/// Standard deviation of a blur level.
pub(super) fn blur_px(level: usize) -> f32 {
    LEAST_BLUR_PX * RATIO.powi(level as i32)
}

/// Blur level of a standard deviation.
pub(super) fn level_of(blur_px: f32) -> usize {
    let level = (blur_px / LEAST_BLUR_PX).max(1.0).ln() / RATIO.ln();
    (level.round() as usize).min(LEVELS - 1)
}

/// Contrasts of an axis's stripes: 1 lit, -1 dark, 0 outside of the image.
#[derive(Debug)]
pub(super) struct Contrasts {
    /// Contrasts of all stripes at each place, padded with zeros to `stride`.
    values: Vec<f32>,
    /// Multiple of eight.
    stride: usize,
    pub(super) places: usize,
}

impl Contrasts {
    /// Creates the table of an axis of `size` pixels.
    pub(super) fn new(channels: &AxisChannels, size: u32, blur_px: f32) -> Self {
        let stride = channels.all.len().next_multiple_of(8);
        let places = size as usize * PER_PIXEL + 1;
        let mut values = vec![0.0; places * stride];
        for (index, channel) in channels.all.iter().enumerate() {
            let edges = edges(|at| channel.stripes.is_lit(at), size);
            // Edges before `passed` are complete.
            let (mut passed, mut level) = (0, 0.0);
            for place in 0..places {
                let at = coordinate(place as f32);
                while passed < edges.len() && edges[passed].0 < at - REACH * blur_px {
                    level += edges[passed].1;
                    passed += 1;
                }
                let near = edges[passed..].iter().take_while(|(edge, _)| *edge < at + REACH * blur_px);
                let blurred: f32 = near.map(|(edge, rise)| rise * gaussian_integral((at - edge) / blur_px)).sum();
                values[place * stride + index] = level + blurred;
            }
        }
        Self { values, stride, places }
    }

    #[inline]
    pub(super) fn at(&self, place: usize) -> &[f32] {
        &self.values[place * self.stride..][..self.stride]
    }
}

/// Coordinate of a place of the tables, pixels.
#[inline]
pub(super) fn coordinate(place: f32) -> f32 {
    place / PER_PIXEL as f32 - 0.5
}

#[inline]
pub(super) fn place(coordinate: f32) -> f32 {
    (coordinate + 0.5) * PER_PIXEL as f32
}

/// Edges between lit (1), dark (-1) and outside (0), with their steps.
fn edges(is_lit: impl Fn(u32) -> bool, size: u32) -> Vec<(f32, f32)> {
    let level = |at| if is_lit(at) { 1.0 } else { -1.0 };
    let mut edges = Vec::new();
    let mut before = 0.0;
    for at in 0..size {
        let level = level(at);
        if level != before {
            edges.push((at as f32 - 0.5, level - before));
            before = level;
        }
    }
    edges.push((size as f32 - 0.5, -before));
    edges
}

/// Integral of the standard Gaussian up to x, within 1e-4 (Abramowitz and Stegun, 26.2.17 with fewer terms).
fn gaussian_integral(x: f32) -> f32 {
    let t = 1.0 / (1.0 + 0.33267 * x.abs());
    let density = (-0.5 * x * x).exp() * 0.398_942_3;
    let beyond = density * t * (0.436_183_6 + t * (-0.120_167_6 + t * 0.937_298));
    if x < 0.0 {
        beyond
    } else {
        1.0 - beyond
    }
}

/// Sums over the lit pixels of a region, for one axis.
#[derive(Debug, Clone)]
pub(super) struct Energy {
    /// Squared normalised differences of each channel, minus the noise's variance.
    squares: [f32; MOST_CHANNELS],
    pixels: f32,
}

impl Energy {
    pub(super) const ZERO: Self = Self { squares: [0.0; MOST_CHANNELS], pixels: 0.0 };

    pub(super) fn add(&mut self, differences: &[f32], variance: f32) {
        for (sum, difference) in self.squares.iter_mut().zip(differences) {
            *sum += difference * difference - variance;
        }
        self.pixels += 1.0;
    }

    /// Regularises the sums with those of the whole image.
    pub(super) fn with_prior(&self, all: &Self) -> Self {
        let mut steadied = self.clone();
        if all.pixels > 0.0 {
            let share = PIXELS_OF_ALL / all.pixels;
            steadied.squares.iter_mut().zip(&all.squares).for_each(|(sum, of_all)| *sum += share * of_all);
            steadied.pixels += PIXELS_OF_ALL;
        }
        steadied
    }
}

/// Contrast tables of an axis for all blur levels, created on demand.
pub(super) struct Tables<'a> {
    channels: &'a AxisChannels,
    size: u32,
    levels: [OnceLock<(Contrasts, Vec<f32>)>; LEVELS],
}

impl<'a> Tables<'a> {
    pub(super) fn new(channels: &'a AxisChannels, size: u32) -> Self {
        Self { channels, size, levels: std::array::from_fn(|_| OnceLock::new()) }
    }

    fn level(&self, level: usize) -> &(Contrasts, Vec<f32>) {
        self.levels[level].get_or_init(|| {
            let contrasts = Contrasts::new(self.channels, self.size, blur_px(level));
            let mut energies = vec![0.0; self.channels.all.len()];
            for place in 0..contrasts.places {
                energies.iter_mut().zip(contrasts.at(place)).for_each(|(energy, value)| *energy += value * value);
            }
            energies.iter_mut().for_each(|energy| *energy /= contrasts.places as f32);
            (contrasts, energies)
        })
    }

    pub(super) fn contrasts(&self, level: usize) -> &Contrasts {
        &self.level(level).0
    }

    /// Mean squared contrast of each channel for a blur level.
    pub(super) fn energies(&self, level: usize) -> &[f32] {
        &self.level(level).1
    }

    /// Estimates the blur level and the share of direct light.
    pub(super) fn explain(&self, energy: &Energy) -> (usize, f32) {
        let count = self.channels.all.len();
        let is_coarse = |index: &usize| self.channels.all[*index].stripes.width_px() >= COARSE_FROM_PX;
        let coarse: Vec<usize> = (0..count).filter(is_coarse).collect();
        let coarse = if coarse.is_empty() { vec![0] } else { coarse };
        let pixels = energy.pixels.max(1.0);
        let direct = coarse.iter().map(|index| energy.squares[*index]).sum::<f32>() / (coarse.len() as f32 * pixels);
        if direct.is_nan() || direct <= 0.0 {
            return (level_of(1.0), 1.0);
        }
        let misfit = |level: usize| -> f32 {
            let expected = self.energies(level);
            let fine = (0..count).filter(|index| !is_coarse(index));
            fine.map(|index| (energy.squares[index] / pixels / direct - expected[index]).powi(2)).sum()
        };
        // The misfit has one minimum.
        let (mut low, mut high) = (0, LEVELS - 1);
        while low < high {
            let middle = (low + high) / 2;
            if misfit(middle) <= misfit(middle + 1) {
                high = middle;
            } else {
                low = middle + 1;
            }
        }
        (low, direct.sqrt().min(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::super::channels::Channels;
    use super::*;
    use crate::patterns::gray_code;

    #[test]
    fn sharp_stripes_are_the_pattern() {
        let channels = Channels::new(&gray_code([100, 60])).unwrap();
        let contrasts = Contrasts::new(&channels.axes[0], 100, 0.1);
        for u in 0..100_u32 {
            let here = contrasts.at(place(u as f32) as usize);
            for (channel, value) in channels.axes[0].all.iter().zip(here) {
                let expected = if channel.stripes.is_lit(u) { 1.0 } else { -1.0 };
                assert!((value - expected).abs() < 1e-3, "{u} {value}");
            }
        }
        assert_eq!((coordinate(place(17.25)), contrasts.places, contrasts.stride), (17.25, 401, 8));
    }

    #[test]
    fn blur_takes_contrast_and_the_margin_is_dark() {
        let channels = Channels::new(&gray_code([128, 60])).unwrap();
        let contrasts = Contrasts::new(&channels.axes[0], 128, 2.0);
        let finest = channels.axes[0].all.len() - 1;
        // A period of 4 px: 4/π exp(-2π²σ²/P²).
        let expected = 4.0 / std::f32::consts::PI * (-2.0 * (std::f32::consts::PI * 2.0 / 4.0).powi(2)).exp();
        let largest = (200..300).map(|place| contrasts.at(place)[finest].abs()).fold(0.0, f32::max);
        assert!((largest - expected).abs() < 2e-3, "{largest} {expected}");
        // At the margin half of the light is missing.
        assert!((contrasts.at(0)[0] + 0.5).abs() < 1e-2);
    }

    #[test]
    fn levels_are_those_of_their_blurs() {
        assert!((0..LEVELS).all(|level| level_of(blur_px(level)) == level));
        assert_eq!((level_of(0.0), level_of(1000.0)), (0, LEVELS - 1));
        assert!(blur_px(LEVELS - 1) > 9.0);
        for (x, exact) in [(0.0, 0.5), (1.0, 0.841_344_7), (-1.5, 0.066_807_2), (3.0, 0.998_650_1)] {
            assert!((gaussian_integral(x) - exact).abs() < 1e-4, "{x}");
        }
    }
}
