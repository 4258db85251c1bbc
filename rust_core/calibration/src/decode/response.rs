//! Camera response, estimated from the capture: gamma and noise.
//!
//! In linear light, the sum of stripes and their inverse equals that of white and black, with interreflections too. So
//! gamma is the exponent with which the sums agree where stripes are half lit, and the rest is the noise of four
//! images.

use super::channels::Channels;
use super::Images;
use crate::statistics::{bisect, median};

/// Number of sampled pixels, and minimum for a result.
const SAMPLED: usize = 6000;
const LEAST: usize = 50;
/// Range of cameras' gammas.
const GAMMAS: [f64; 2] = [0.8, 3.0];
/// Level from which on a pixel may be clipped.
pub(super) const CLIPPED_FROM: u8 = 254;
/// Ratio of variance and median square of a normal variable.
const VARIANCE_OF_MEDIAN_SQUARE: f64 = 1.0 / 0.4549;
/// Variance by rounding to whole levels, levels².
const ROUNDING: f64 = 1.0 / 12.0;

/// Response and noise of the camera. Linear light is 1 at level 255.
#[derive(Debug, Clone)]
pub(crate) struct Response {
    light: Vec<f32>,
    /// Exponent: light = (level / 255) ^ gamma.
    pub(super) gamma: f64,
    /// Variance of an image's light in darkness, and its growth with the light.
    noise: [f64; 2],
}

impl Response {
    /// Estimates the response from well lit pixels.
    pub(crate) fn find(images: &Images<'_>, channels: &Channels) -> Self {
        let sample = LevelSample::collect(images, channels);
        let mut response = Self::with_gamma(1.0);
        if sample.pixels.len() >= LEAST {
            response = Self::with_gamma(sample.gamma());
            response.noise = sample.noise(&response);
        }
        response
    }

    fn with_gamma(gamma: f64) -> Self {
        let light = (0..=255).map(|level| (f64::from(level) / 255.0).powf(gamma) as f32).collect();
        Self { light, gamma, noise: [2.0 / (255.0 * 255.0), 0.0] }
    }

    /// Linear light of a level.
    #[inline]
    pub(crate) fn light(&self, level: u8) -> f32 {
        self.light[usize::from(level)]
    }

    /// Variance of the difference of two images whose lights have this sum.
    #[inline]
    pub(super) fn difference_variance(&self, sum: f32) -> f32 {
        2.0 * self.noise[0] as f32 + self.noise[1] as f32 * sum
    }
}

/// Levels of one pixel: white, black, and stripes with their inverses.
struct PixelLevels {
    white: u8,
    black: u8,
    pairs: Vec<[u8; 2]>,
}

impl PixelLevels {
    /// Unclipped pairs of stripes and inverses.
    fn unclipped(&self) -> impl Iterator<Item = &[u8; 2]> {
        self.pairs.iter().filter(|pair| pair.iter().all(|level| *level < CLIPPED_FROM))
    }
}

struct LevelSample {
    pixels: Vec<PixelLevels>,
}

impl LevelSample {
    /// Samples pixels that are neither clipped nor 0 in black, unless black is 0 everywhere, as in rendered images.
    fn collect(images: &Images<'_>, channels: &Channels) -> Self {
        let sample = Self::with_black_from(1, images, channels);
        if sample.pixels.len() < LEAST {
            return Self::with_black_from(0, images, channels);
        }
        sample
    }

    fn with_black_from(least_black: u8, images: &Images<'_>, channels: &Channels) -> Self {
        let (white, black) = (images.levels[channels.white], images.levels[channels.black]);
        let all = channels.axes.iter().flat_map(|axis| &axis.all);
        let pairs: Vec<[usize; 2]> = all.map(|channel| [channel.lit, channel.inverse]).collect();
        let is_good = |pixel: &usize| {
            let (white, black) = (white[*pixel], black[*pixel]);
            white < CLIPPED_FROM && black >= least_black && white > black.saturating_add(20)
        };
        let good = (0..white.len()).filter(is_good).count();
        let every = (good / SAMPLED).max(1);
        let levels = |pixel: usize| PixelLevels {
            white: white[pixel],
            black: black[pixel],
            pairs: pairs.iter().map(|pair| pair.map(|image| images.levels[image][pixel])).collect(),
        };
        Self { pixels: (0..white.len()).filter(is_good).step_by(every).map(levels).collect() }
    }

    /// Excess of the light of stripes and inverse over white and black, weighted by how half lit they are.
    fn excess(&self, gamma: f64) -> f64 {
        let response = Response::with_gamma(gamma);
        let light = |level: u8| f64::from(response.light(level));
        let mut excess = 0.0;
        for pixel in &self.pixels {
            let (white, black) = (light(pixel.white), light(pixel.black));
            let range = white - black;
            for [lit, inverse] in pixel.unclipped() {
                let contrast = f64::from(lit.abs_diff(*inverse)) / f64::from(pixel.white - pixel.black);
                // Clamped, so that moving objects do not dominate.
                let difference = ((light(*lit) + light(*inverse) - white - black) / range).clamp(-0.3, 0.3);
                excess += difference * (1.0 - contrast).max(0.0);
            }
        }
        excess
    }

    fn gamma(&self) -> f64 {
        // Too small a gamma makes half lit stripes too bright.
        if self.excess(GAMMAS[0]) < 0.0 || self.excess(GAMMAS[1]) > 0.0 {
            return 1.0;
        }
        let [low, high] = bisect(GAMMAS, 12, |gamma| self.excess(gamma) > 0.0);
        0.5 * (low + high)
    }

    /// Line through the variances of eight brightness bins.
    fn noise(&self, response: &Response) -> [f64; 2] {
        const BINS: usize = 8;
        let light = |level: u8| f64::from(response.light(level));
        let mut squares: Vec<(f64, f64)> = Vec::new();
        for pixel in &self.pixels {
            let sum = light(pixel.white) + light(pixel.black);
            squares
                .extend(pixel.unclipped().map(|[lit, inverse]| (sum, (light(*lit) + light(*inverse) - sum).powi(2))));
        }
        squares.sort_by(|a, b| a.0.total_cmp(&b.0));
        let points: Vec<[f64; 2]> = squares
            .chunks(squares.len().div_ceil(BINS))
            .map(|bin| {
                let mut values: Vec<f64> = bin.iter().map(|(_, square)| *square).collect();
                let sum = bin.iter().map(|(sum, _)| sum).sum::<f64>() / bin.len() as f64;
                [sum, median(&mut values) * VARIANCE_OF_MEDIAN_SQUARE]
            })
            .collect();
        // Variance of four images: 4 a + 2 b (white + black).
        let count = points.len() as f64;
        let mean = points.iter().fold([0.0, 0.0], |mean, [x, y]| [mean[0] + x / count, mean[1] + y / count]);
        let (mut xx, mut xy) = (0.0, 0.0);
        for [x, y] in &points {
            xx += (x - mean[0]).powi(2);
            xy += (x - mean[0]) * (y - mean[1]);
        }
        let slope = if xx > 0.0 { (xy / xx).max(0.0) } else { 0.0 };
        let slope = slope.min(mean[1] / mean[0].max(1e-9));
        // Lower bound: rounding at half the light.
        let rounding = ROUNDING * (response.gamma / 255.0).powi(2) * 0.5;
        [((mean[1] - slope * mean[0]) / 4.0).max(rounding), slope / 2.0]
    }
}
