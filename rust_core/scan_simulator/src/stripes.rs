//! Blurred light of a pattern.
//!
//! Patterns change along one axis, and Gaussians are separable. So a table for each blur strength, with four entries
//! per pixel, suffices: the square wave convolved with the Gaussian.

use std::f64::consts::SQRT_2;

use rayon::prelude::*;
use rcs_calibration::patterns::{Axis, Pattern};

/// Table entries per projector pixel.
const PER_PIXEL: usize = 4;
/// Margin of a table beyond the image, pixels.
const MARGIN_PX: usize = 24;
/// Number of blur strengths, geometrically spaced.
const STRENGTHS: usize = 32;
/// Smallest blur: standard deviation, projector pixels.
const LEAST_PX: f32 = 0.3;
/// Ratio of consecutive strengths.
const RATIO: f32 = 1.1;

/// Table number of a blur, a standard deviation in projector pixels.
pub(crate) fn strength(deviation_px: f32) -> u8 {
    ((deviation_px / LEAST_PX).ln() / RATIO.ln()).round().clamp(0.0, (STRENGTHS - 1) as f32) as u8
}

/// Blur of a table: standard deviation, projector pixels.
pub(crate) fn deviation_px(strength: u8) -> f32 {
    LEAST_PX * RATIO.powi(i32::from(strength))
}

/// Brightness, 0 to 1, along an axis for each blur strength.
#[derive(Debug, Clone)]
pub(crate) struct BlurredStripes {
    tables: Vec<Vec<f32>>,
}

impl BlurredStripes {
    /// Creates the tables of a pattern along the axis of its stripes, dark outside of the image. Unused strengths get
    /// no table.
    pub(crate) fn new(pattern: &Pattern, axis: Axis, size_px: [u32; 2], is_used: &[bool]) -> Self {
        let size = size_px[axis.index()];
        let is_lit = |at: u32| match axis {
            Axis::X => pattern.is_lit(at, 0),
            Axis::Y => pattern.is_lit(0, at),
        };
        let levels: Vec<f32> = (0..size).map(|at| if is_lit(at) { 1.0 } else { 0.0 }).collect();
        let table = |strength: usize| match is_used.get(strength) {
            Some(true) => blurred(&levels, f64::from(LEAST_PX) * f64::from(RATIO).powi(strength as i32)),
            _ => Vec::new(),
        };
        Self { tables: (0..STRENGTHS).into_par_iter().map(table).collect() }
    }

    /// Brightness at a coordinate for a blur [`strength`].
    pub(crate) fn at(&self, coordinate: f32, strength: u8) -> f32 {
        let table = self.tables.get(usize::from(strength)).map_or(&[][..], Vec::as_slice);
        let place = ((coordinate + MARGIN_PX as f32) * PER_PIXEL as f32).max(0.0);
        let entry = place as usize;
        let weight = place - entry as f32;
        match table.get(entry..entry.saturating_add(2)) {
            Some([one, next]) => one + (next - one) * weight,
            _ => 0.0,
        }
    }

    /// Number of strengths.
    pub(crate) const fn strengths() -> usize {
        STRENGTHS
    }
}

/// Convolves levels with a Gaussian, at entries from `-MARGIN_PX` on.
fn blurred(levels: &[f32], deviation_px: f64) -> Vec<f32> {
    let reach = ((4.0 * deviation_px + 1.0).ceil() as usize).min(MARGIN_PX);
    let below = |x: f64| normal_distribution(x / deviation_px);
    // Kernels of the pixels from `-reach` to `reach` for each phase.
    let kernels: Vec<Vec<f32>> = (0..PER_PIXEL)
        .map(|phase| {
            let place = phase as f64 / PER_PIXEL as f64;
            let share = |tap: usize| {
                let centre = tap as f64 - reach as f64;
                (below(centre + 0.5 - place) - below(centre - 0.5 - place)) as f32
            };
            (0..=2 * reach).map(share).collect()
        })
        .collect();
    let mut table = Vec::with_capacity((levels.len() + 2 * MARGIN_PX) * PER_PIXEL);
    for pixel in 0..levels.len() + 2 * MARGIN_PX {
        // The pixel under the kernel's first tap, which may lie before the image.
        let first = pixel as isize - MARGIN_PX as isize - reach as isize;
        let skipped = (-first).max(0) as usize;
        let under = levels.get((first.max(0) as usize).min(levels.len())..).unwrap_or_default();
        table.extend(kernels.iter().map(|kernel| {
            let taps = kernel.get(skipped..).unwrap_or_default();
            taps.iter().zip(under).map(|(share, level)| share * level).sum::<f32>()
        }));
    }
    table
}

/// Cumulative normal distribution, within 2e-7 (Abramowitz and Stegun, 7.1.26).
pub(crate) fn normal_distribution(x: f64) -> f64 {
    let z = x.abs() / SQRT_2;
    let t = 1.0 / (1.0 + 0.327_591_1 * z);
    let series =
        t * (0.254_829_592 + t * (-0.284_496_736 + t * (1.421_413_741 + t * (-1.453_152_027 + t * 1.061_405_429))));
    let above = 0.5 * series * (-z * z).exp();
    if x > 0.0 {
        1.0 - above
    } else {
        above
    }
}

#[cfg(test)]
mod tests {
    use rcs_calibration::patterns::gray_code;

    use super::*;

    #[test]
    fn stripes_are_blurred_as_a_gaussian_does() {
        let is_used = [true; STRENGTHS];
        let size = [1280, 800];
        let finest = gray_code(size).into_iter().filter(|pattern| matches!(pattern, Pattern::GrayCode(_))).nth(20);
        let stripes = BlurredStripes::new(&finest.unwrap(), Axis::X, size, &is_used);
        // Stripes two pixels wide: lit at 1, 2, 5, 6. Hardly blurred in the middle, one half at an edge.
        assert!((stripes.at(641.5, 0) - 1.0).abs() < 0.01 && (stripes.at(640.5, 0) - 0.5).abs() < 0.01);
        for strength in 5..15 {
            let deviation = LEAST_PX * RATIO.powi(i32::from(strength));
            // The square wave's harmonics of period 4.
            let mut harmonics = 0.0;
            for n in [1.0_f32, 3.0, 5.0] {
                let omega = std::f32::consts::TAU * n / 4.0;
                let sign = if n == 3.0 { -1.0 } else { 1.0 };
                harmonics += sign * 4.0 / (std::f32::consts::PI * n) * (-0.5 * (omega * deviation).powi(2)).exp();
            }
            let contrast = stripes.at(641.5, strength) - stripes.at(643.5, strength);
            assert!((contrast - harmonics).abs() < 0.01, "{deviation}: {contrast} instead of {harmonics}");
        }
    }

    #[test]
    fn light_ends_at_the_edge_of_the_image() {
        let white = BlurredStripes::new(&Pattern::White, Axis::Y, [1280, 800], &[true; STRENGTHS]);
        let blur = strength(1.0);
        for (at, expected) in [(400.0, 1.0), (-0.5, 0.5), (799.5, 0.5), (-8.0, 0.0), (-200.0, 0.0), (5000.0, 0.0)] {
            assert!((white.at(at, blur) - expected).abs() < 0.01, "{at}: {}", white.at(at, blur));
        }
        assert!(white.at(f32::NAN, blur) == 0.0);
    }
}
