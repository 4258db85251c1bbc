//! Decoding: from the pictures of a scan to the projector pixel that lights each camera pixel.
//!
//! - [`response`]: the camera's gamma and noise, from the capture itself.
//! - [`quality`]: whether the pictures belong together.
//! - [`order`]: whether each is the one that the list says.
//! - [`range`]: whether they are those of this projector.
//! - [`blur`]: how blurred the stripes are in each tile.
//! - [`search`]: each pixel's place along each axis, by comparing what it saw with blurred stripes.
//! - [`bleeding`]: how far the camera's blur has pulled each pixel towards the light.
//! - [`neighbours`]: what a surface's pixels tell of one another; a pixel that contradicts all of its own is looked up
//!   again near the predicted place, or dropped.
//! - [`margins`]: pixels that see two surfaces, or stray light, are dropped.

mod bleeding;
mod blur;
pub(crate) mod channels;
mod exposure;
mod margins;
mod neighbours;
mod order;
mod quality;
mod range;
pub(crate) mod response;
mod search;
mod stripes;

pub use order::{PictureFault, WrongPicture};
pub use quality::{Quality, ScanProblem};

use rayon::prelude::*;

use crate::patterns::Pattern;
use bleeding::Gradients;
use blur::{Energy, Tables, COARSE_FROM_PX};
use channels::{AxisChannels, Channel, Channels, MOST_CHANNELS};
use margins::{without_bleeding, without_margins};
use neighbours::{Field, Prediction};
use order::Order;
use range::least_place_px;
use response::Response;
use search::{Differences, Found, Search};

/// Sides of the tiles with a blur of their own, camera pixels.
const TILE: usize = 32;
/// A pixel is lit if white is brighter than black by so many standard deviations,
const LIT_SIGMAS: f32 = 6.0;
/// and by so many levels.
const LIT_LEVELS: u8 = 4;
/// A pixel whose differences are explained worse than this is not decoded: mean square over the expected variance.
const WORST_MISFIT: f32 = 25.0;
/// A pixel without neighbours is kept if the next best place is so much worse.
const CLEAR_MARGIN: f32 = 40.0;
/// How much worse, at most, a place near the prediction may explain a pixel than its best place does.
const WORTH_PREDICTING: f32 = 16.0;
/// Both weights count what stripes and planes leave unexplained; of what they say together, so much is true of
/// simulated scans, in the middle.
const CAUTION: f32 = 0.65;
/// The largest deviation of a decoded coordinate, projector pixels.
const WORST_SIGMA_PX: f32 = 1.0;

/// The pictures of a scan.
#[derive(Debug, Clone)]
pub struct Pictures<'a> {
    /// Width and height of the camera's pictures, pixels.
    pub size_px: [u32; 2],
    /// What the projector showed in each picture.
    pub patterns: &'a [Pattern],
    /// The pictures in the order of the patterns: grey levels, row by row from the top.
    pub levels: Vec<&'a [u8]>,
}

/// Why a scan cannot be decoded.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DecodeError {
    /// A picture that is needed.
    #[error("{0} is missing")]
    Missing(&'static str),
    /// Stripes without their inverse.
    #[error("bit {bit} of the stripes along {axis} has no inverse")]
    NoInverse {
        /// `x` or `y`.
        axis: &'static str,
        /// The bit, 0 is the most significant.
        bit: u32,
    },
    /// A bit of the code that localises is missing although a finer one is there.
    #[error("bit {bit} of the code along {axis} is missing")]
    MissingBit {
        /// `x` or `y`.
        axis: &'static str,
        /// The bit, 0 is the most significant.
        bit: u32,
    },
    /// The code has fewer values than the projector has columns or rows.
    #[error("the code along {axis} has {codes} values, too few for the {size_px} pixels of the projector: is it of another size?")]
    ShortCode {
        /// `x` or `y`.
        axis: &'static str,
        /// How many values it has.
        codes: u64,
        /// How many pixels the projector has along the axis.
        size_px: u32,
    },
    /// No stripes, or not the most significant bit.
    #[error("no code along {0}: its most significant bit is missing")]
    NoCode(&'static str),
    /// More stripes than can be used.
    #[error("{count} different stripes along {axis}, at most {most} can be used")]
    TooMany {
        /// `x` or `y`.
        axis: &'static str,
        /// How many there are.
        count: usize,
        /// How many can be used.
        most: usize,
    },
    /// The size of a picture is not that of the others.
    #[error("picture {index} has {count} pixels, not {expected}")]
    Size {
        /// The picture's index.
        index: usize,
        /// How many pixels it has.
        count: usize,
        /// How many it should have.
        expected: usize,
    },
    /// There are not as many pictures as patterns.
    #[error("{pictures} pictures of {patterns} patterns")]
    Count {
        /// The number of pictures.
        pictures: usize,
        /// The number of patterns.
        patterns: usize,
    },
}

/// Which projector pixel lights a camera pixel; all four are NaN where that is not known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DecodedPixel {
    /// The projector's column and row, with fractions.
    pub at: [f32; 2],
    /// Their standard deviations, projector pixels.
    pub sigma: [f32; 2],
}

