//! Decoding of one axis: each pixel alone, then with its neighbours.

use rayon::prelude::*;

use super::blur::{blur_px, Energy, Tables};
use super::channels::{AxisChannels, MOST_CHANNELS};
use super::light_images::LightImages;
use super::neighbours::{Field, PlanePrediction};
use super::search::{Found, Search};

/// Side of the tiles with individual blur, camera pixels.
const TILE: usize = 32;
/// Maximum mean squared residual over the expected variance.
const WORST_MISFIT: f32 = 25.0;
/// Minimum margin to the next best place of a pixel without neighbours.
const CLEAR_MARGIN: f32 = 40.0;
/// Maximum loss of explained squares for a place near the prediction instead of the best one.
const WORTH_PREDICTING: f32 = 16.0;
/// Factor of fused deviations: both weights include model errors of stripes and planes. The median over simulated
/// scans.
const CAUTION: f32 = 0.65;
/// Maximum deviation of a decoded coordinate, projector pixels.
pub(super) const WORST_SIGMA_PX: f32 = 1.0;

pub(super) struct AxisDecoder<'a> {
    pub(super) light: &'a LightImages<'a>,
    pub(super) noise: &'a [f32],
    pub(super) channels: &'a AxisChannels,
    pub(super) tables: &'a Tables<'a>,
}

/// Result of one band of tiles.
struct DecodedBand {
    found: Vec<Option<Found>>,
    /// Blur level and share of direct light of each tile.
    tiles: Vec<(usize, f32)>,
}

/// Pixels of an axis, each decoded alone.
pub(super) struct SinglePixels {
    found: Vec<Option<Found>>,
    /// Blur level and share of direct light of each tile, band by band.
    tiles: Vec<Vec<(usize, f32)>>,
    /// Coordinates of reliable pixels.
    pub(super) field: Field,
}

impl SinglePixels {
    /// Subtracts the pull of the camera's blur, projector pixels.
    pub(super) fn compensate(&mut self, pulls: &[f32]) {
        for ((at, found), pull) in self.field.at.iter_mut().zip(&mut self.found).zip(pulls) {
            if let Some(found) = found {
                found.at -= pull;
                *at = found.at;
            }
        }
    }
}

