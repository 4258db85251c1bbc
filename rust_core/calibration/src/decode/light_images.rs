//! Images of a scan in linear light.

use super::channels::{AxisChannels, Channels, MOST_CHANNELS};
use super::response::Response;
use super::search::Differences;
use super::Images;

/// Minimum difference of white and black at a lit pixel: in standard deviations, and in levels.
const LIT_SIGMAS: f32 = 6.0;
const LIT_LEVELS: u8 = 4;
/// Minimum absolute difference of an unambiguous stripe: as a share of white minus black, and in standard deviations.
const CERTAIN: f32 = 0.35;
const CERTAIN_SIGMAS: f32 = 6.0;

/// Images of a scan in linear light.
#[derive(Clone, Copy)]
pub(super) struct LightImages<'a> {
    pub(super) images: &'a Images<'a>,
    pub(super) channels: &'a Channels,
    pub(super) response: &'a Response,
}

impl LightImages<'_> {
    /// Linear light of an image at a pixel.
    #[inline]
    pub(super) fn at(&self, image: usize, pixel: usize) -> f32 {
        self.response.light(self.images.levels[image][pixel])
    }

    /// Standard deviations of the pixels' normalised differences; infinite where not lit.
    pub(super) fn noise(&self) -> Vec<f32> {
        let (white, black) = (self.images.levels[self.channels.white], self.images.levels[self.channels.black]);
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

    /// Share of the lit pixels whose unambiguous stripes lead beyond the projector's image.
    pub(super) fn share_beyond(&self, channels: &AxisChannels, size_px: u32, noise: &[f32]) -> f64 {
        let Some(coarse) = channels.all.first() else { return 0.0 };
        let last_px = i64::from(size_px) + i64::from(coarse.stripes.step);
        let (mut lit, mut beyond) = (0_usize, 0_usize);
        for (pixel, noise) in noise.iter().enumerate().step_by(7).filter(|(_, noise)| noise.is_finite()) {
            lit += 1;
            beyond += usize::from(least_place_px(channels, &self.differences(channels, pixel), *noise) > last_px);
        }
        beyond as f64 / lit.max(1) as f64
    }

    /// White minus black at each pixel.
    pub(super) fn amplitudes(&self) -> Vec<f32> {
        let Channels { white, black, .. } = *self.channels;
        (0..self.images.levels[white].len()).map(|pixel| self.at(white, pixel) - self.at(black, pixel)).collect()
    }

    /// Normalised differences of a lit pixel.
    #[inline]
    pub(super) fn differences(&self, channels: &AxisChannels, pixel: usize) -> Differences {
        let scale = 1.0 / (self.at(self.channels.white, pixel) - self.at(self.channels.black, pixel));
        let mut differences = [0.0; MOST_CHANNELS];
        for (difference, channel) in differences.iter_mut().zip(&channels.all) {
            *difference = (self.at(channel.lit, pixel) - self.at(channel.inverse, pixel)) * scale;
        }
        differences
    }
}

/// Lower bound of a pixel's coordinate by its unambiguous stripes, projector pixels. Beyond the image, the patterns are
/// those of another projector size, or their list is wrong.
fn least_place_px(channels: &AxisChannels, differences: &Differences, noise: f32) -> i64 {
    let code = channels.all.iter().take(channels.code_bits);
    let certain = code.zip(differences).take_while(|(_, difference)| {
        let strength = difference.abs();
        strength > CERTAIN && strength > CERTAIN_SIGMAS * noise
    });
    let (mut place_px, mut is_one) = (0, false);
    for (channel, difference) in certain {
        let stripes = &channel.stripes;
        // A Gray code's bit tells whether the binary digit differs from the one before.
        is_one ^= *difference > 0.0;
        let digit = stripes.bits.saturating_sub(stripes.bit + 1).min(40);
        place_px += (i64::from(is_one) << digit) * i64::from(stripes.step);
        if stripes.bit == 0 {
            place_px -= i64::from(stripes.offset);
        }
    }
    place_px
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patterns::{shifted_gray_code, Pattern};

    #[test]
    fn unambiguous_stripes_bound_the_coordinate_from_below() {
        for step in [1, 4] {
            let patterns = shifted_gray_code([1280, 800], step);
            let channels = Channels::new(&patterns).unwrap();
            let axis = &channels.axes[0];
            for u in [0, 1, 5, 639, 640, 1277, 1279] {
                let mut differences = [0.0; MOST_CHANNELS];
                for (difference, channel) in differences.iter_mut().zip(&axis.all) {
                    let is_lit = Pattern::GrayCode(channel.stripes).is_lit(u, 0);
                    *difference = if is_lit { 0.9 } else { -0.9 };
                }
                let whole = least_place_px(axis, &differences, 0.01);
                assert!((0..i64::from(step)).contains(&(i64::from(u) - whole)), "{u}: {whole}");
                // With the fine stripes blurred away, it is less.
                differences[4..].fill(0.1);
                let coarse = least_place_px(axis, &differences, 0.01);
                assert!(coarse <= whole && whole - coarse < 128, "{u}: {coarse}");
                assert_eq!(least_place_px(axis, &differences, 1.0), 0, "nothing is certain");
            }
        }
    }
}