impl DecodedPixel {
    /// Nothing is known.
    pub const NONE: Self = Self { at: [f32::NAN; 2], sigma: [f32::NAN; 2] };

    /// Whether something is known.
    pub fn is_decoded(&self) -> bool {
        !self.at[0].is_nan()
    }
}

/// What a scan tells.
#[derive(Debug, Clone)]
pub struct Decoded {
    /// Width and height of the camera's pictures, pixels.
    pub size_px: [u32; 2],
    /// All camera pixels, row by row from the top.
    pub pixels: Vec<DecodedPixel>,
    /// How many camera pixels the projector lights.
    pub lit: usize,
    /// How the scan was taken.
    pub quality: Quality,
}

impl Decoded {
    /// How many pixels were decoded.
    pub fn count(&self) -> usize {
        self.pixels.iter().filter(|pixel| pixel.is_decoded()).count()
    }
}

/// Finds which pixel of a projector of this size lights each camera pixel.
///
/// # Errors
/// [`DecodeError`]: pictures are missing, or are of different sizes.
pub fn decode(pictures: &Pictures<'_>, projector_px: [u32; 2]) -> Result<Decoded, DecodeError> {
    let expected = pictures.size_px[0] as usize * pictures.size_px[1] as usize;
    if pictures.levels.len() != pictures.patterns.len() {
        return Err(DecodeError::Count { pictures: pictures.levels.len(), patterns: pictures.patterns.len() });
    }
    if let Some(index) = pictures.levels.iter().position(|levels| levels.len() != expected) {
        return Err(DecodeError::Size { index, count: pictures.levels[index].len(), expected });
    }
    let channels = Channels::new(pictures.patterns)?;
    channels.check_size(projector_px)?;
    let steadied = exposure::steadied(pictures, &channels);
    let steady_pictures = steadied.as_ref().map(|steadied| steadied.pictures(pictures));
    let pictures = steady_pictures.as_ref().unwrap_or(pictures);
    let response = Response::find(pictures, &channels);
    let lights = Lights { pictures, channels: &channels, response: &response };
    let noise = lights.noise();
    let order = Order { pictures, channels: &channels, response: &response, noise: &noise };
    let mut quality = Quality::measure(&order);
    quality.exposure_change = quality.exposure_change.max(steadied.as_ref().map_or(0.0, |steadied| steadied.change));
    quality.beyond = [0, 1].map(|axis| lights.share_beyond(&channels.axes[axis], projector_px[axis], &noise));
    let lit = noise.iter().filter(|noise| noise.is_finite()).count();
    let amplitudes = lights.amplitudes();
    let width = pictures.size_px[0] as usize;
    let gradients = Gradients::new(&amplitudes, width);
    let tables = [0, 1].map(|axis| Tables::new(&channels.axes[axis], projector_px[axis]));
    let decoders = [0, 1].map(|axis| AxisDecoder {
        lights: &lights,
        noise: &noise,
        channels: &channels.axes[axis],
        tables: &tables[axis],
    });
    let mut single = decoders.each_ref().map(AxisDecoder::decode_single);
    let by_stripes = Gradients::new(&lights.amplitudes_of_stripes(&noise), width);
    let blur_variance =
        bleeding::blur_variance([&gradients, &by_stripes], single.each_ref().map(|single| &single.field));
    single.iter_mut().for_each(|single| single.push_back(&gradients.pulls(&single.field, blur_variance)));
    let [along_x, along_y] = [0, 1].map(|axis| decoders[axis].decode_together(&single[axis]));
    let pixels: Vec<DecodedPixel> = (0..expected)
        .map(|pixel| {
            let sigma = [along_x.sigma[pixel], along_y.sigma[pixel]];
            if sigma.iter().all(|sigma| sigma.is_finite()) {
                DecodedPixel { at: [along_x.at[pixel], along_y.at[pixel]], sigma }
            } else {
                DecodedPixel::NONE
            }
        })
        .collect();
    quality.wrong_picture = quality.wrong_picture.or_else(|| order::turned(&pixels, width, &channels));
    quality.contradicted = contradicted_share(&single, &noise);
    let pixels = without_margins(&pixels, width);
    let pixels = without_bleeding(&pixels, &amplitudes, width);
    Ok(Decoded { size_px: pictures.size_px, pixels, lit, quality })
}

