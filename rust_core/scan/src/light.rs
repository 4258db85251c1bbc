//! The camera pixels that the projector lights, and their delay, noise, exposure and contrast.

use std::time::Duration;

use crate::compare::{mean, sample, CLIPPED};
use crate::failure::ScanFailure;

/// A lit pixel is brighter in white than in black by this number of levels, and this multiple of the noise.
const LIT_LEVELS: f64 = 6.0;
const LIT_NOISE: f64 = 3.0;
/// The share of the image that must be lit.
pub(crate) const MIN_LIT: f64 = 0.005;
/// Limit of a change of brightness, as a share of the projector's light.
pub(crate) const MAX_CHANGE: f64 = 0.06;
/// Shares of clipped lit pixels for a warning, and for a refusal to measure spots.
const WARN_CLIPPED: f64 = 0.02;
const MAX_CLIPPED: f64 = 0.25;
/// Contrast of white and black below which there is a warning, levels.
const WARN_CONTRAST: f64 = 20.0;

/// The delay from showing an image to seeing it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Delay {
    /// The time until half of the light is seen.
    pub seen: Duration,
    /// The time until nothing changes any more.
    pub settled: Duration,
}

/// The projector's light in the camera's image.
#[derive(Debug)]
pub(crate) struct Illumination {
    /// The longest measured delay.
    pub(crate) delay: Delay,
    /// A sample of the camera pixels that the projector lights.
    pub(crate) lit: Vec<usize>,
    /// The difference of two frames of the same image at these, root mean square, levels.
    pub(crate) noise: f64,
    /// The share of these that is clipped in white.
    pub(crate) clipped: f64,
    /// The mean difference of white and black at these, levels.
    pub(crate) contrast: f64,
}

impl Illumination {
    /// From images of white and black; the delay is zero. `noise` is the difference of two frames of the same image,
    /// `screen` the screen's name in messages.
    ///
    /// # Errors
    /// [`ScanFailure::NoLight`].
    pub(crate) fn of_images(
        black: &[u8],
        white: &[u8],
        camera_px: [u32; 2],
        noise: f64,
        screen: &str,
    ) -> Result<Self, ScanFailure> {
        let all = sample(camera_px);
        let lit = lit_pixels(black, white, &all, noise);
        if (lit.len() as f64) < MIN_LIT * all.len() as f64 {
            return Err(ScanFailure::NoLight(screen.to_owned()));
        }
        let clipped = clipped_share(white, &lit);
        let contrast = mean(white, &lit) - mean(black, &lit);
        Ok(Self { delay: Delay::default(), lit, noise, clipped, contrast })
    }

    /// Passes on warnings of the exposure.
    pub(crate) fn warn(&self, warn: &mut dyn FnMut(&str)) {
        if self.is_overexposed() {
            let percent = 100.0 * self.clipped;
            warn(&format!("{percent:.0} % of the lit pixels are overexposed: shorten the exposure"));
        }
        if self.contrast < WARN_CONTRAST {
            warn(&format!(
                "the projector's light raises the camera's levels by only {:.0} of 255: darken the room or lengthen \
                 the exposure",
                self.contrast
            ));
        }
    }

    /// Refuses an exposure at which spots cannot be measured. Stripes can still be decoded, which judges that itself.
    ///
    /// # Errors
    /// [`ScanFailure::Overexposed`].
    pub(crate) fn check_exposure(&self) -> Result<(), ScanFailure> {
        if self.clipped > MAX_CLIPPED {
            return Err(ScanFailure::Overexposed(self.clipped));
        }
        Ok(())
    }

    /// `true` if there is a warning of overexposure.
    pub(crate) fn is_overexposed(&self) -> bool {
        self.clipped > WARN_CLIPPED
    }
}

/// The pixels among `at` that are brighter in white than in black.
pub(crate) fn lit_pixels(black: &[u8], white: &[u8], at: &[usize], noise: f64) -> Vec<usize> {
    let limit = LIT_LEVELS.max(LIT_NOISE * noise);
    at.iter().copied().filter(|pixel| f64::from(white[*pixel]) - f64::from(black[*pixel]) > limit).collect()
}

/// The share of clipped pixels among the lit ones.
pub(crate) fn clipped_share(white: &[u8], lit: &[usize]) -> f64 {
    lit.iter().filter(|pixel| white[**pixel] == CLIPPED).count() as f64 / lit.len().max(1) as f64
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spots_are_not_measured_where_much_is_clipped() {
        let light =
            |clipped| Illumination { delay: Delay::default(), lit: Vec::new(), noise: 0.0, clipped, contrast: 99.0 };
        assert!(light(0.2).check_exposure().is_ok());
        assert!(matches!(light(0.3).check_exposure(), Err(ScanFailure::Overexposed(_))));
    }
}
