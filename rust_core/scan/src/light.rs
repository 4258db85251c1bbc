//! The camera pixels that the projector lights, and what they tell of its light: delay, noise, exposure, contrast.

use std::time::Duration;

use crate::compare::{mean, sample, CLIPPED};
use crate::failure::ScanFailure;

/// A lit pixel is brighter in white than in black by so many levels, and by so many times the noise.
const LIT_LEVELS: f64 = 6.0;
const LIT_NOISE: f64 = 3.0;
/// The share of the picture that must be lit.
pub(crate) const LEAST_LIT: f64 = 0.005;
/// Brightness that changes by more than this share of the projector's light is not steady.
pub(crate) const MOST_CHANGE: f64 = 0.06;
/// Above the first share of clipped lit pixels there is a warning, above the other the scan is refused.
const MUCH_CLIPPED: f64 = 0.02;
const MOST_CLIPPED: f64 = 0.25;
/// Below this contrast of white and black, levels, there is a warning.
const LITTLE_LIGHT: f64 = 20.0;

/// How long it takes from showing a picture to seeing it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Delay {
    /// Until half of the light is seen.
    pub seen: Duration,
    /// Until nothing changes any more.
    pub settled: Duration,
}

/// What the first look tells.
#[derive(Debug)]
pub(crate) struct Light {
    /// The delay, the longest of all that were measured.
    pub(crate) delay: Delay,
    /// Camera pixels that the projector lights: a sample of them.
    pub(crate) lit: Vec<usize>,
    /// How much two frames at rest differ at these: root mean square, levels.
    pub(crate) noise: f64,
    /// The share of these that is clipped in white.
    pub(crate) clipped: f64,
    /// By how many levels white is brighter than black at these.
    pub(crate) contrast: f64,
}

impl Light {
    /// What pictures of white and black tell that were not watched live: the delay is none. `noise` is the difference
    /// of two frames at rest, `screen` what a message calls where they were shown.
    ///
    /// # Errors
    /// [`ScanFailure::NoLight`] and [`ScanFailure::Overexposed`].
    pub(crate) fn of_pictures(
        dark: &[u8],
        white: &[u8],
        camera_px: [u32; 2],
        noise: f64,
        screen: &str,
    ) -> Result<Self, ScanFailure> {
        let all = sample(camera_px);
        let lit = lit_pixels(dark, white, &all, noise);
        if (lit.len() as f64) < LEAST_LIT * all.len() as f64 {
            return Err(ScanFailure::NoLight { screen: screen.to_owned() });
        }
        let clipped = clipped_share(white, &lit)?;
        let contrast = mean(white, &lit) - mean(dark, &lit);
        Ok(Self { delay: Delay::default(), lit, noise, clipped, contrast })
    }

    /// What is not as it should be and no reason to give up.
    pub(crate) fn warnings(&self) -> Vec<String> {
        let much = self
            .is_overexposed()
            .then(|| format!("{:.0} % of the lit pixels are overexposed: shorten the exposure", 100.0 * self.clipped));
        let little = (self.contrast < LITTLE_LIGHT).then(|| {
            format!(
                "the projector's light raises the camera's levels by only {:.0} of 255: darken the room or lengthen \
                 the exposure",
                self.contrast
            )
        });
        much.into_iter().chain(little).collect()
    }

    /// Whether the first of these is among them.
    pub(crate) fn is_overexposed(&self) -> bool {
        self.clipped > MUCH_CLIPPED
    }
}

/// Those of some pixels that are brighter in white than in black.
pub(crate) fn lit_pixels(dark: &[u8], white: &[u8], at: &[usize], noise: f64) -> Vec<usize> {
    let limit = LIT_LEVELS.max(LIT_NOISE * noise);
    at.iter().copied().filter(|pixel| f64::from(white[*pixel]) - f64::from(dark[*pixel]) > limit).collect()
}

/// The share of clipped pixels among the lit ones.
///
/// # Errors
/// [`ScanFailure::Overexposed`].
pub(crate) fn clipped_share(white: &[u8], lit: &[usize]) -> Result<f64, ScanFailure> {
    let clipped = lit.iter().filter(|pixel| white[**pixel] == CLIPPED).count() as f64 / lit.len().max(1) as f64;
    if clipped > MOST_CLIPPED {
        return Err(ScanFailure::Overexposed { clipped });
    }
    Ok(clipped)
}

/// The mean of frames of one size, rounded.
pub(crate) fn average<'a>(frames: impl ExactSizeIterator<Item = &'a Vec<u8>> + Clone) -> Vec<u8> {
    let count = frames.len().max(1) as u32;
    let mut sums = vec![0_u32; frames.clone().next().map_or(0, Vec::len)];
    for frame in frames {
        sums.iter_mut().zip(frame).for_each(|(sum, level)| *sum += u32::from(*level));
    }
    sums.into_iter().map(|sum| ((sum + count / 2) / count) as u8).collect()
}
