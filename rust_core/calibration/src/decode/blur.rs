//! Blur of the stripes in each tile of the camera's image, from the remaining contrast of the fine ones.

use std::sync::OnceLock;

use super::channels::{AxisChannels, MOST_CHANNELS};
use super::stripes::{self, Contrasts, LEVELS};

/// Minimum width of stripes that blur does not affect.
pub(super) const COARSE_FROM_PX: f64 = 60.0;
/// Weight of the whole image in a tile's sums, pixels.
const PIXELS_OF_ALL: f32 = 40.0;

/// Sums over the lit pixels of a region, for one axis.
#[derive(Debug, Clone)]
pub(super) struct Energy {
    /// Squared normalised differences of each channel, minus the noise's variance.
    squares: [f32; MOST_CHANNELS],
    /// Number of pixels.
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
            let contrasts = Contrasts::new(self.channels, self.size, stripes::blur_px(level));
            let mut energies = vec![0.0; self.channels.all.len()];
            for place in 0..contrasts.places {
                energies.iter_mut().zip(contrasts.at(place)).for_each(|(energy, value)| *energy += value * value);
            }
            energies.iter_mut().for_each(|energy| *energy /= contrasts.places as f32);
            (contrasts, energies)
        })
    }

    /// Contrasts for a blur level.
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
            return (stripes::level_of(1.0), 1.0);
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