impl AxisDecoder<'_> {
    pub(super) fn decode_single(&self) -> SinglePixels {
        let width = self.light.images.size_px[0] as usize;
        let all = self.energy_of((0..self.noise.len()).step_by(13));
        let bands = self.noise.len().div_ceil(width * TILE);
        let bands: Vec<DecodedBand> = (0..bands).into_par_iter().map(|band| self.band(band, width, &all)).collect();
        let found: Vec<Option<Found>> = bands.iter().flat_map(|band| band.found.iter().copied()).collect();
        let is_sure = |found: &Found| found.misfit < WORST_MISFIT && found.sigma < 3.0;
        let field = Field {
            width,
            at: found.iter().map(|found| found.map_or(0.0, |found| found.at)).collect(),
            sigma: found.iter().map(|found| found.filter(is_sure).map_or(f32::INFINITY, |found| found.sigma)).collect(),
        };
        SinglePixels { found, tiles: bands.into_iter().map(|band| band.tiles).collect(), field }
    }

    /// Decodes each pixel with its neighbours' prediction.
    pub(super) fn decode_together(&self, single: &SinglePixels) -> Field {
        let SinglePixels { found, tiles, field } = single;
        let width = field.width;
        let predictions = field.predictions();
        let mut result = Field { width, at: vec![0.0; field.at.len()], sigma: vec![f32::INFINITY; field.at.len()] };
        result.at.par_chunks_mut(width).zip(result.sigma.par_chunks_mut(width)).enumerate().for_each(
            |(y, (at, sigma))| {
                for x in 0..at.len() {
                    let pixel = y * width + x;
                    let Some(found) = found[pixel] else { continue };
                    let tile = tiles[y / TILE][x / TILE];
                    if let Some((place, deviation)) = self.settle(pixel, found, predictions[pixel], tile) {
                        (at[x], sigma[x]) = (place, deviation);
                    }
                }
            },
        );
        result
    }

    fn energy_of(&self, pixels: impl Iterator<Item = usize>) -> Energy {
        let mut energy = Energy::ZERO;
        for pixel in pixels {
            let noise = self.noise[pixel];
            if noise.is_finite() {
                energy.add(&self.light.differences(self.channels, pixel)[..self.channels.all.len()], noise * noise);
            }
        }
        energy
    }

    fn band(&self, band: usize, width: usize, all: &Energy) -> DecodedBand {
        let first = band * TILE * width;
        let end = (first + TILE * width).min(self.noise.len());
        let mut found = vec![None; end - first];
        let mut tiles = Vec::with_capacity(width.div_ceil(TILE));
        for left in (0..width).step_by(TILE) {
            let right = (left + TILE).min(width);
            let pixels = || (first..end).step_by(width).flat_map(|row| row + left..row + right);
            let energy = self.energy_of(pixels().filter(|pixel| pixel % 3 == 0)).with_prior(all);
            let (level, direct) = self.tables.explain(&energy);
            tiles.push((level, direct));
            let search = TileSearch::new(self, level, direct);
            for pixel in pixels() {
                let noise = self.noise[pixel];
                if noise.is_finite() {
                    let differences = self.light.differences(self.channels, pixel);
                    found[pixel - first] = search.get().find(&differences, noise);
                }
            }
        }
        DecodedBand { found, tiles }
    }

    /// Coordinate and deviation of a pixel, with its neighbours' prediction.
    fn settle(
        &self,
        pixel: usize,
        found: Found,
        prediction: Option<PlanePrediction>,
        tile: (usize, f32),
    ) -> Option<(f32, f32)> {
        let fits = found.misfit < WORST_MISFIT;
        let Some(prediction) = prediction else {
            let is_clear = fits && found.margin > CLEAR_MARGIN && found.sigma < WORST_SIGMA_PX;
            return is_clear.then_some((found.at, found.sigma));
        };
        let allowed = 3.0 * (found.sigma.powi(2) + prediction.sigma.powi(2)).sqrt() + 0.3;
        if fits && (found.at - prediction.at).abs() <= allowed {
            return fuse(found.at, found.sigma, prediction);
        }
        // A place near the prediction may explain the pixel nearly as well.
        let reach = 1.5 + 2.0 * prediction.sigma;
        let differences = self.light.differences(self.channels, pixel);
        let search = TileSearch::new(self, tile.0, tile.1);
        let (low, high) = (prediction.at - reach, prediction.at + reach);
        let again = search.get().find_between(&differences, self.noise[pixel], low, high)?;
        let is_near = (again.at - prediction.at).abs() < reach - 0.3;
        let is_worth = found.explained - again.explained < WORTH_PREDICTING && again.misfit < WORST_MISFIT;
        if is_near && is_worth {
            return fuse(again.at, again.sigma, prediction);
        }
        None
    }
}

/// Search in a tile, with the data that it owns.
struct TileSearch<'a> {
    decoder: &'a AxisDecoder<'a>,
    level: usize,
    visible: [f32; MOST_CHANNELS],
}

impl<'a> TileSearch<'a> {
    fn new(decoder: &'a AxisDecoder<'a>, level: usize, direct: f32) -> Self {
        let mut visible = [0.0; MOST_CHANNELS];
        for (visible, energy) in visible.iter_mut().zip(decoder.tables.energies(level)) {
            *visible = direct * energy.sqrt();
        }
        Self { decoder, level, visible }
    }

    fn get(&self) -> Search<'_> {
        Search {
            channels: self.decoder.channels,
            contrasts: self.decoder.tables.contrasts(self.level),
            blur_px: blur_px(self.level),
            visible: &self.visible,
        }
    }
}

/// Weighted mean of a coordinate and its neighbours' prediction. The window's spread is not divided by its number of
/// pixels, because their errors are correlated; so no coordinate moves by more than its own error.
fn fuse(at: f32, sigma: f32, prediction: PlanePrediction) -> Option<(f32, f32)> {
    let own = 1.0 / (sigma * sigma + 1e-3);
    let others = 1.0 / (prediction.sigma.powi(2) + 0.03 * prediction.spread.powi(2));
    let fused = (own * at + others * prediction.at) / (own + others);
    let deviation = (CAUTION * (1.0 / (own + others)).sqrt()).max(0.02);
    (deviation < WORST_SIGMA_PX).then_some((fused, deviation))
}

/// Share of the lit pixels whose stripes fit no coordinate along an axis.
pub(super) fn contradicted_share(axes: &[SinglePixels; 2], noise: &[f32]) -> f64 {
    let fits =
        |single: &SinglePixels, pixel: usize| single.found[pixel].is_some_and(|found| found.misfit < WORST_MISFIT);
    let lit: Vec<usize> = (0..noise.len()).filter(|pixel| noise[*pixel].is_finite()).collect();
    let count = lit.iter().filter(|pixel| !axes.iter().all(|single| fits(single, **pixel))).count();
    count as f64 / lit.len().max(1) as f64
}