/// The share of the lit pixels whose stripes fit no place along an axis.
fn contradicted_share(axes: &[Single; 2], noise: &[f32]) -> f64 {
    let fits = |single: &Single, pixel: usize| single.found[pixel].is_some_and(|found| found.misfit < WORST_MISFIT);
    let lit: Vec<usize> = (0..noise.len()).filter(|pixel| noise[*pixel].is_finite()).collect();
    let count = lit.iter().filter(|pixel| !axes.iter().all(|single| fits(single, **pixel))).count();
    count as f64 / lit.len().max(1) as f64
}

/// The pictures in linear light.
struct Lights<'a> {
    pictures: &'a Pictures<'a>,
    channels: &'a Channels,
    response: &'a Response,
}

impl Lights<'_> {
    /// For each pixel the standard deviation of its normalised differences; infinite where it is not lit.
    fn noise(&self) -> Vec<f32> {
        let (white, black) = (self.pictures.levels[self.channels.white], self.pictures.levels[self.channels.black]);
        let noise = |(white, black): (&u8, &u8)| {
            let (light, dark) = (self.response.light(*white), self.response.light(*black));
            let deviation = self.response.difference_variance(light + dark).sqrt();
            let is_lit = light - dark > LIT_SIGMAS * deviation && white.saturating_sub(*black) >= LIT_LEVELS;
            if is_lit {
                deviation / (light - dark)
            } else {
                f32::INFINITY
            }
        };
        white.iter().zip(black).map(noise).collect()
    }

    /// The share of the lit pixels whose certain stripes lead beyond the projector's picture.
    fn share_beyond(&self, channels: &AxisChannels, size_px: u32, noise: &[f32]) -> f64 {
        let Some(coarse) = channels.all.first() else { return 0.0 };
        let last_px = i64::from(size_px) + i64::from(coarse.stripes.step);
        let (mut lit, mut beyond) = (0_usize, 0_usize);
        for (pixel, noise) in noise.iter().enumerate().step_by(7).filter(|(_, noise)| noise.is_finite()) {
            lit += 1;
            beyond += usize::from(least_place_px(channels, &self.differences(channels, pixel), *noise) > last_px);
        }
        beyond as f64 / lit.max(1) as f64
    }

    /// The light of white less that of black, for each pixel.
    fn amplitudes(&self) -> Vec<f32> {
        let (white, black) = (self.pictures.levels[self.channels.white], self.pictures.levels[self.channels.black]);
        white
            .iter()
            .zip(black)
            .map(|(white, black)| self.response.light(*white) - self.response.light(*black))
            .collect()
    }

    /// The same as the stripes tell it, without white and black: the median of coarse stripes against their inverses,
    /// few of which have an edge near a pixel. 0 where the projector lights nothing.
    fn amplitudes_of_stripes(&self, noise: &[f32]) -> Vec<f32> {
        let is_coarse = |channel: &&Channel| channel.stripes.width_px() >= COARSE_FROM_PX;
        let coarse: Vec<&Channel> =
            self.channels.axes.iter().flat_map(|axis| axis.all.iter().filter(is_coarse)).collect();
        let levels = &self.pictures.levels;
        let amplitude = |(pixel, noise): (usize, &f32)| {
            if !noise.is_finite() || coarse.is_empty() {
                return 0.0;
            }
            let light = |picture: usize| self.response.light(levels[picture][pixel]);
            let mut seen = [0.0; 2 * MOST_CHANNELS];
            let seen = &mut seen[..coarse.len()];
            for (seen, channel) in seen.iter_mut().zip(&coarse) {
                *seen = (light(channel.lit) - light(channel.inverse)).abs();
            }
            *seen.select_nth_unstable_by(coarse.len() / 2, f32::total_cmp).1
        };
        noise.par_iter().enumerate().map(amplitude).collect()
    }

    /// The differences of a lit pixel.
    #[inline]
    fn differences(&self, channels: &AxisChannels, pixel: usize) -> Differences {
        let levels = &self.pictures.levels;
        let light = |picture: usize| self.response.light(levels[picture][pixel]);
        let scale = 1.0 / (light(self.channels.white) - light(self.channels.black));
        let mut differences = [0.0; MOST_CHANNELS];
        for (difference, channel) in differences.iter_mut().zip(&channels.all) {
            *difference = (light(channel.lit) - light(channel.inverse)) * scale;
        }
        differences
    }
}

