//! Camera sensor: lens blur, shift, shot and read noise, gamma and quantisation to 8 bits.

use nalgebra::Vector2;
use rayon::prelude::*;

use crate::{Conditions, Random};

/// Light steps of the level table.
const STEPS: usize = 1 << 16;

/// Camera sensor.
#[derive(Debug, Clone)]
pub(crate) struct Sensor {
    /// Lens blur: the centre tap and those to one side.
    kernel: Vec<f32>,
    /// Level of each light step.
    levels: Vec<u8>,
    full_well: f64,
    read_noise: f64,
    seed: u64,
}

impl Sensor {
    pub(crate) fn new(conditions: &Conditions) -> Self {
        let level = |step: usize| {
            let light = step as f64 / (STEPS - 1) as f64;
            (255.0 * light.powf(1.0 / conditions.gamma)).round() as u8
        };
        Self {
            kernel: gaussian(conditions.camera_blur_px),
            levels: (0..STEPS).map(level).collect(),
            full_well: conditions.full_well,
            read_noise: conditions.read_noise,
            seed: conditions.seed,
        }
    }

    /// Image of light, row by row, where 1 fills the sensor's wells.
    pub(crate) fn expose(&self, light: &[f32], width: usize, shift_px: Vector2<f64>, image: u32) -> Vec<u8> {
        let shifted = if shift_px == Vector2::zeros() { light.to_vec() } else { shifted(light, width, shift_px) };
        let blurred = self.blurred(&shifted, width);
        let mut levels = vec![0; blurred.len()];
        levels.par_chunks_mut(width).zip(blurred.par_chunks(width)).enumerate().for_each(|(v, (levels, light))| {
            let mut random = Random::new(&[self.seed, u64::from(image), v as u64]);
            for (level, light) in levels.iter_mut().zip(light) {
                let light = f64::from(*light);
                let noisy = if self.full_well.is_finite() {
                    let electrons = light * self.full_well;
                    let deviation = (electrons.max(0.0) + self.read_noise.powi(2)).sqrt();
                    (electrons + deviation * random.normal()) / self.full_well
                } else {
                    light
                };
                // Negative and too large numbers saturate.
                let step = (noisy * (STEPS - 1) as f64 + 0.5) as usize;
                *level = self.levels[step.min(STEPS - 1)];
            }
        });
        levels
    }

    fn blurred(&self, light: &[f32], width: usize) -> Vec<f32> {
        if self.kernel.len() < 2 {
            return light.to_vec();
        }
        let along = |at: &dyn Fn(usize) -> f32, index: usize, last: usize| {
            let sides = self.kernel.iter().enumerate().skip(1);
            let beside =
                |(tap, share): (usize, &f32)| share * (at(index.saturating_sub(tap)) + at((index + tap).min(last)));
            self.kernel[0] * at(index) + sides.map(beside).sum::<f32>()
        };
        let height = light.len() / width;
        let mut across = vec![0.0; light.len()];
        across.par_chunks_mut(width).zip(light.par_chunks(width)).for_each(|(across, row)| {
            for (u, value) in across.iter_mut().enumerate() {
                *value = along(&|u| row[u], u, width - 1);
            }
        });
        let mut blurred = vec![0.0; light.len()];
        blurred.par_chunks_mut(width).enumerate().for_each(|(v, blurred)| {
            for (u, value) in blurred.iter_mut().enumerate() {
                *value = along(&|v| across[v * width + u], v, height - 1);
            }
        });
        blurred
    }
}

/// Centre tap of a Gaussian and those to one side; all taps sum to 1.
fn gaussian(deviation: f64) -> Vec<f32> {
    let reach = (3.0 * deviation).ceil() as usize;
    let taps: Vec<f64> = (0..=reach).map(|tap| (-0.5 * (tap as f64 / deviation.max(1e-9)).powi(2)).exp()).collect();
    let sum = 2.0 * taps.iter().sum::<f64>() - taps[0];
    taps.iter().map(|tap| (tap / sum) as f32).collect()
}

/// Shifts an image with interpolation; edges are repeated.
fn shifted(light: &[f32], width: usize, shift_px: Vector2<f64>) -> Vec<f32> {
    let height = light.len() / width;
    let split = |at: usize, shift: f64, last: usize| {
        let place = (at as f64 - shift).clamp(0.0, last as f64);
        (place as usize, (place as usize + 1).min(last), place.fract() as f32)
    };
    let mut moved = vec![0.0; light.len()];
    for (v, row) in moved.chunks_mut(width).enumerate() {
        let (upper, lower, down) = split(v, shift_px.y, height - 1);
        for (u, value) in row.iter_mut().enumerate() {
            let (left, right, across) = split(u, shift_px.x, width - 1);
            let along = |v: usize| {
                let (one, other) = (light[v * width + left], light[v * width + right]);
                one + (other - one) * across
            };
            *value = along(upper) + (along(lower) - along(upper)) * down;
        }
    }
    moved
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blur_keeps_light_and_spreads_it() {
        let sensor = Sensor::new(&Conditions { camera_blur_px: 0.6, ..Conditions::ideal() });
        let mut light = vec![0.0; 21 * 15];
        light[7 * 21 + 10] = 1.0;
        let blurred = sensor.blurred(&light, 21);
        assert!((blurred.iter().sum::<f32>() - 1.0).abs() < 1e-5);
        let variance: f32 = blurred.iter().enumerate().map(|(i, b)| b * ((i % 21) as f32 - 10.0).powi(2)).sum();
        assert!((variance.sqrt() - 0.6).abs() < 0.02, "{variance}");
    }

    #[test]
    fn a_shift_moves_what_is_seen() {
        let light: Vec<f32> = (0..20 * 10).map(|i| (i % 20) as f32 + 100.0 * (i / 20) as f32).collect();
        let moved = shifted(&light, 20, Vector2::new(1.5, -2.0));
        assert!((moved[3 * 20 + 8] - (6.5 + 500.0)).abs() < 1e-3);
    }

    #[test]
    fn noise_is_that_of_electrons() {
        let conditions = Conditions { full_well: 2000.0, read_noise: 15.0, ..Conditions::ideal() };
        let levels = Sensor::new(&conditions).expose(&vec![0.5; 200 * 200], 200, Vector2::zeros(), 0);
        let mean = levels.iter().map(|level| f64::from(*level)).sum::<f64>() / 4e4;
        let variance = levels.iter().map(|level| (f64::from(*level) - mean).powi(2)).sum::<f64>() / 4e4;
        let expected = 255.0 * (1000.0_f64 + 225.0).sqrt() / 2000.0;
        assert!((mean - 127.5).abs() < 0.1 && (variance.sqrt() - expected).abs() < 0.1, "{mean} {variance}");
    }
}
