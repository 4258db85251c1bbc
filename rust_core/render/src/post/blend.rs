//! The share of the light that a projector has where several light one surface.
//!
//! Weights add up to one in linear light. A level v of the image is light v^γ, so that a weight w scales the level by
//! w^(1/γ). Projectors leak light where the image is black, and where several overlap, more of it; so the others are
//! lifted where fewer overlap: light becomes lift + (1 − lift) · w · v^γ.

use super::factors::{scale_row, ONE};
use rcs_scene::Encoding;

/// The most that black is lifted, in linear light: more is a mistake, such as a transparent image.
const MOST_LIFT: f32 = 0.25;

/// Light and lift are fractions of this.
const FULL: f32 = 65535.0;

/// A projector's weights.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Blend {
    size_px: [u32; 2],
    /// What levels are scaled by, for each pixel.
    factors: Vec<u16>,
    /// Empty where nothing is lifted.
    lifted: Vec<Lifted>,
    /// The light of a level, and the level of a light.
    light_of_level: Vec<u16>,
    level_of_light: Vec<u8>,
}

/// Change of a pixel's light, in fractions of 65535.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Lifted {
    lift: u16,
    gain: u16,
}

/// Why weights cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BlendError {
    /// There are more or fewer than pixels.
    #[error("{got} weights for {} pixels", .size_px[0] as usize * .size_px[1] as usize)]
    Size {
        /// Width and height.
        size_px: [u32; 2],
        /// The number of weights.
        got: usize,
    },
    /// A gamma is not a finite number above zero.
    #[error("a gamma of {0}; it is a number above 0, mostly 2.2")]
    Gamma(f32),
    /// Black is lifted by more than a quarter of all light.
    #[error("black is lifted by {percent:.0} % of all light, {} % at most: a picture without transparency has none", 100.0 * MOST_LIFT)]
    Lift {
        /// The share.
        percent: f32,
    },
}

impl Blend {
    /// Weights and lifts in linear light, 0 to 65535 each, row by row; no lifts are none. `gamma` is the projector's.
    ///
    /// # Errors
    /// See [`BlendError`].
    pub fn new(size_px: [u32; 2], weights: &[u16], lifts: &[u16], gamma: f32) -> Result<Self, BlendError> {
        let count = size_px[0] as usize * size_px[1] as usize;
        if weights.len() != count || (!lifts.is_empty() && lifts.len() != count) {
            let got = if weights.len() == count { lifts.len() } else { weights.len() };
            return Err(BlendError::Size { size_px, got });
        }
        if !(gamma.is_finite() && gamma > 0.0) {
            return Err(BlendError::Gamma(gamma));
        }
        let most = f32::from(lifts.iter().max().copied().unwrap_or(0)) / FULL;
        if most > MOST_LIFT {
            return Err(BlendError::Lift { percent: 100.0 * most });
        }
        let level = |light: f32| (light / FULL).powf(1.0 / gamma);
        let factor_of: Vec<u16> =
            (0..=u16::MAX).map(|weight| (level(f32::from(weight)) * f32::from(ONE)).round() as u16).collect();
        let factors =
            weights.iter().map(|weight| factor_of.get(usize::from(*weight)).copied().unwrap_or(ONE)).collect();
        let gain = |weight: u16, lift: u16| (f32::from(weight) * (1.0 - f32::from(lift) / FULL)).round() as u16;
        let lifted = weights.iter().zip(lifts).map(|(weight, lift)| Lifted { lift: *lift, gain: gain(*weight, *lift) });
        let lifted = if most > 0.0 { lifted.collect() } else { Vec::new() };
        let light_of_level = (0..=255_u8).map(|level| ((f32::from(level) / 255.0).powf(gamma) * FULL).round() as u16);
        let level_of_light = (0..=u16::MAX).map(|light| (level(f32::from(light)) * 255.0).round() as u8);
        let (light_of_level, level_of_light) = (light_of_level.collect(), level_of_light.collect());
        Ok(Self { size_px, factors, lifted, light_of_level, level_of_light })
    }

    /// Width and height of the images that it is for.
    pub fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// Alters a row of an image. One of another size becomes black: its weights are not known. `scratch` has a place
    /// for each pixel.
    pub(super) fn apply(
        &self,
        size_px: [u32; 2],
        row: usize,
        encoding: Encoding,
        scratch: &mut [u16],
        bytes: &mut [u8],
    ) {
        let width = self.size_px[0] as usize;
        let pixels = row * width..(row + 1) * width;
        let Some(factors) = self.factors.get(pixels.clone()).filter(|_| size_px == self.size_px) else {
            scratch.fill(0);
            return scale_row(encoding, scratch, bytes);
        };
        match self.lifted.get(pixels).filter(|lifted| lifted.iter().any(|pixel| pixel.lift > 0)) {
            None => scale_row(encoding, factors, bytes),
            Some(lifted) => {
                // What is not lifted is scaled as elsewhere.
                for ((to, factor), lifted) in scratch.iter_mut().zip(factors).zip(lifted) {
                    *to = if lifted.lift > 0 { ONE } else { *factor };
                }
                scale_row(encoding, scratch, bytes);
                self.lift_row(encoding, lifted, bytes);
            }
        }
    }

    fn lift_row(&self, encoding: Encoding, lifted: &[Lifted], bytes: &mut [u8]) {
        let cell = encoding.bytes_per_pixel();
        for (pixel, lifted) in bytes.chunks_exact_mut(cell).zip(lifted).filter(|(_, lifted)| lifted.lift > 0) {
            match pixel {
                // Its levels are those of 8 bits, twice.
                [low, high] => {
                    let level = self.lift(*high, *lifted);
                    (*low, *high) = (level, level);
                }
                pixel => pixel.iter_mut().take(3).for_each(|level| *level = self.lift(*level, *lifted)),
            }
        }
    }

    fn lift(&self, level: u8, Lifted { lift, gain }: Lifted) -> u8 {
        let light = self.light_of_level.get(usize::from(level)).copied().unwrap_or(0);
        let light = u32::from(lift) + (u32::from(gain) * u32::from(light) + 0x8000) / 0xffff;
        self.level_of_light.get(light.min(0xffff) as usize).copied().unwrap_or(u8::MAX)
    }
}