/// Decodes one axis.
struct AxisDecoder<'a> {
    lights: &'a Lights<'a>,
    noise: &'a [f32],
    channels: &'a AxisChannels,
    tables: &'a Tables<'a>,
}

/// What one band of tiles yields.
struct Band {
    found: Vec<Option<Found>>,
    /// The level of blur and the share of direct light of each tile.
    tiles: Vec<(usize, f32)>,
}

/// What the pixels of an axis tell, each for itself.
struct Single {
    found: Vec<Option<Found>>,
    /// The level of blur and the share of direct light of each tile, band by band.
    tiles: Vec<Vec<(usize, f32)>>,
    /// The places of those that are sure.
    field: Field,
}

impl Single {
    /// Takes back how far each pixel was pulled, projector pixels.
    fn push_back(&mut self, pulls: &[f32]) {
        for ((at, found), pull) in self.field.at.iter_mut().zip(&mut self.found).zip(pulls) {
            if let Some(found) = found {
                found.at -= pull;
                *at = found.at;
            }
        }
    }
}

impl AxisDecoder<'_> {
    /// Decodes each pixel for itself.
    fn decode_single(&self) -> Single {
        let width = self.lights.pictures.size_px[0] as usize;
        let all = self.energy_of((0..self.noise.len()).step_by(13));
        let bands = self.noise.len().div_ceil(width * TILE);
        let bands: Vec<Band> = (0..bands).into_par_iter().map(|band| self.band(band, width, &all)).collect();
        let found: Vec<Option<Found>> = bands.iter().flat_map(|band| band.found.iter().copied()).collect();
        let is_sure = |found: &Found| found.misfit < WORST_MISFIT && found.sigma < 3.0;
        let field = Field {
            width,
            at: found.iter().map(|found| found.map_or(0.0, |found| found.at)).collect(),
            sigma: found.iter().map(|found| found.filter(is_sure).map_or(f32::INFINITY, |found| found.sigma)).collect(),
        };
        Single { found, tiles: bands.into_iter().map(|band| band.tiles).collect(), field }
    }

    /// Decides on each pixel's place with what its neighbours tell.
    fn decode_together(&self, single: &Single) -> Field {
        let Single { found, tiles, field } = single;
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
                energy.add(&self.lights.differences(self.channels, pixel)[..self.channels.all.len()], noise * noise);
            }
        }
        energy
    }

    /// All pixels of a band of tiles.
    fn band(&self, band: usize, width: usize, all: &Energy) -> Band {
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
                    let differences = self.lights.differences(self.channels, pixel);
                    found[pixel - first] = search.get().find(&differences, noise);
                }
            }
        }
        Band { found, tiles }
    }

    /// Decides on a pixel's place and its deviation, with what its neighbours predict.
    fn settle(
        &self,
        pixel: usize,
        found: Found,
        prediction: Option<Prediction>,
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
        // Another place near the prediction may explain the pixel nearly as well.
        let reach = 1.5 + 2.0 * prediction.sigma;
        let differences = self.lights.differences(self.channels, pixel);
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

/// A tile's search, which owns what it needs.
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
            blur_px: stripes::blur_px(self.level),
            visible: &self.visible,
        }
    }
}

/// A place and what neighbours predict, each by its weight. The window's spread counts whole, because its pixels share
/// errors; so a place is never moved by more than it may be wrong.
fn fuse(at: f32, sigma: f32, prediction: Prediction) -> Option<(f32, f32)> {
    let own = 1.0 / (sigma * sigma + 1e-3);
    let others = 1.0 / (prediction.sigma.powi(2) + 0.03 * prediction.spread.powi(2));
    let fused = (own * at + others * prediction.at) / (own + others);
    let deviation = (CAUTION * (1.0 / (own + others)).sqrt()).max(0.02);
    (deviation < WORST_SIGMA_PX).then_some((fused, deviation))
}
