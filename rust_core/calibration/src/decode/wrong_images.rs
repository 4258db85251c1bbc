//! Detection of wrong images: a lagging camera, or an image taken twice, puts another pattern's image in a pattern's
//! place. It and its inverse then do not add up to white and black ([`ImageCheck::unpaired`]), or fine stripes are lit
//! and dark where those of another bit are ([`ImageCheck::alike`]). What remains is for [`super::order`].

use super::channels::{Channels, StripeChannel};
use super::light_images::LightImages;
use super::response::CLIPPED_FROM;
use crate::patterns::Stripes;

/// Maximum number of sampled pixels.
const SAMPLED: usize = 150_000;
/// Maximum distance of stripes plus their inverse from white plus black, as a share of the projector's light. However
/// little a camera resolves of fine stripes, they add up.
const UNPAIRED: f32 = 0.4;
/// Maximum noise of sampled pixels, as a share of the projector's light.
const MOST_NOISE: f32 = 0.05;
/// Maximum share of pixels whose stripes and inverse do not add up.
const MANY_UNPAIRED: f64 = 0.15;
/// Maximum mean difference of equal images, as a share of the projector's light.
const SAME: f32 = 0.04;
/// Minimum difference of a certain bit, as a share of white minus black.
const CERTAIN: f32 = 0.35;
/// First fine bit: from here on, different bits agree at half of the pixels, like noise.
const FIRST_FINE_BIT: usize = 4;
/// Minimum agreement of equal bits where both are certain, and minimum share of such pixels.
const AGREEING: f64 = 0.9;
const COMPARABLE: f64 = 0.05;
/// Number of pixels for comparing bits.
const COMPARED: usize = 20_000;
/// Width below which stripes may be too fine for a camera, projector pixels.
const FINE_PX: f64 = 16.0;

/// Image that shows another pattern than listed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WrongImage {
    /// Listed stripes.
    pub stripes: Stripes,
    /// Fault.
    pub fault: ImageFault,
}

/// Fault of an image. Numbers are indices of images.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImageFault {
    /// The first image is a copy of the second.
    Copy([usize; 2]),
    /// The images are not each other's inverse.
    NoInverse([usize; 2]),
    /// Two bits' images show the same bit; which one is unknown.
    Alike([usize; 2], Stripes),
}

impl WrongImage {
    /// Describes the fault with the images' names.
    pub fn describe(&self, name: impl Fn(usize) -> String) -> String {
        let bit_of = |stripes: &Stripes| format!("bit {} along {}", stripes.bit, stripes.axis.name());
        let said = bit_of(&self.stripes);
        let (ImageFault::Copy(images) | ImageFault::NoInverse(images) | ImageFault::Alike(images, _)) = self.fault;
        let [one, other] = images.map(name);
        let fault = match &self.fault {
            ImageFault::Copy(_) => format!("{one} shows the same as {other}, not the stripes of {said}"),
            ImageFault::NoInverse(_) => {
                format!("{one} and {other} are not each other's inverse, as those of {said} are")
            }
            ImageFault::Alike(_, also) => {
                format!("{one} and {other} show the same, not the stripes of {said} and of {}", bit_of(also))
            }
        };
        let too_fine = if self.stripes.width_px() < FINE_PX {
            ", or the stripes are too fine for the camera, which a larger --step mends"
        } else {
            ""
        };
        format!(
            "{fault}: the camera lagged, or a picture was taken twice{too_fine}; show each pattern longer, and scan \
             again"
        )
    }
}

fn pair(channel: &StripeChannel) -> [usize; 2] {
    [channel.lit, channel.inverse]
}

/// Check of a scan for wrong images.
pub(super) struct ImageCheck<'a> {
    pub(super) light: &'a LightImages<'a>,
    /// Standard deviations of the pixels' differences, as shares of the projector's light.
    pub(super) noise: &'a [f32],
}

impl ImageCheck<'_> {
    pub(super) fn wrong_image(&self) -> Option<WrongImage> {
        self.unpaired().or_else(|| self.alike())
    }

    /// Indices of at most [`SAMPLED`] pixels with little noise.
    fn sample(&self) -> Vec<usize> {
        let is_clear = |pixel: &usize| self.noise[*pixel] < MOST_NOISE;
        let clear: Vec<usize> = (0..self.noise.len()).filter(is_clear).collect();
        clear.iter().copied().step_by(clear.len().div_ceil(SAMPLED).max(1)).collect()
    }

    /// Light of an image at a pixel: 0 for black, 1 for white.
    fn share(&self, image: usize, pixel: usize) -> f32 {
        let Channels { white, black, .. } = *self.light.channels;
        let [white, black] = [white, black].map(|image| self.light.at(image, pixel));
        (self.light.at(image, pixel) - black) / (white - black)
    }

    /// Finds stripes that do not match their inverse.
    fn unpaired(&self) -> Option<WrongImage> {
        let sample = self.sample();
        let is_unpaired = |channel: &StripeChannel, pixel: usize| {
            let sum: f32 = pair(channel).iter().map(|image| self.share(*image, pixel)).sum();
            let is_clipped = [channel.lit, channel.inverse, self.light.channels.white]
                .iter()
                .any(|image| self.light.images.levels[*image][pixel] >= CLIPPED_FROM);
            sum < 1.0 - UNPAIRED || (!is_clipped && sum > 1.0 + UNPAIRED)
        };
        let worst = self.light.channels.axes.iter().flat_map(|axis| &axis.all).map(|channel| {
            let unpaired = sample.iter().filter(|pixel| is_unpaired(channel, **pixel)).count();
            (unpaired as f64 / sample.len().max(1) as f64, channel)
        });
        let (share, channel) = worst.max_by(|one, other| one.0.total_cmp(&other.0))?;
        (share > MANY_UNPAIRED).then(|| {
            let twins = pair(channel).map(|image| self.twin(image, channel, &sample).map(|twin| [image, twin]));
            let fault = match twins {
                [Some(copy), None] | [None, Some(copy)] => ImageFault::Copy(copy),
                _ => ImageFault::NoInverse(pair(channel)),
            };
            WrongImage { stripes: channel.stripes, fault }
        })
    }

    /// Equal image of another pair.
    fn twin(&self, image: usize, channel: &StripeChannel, sample: &[usize]) -> Option<usize> {
        let every = (sample.len() / 5000).max(1);
        let difference = |other: usize| {
            let pixels = sample.iter().step_by(every);
            let sum: f32 = pixels.map(|pixel| (self.share(image, *pixel) - self.share(other, *pixel)).abs()).sum();
            sum * every as f32 / sample.len().max(1) as f32
        };
        let others = (0..self.light.images.levels.len()).filter(|other| !pair(channel).contains(other));
        let nearest = others.map(|other| (difference(other), other)).min_by(|one, other| one.0.total_cmp(&other.0))?;
        (nearest.0 < SAME).then_some(nearest.1)
    }

    /// Bits of both axes, each axis from the coarsest on.
    fn bits(&self) -> Vec<&StripeChannel> {
        let axes = self.light.channels.axes.iter();
        axes.flat_map(|axis| &axis.all[..axis.code_bits]).take(u64::BITS as usize).collect()
    }

    /// Finds two bits, at least one of them fine, that are lit and dark in the same places.
    fn alike(&self) -> Option<WrongImage> {
        let bits = self.bits();
        let axes = self.light.channels.axes.iter();
        let fine: Vec<bool> = axes.flat_map(|axis| (0..axis.code_bits).map(|bit| bit >= FIRST_FINE_BIT)).collect();
        let sample = self.sample();
        let signs: Vec<[u64; 2]> = (sample.iter().step_by(sample.len().div_ceil(COMPARED).max(1)))
            .map(|pixel| self.signs(&bits, *pixel))
            .collect();
        let pairs = (0..bits.len()).flat_map(|one| (one + 1..bits.len()).map(move |other| [one, other]));
        let agreeing = pairs.filter(|pair| pair.iter().any(|bit| fine[*bit])).filter_map(|[one, other]| {
            let both = 1 << one | 1 << other;
            let has = |signs: u64| signs & both == both;
            let (mut certain, mut same) = (0_u32, 0_u32);
            for [lit, dark] in &signs {
                certain += u32::from(has(lit | dark));
                same += u32::from(has(*lit) || has(*dark));
            }
            let is_comparable = f64::from(certain) > COMPARABLE * signs.len() as f64;
            (is_comparable && f64::from(same) > AGREEING * f64::from(certain)).then_some((same, one, other))
        });
        let (_, one, other) = agreeing.max()?;
        let images = [bits[one].lit, bits[other].lit];
        Some(WrongImage { stripes: bits[one].stripes, fault: ImageFault::Alike(images, bits[other].stripes) })
    }

    /// Signs of a pixel with little noise, none of others.
    pub(super) fn clear_signs(&self, bits: &[&StripeChannel], pixel: usize) -> [u64; 2] {
        if self.noise[pixel] < MOST_NOISE {
            self.signs(bits, pixel)
        } else {
            [0; 2]
        }
    }

    /// Bits that are certainly lit at a pixel, and those that are certainly dark.
    fn signs(&self, bits: &[&StripeChannel], pixel: usize) -> [u64; 2] {
        let Channels { white, black, .. } = *self.light.channels;
        let limit = CERTAIN * (self.light.at(white, pixel) - self.light.at(black, pixel));
        let mut signs = [0; 2];
        for (bit, channel) in bits.iter().enumerate() {
            let difference = self.light.at(channel.lit, pixel) - self.light.at(channel.inverse, pixel);
            if difference.abs() > limit {
                signs[usize::from(difference < 0.0)] |= 1 << bit;
            }
        }
        signs
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patterns::Axis;

    #[test]
    fn a_larger_step_is_named_for_fine_stripes_only() {
        for (bit, is_fine) in [(0, false), (6, false), (8, true), (10, true)] {
            let stripes = Stripes { axis: Axis::Y, bits: 11, bit, step: 1, offset: 0, inverted: false };
            let wrong = WrongImage { stripes, fault: ImageFault::NoInverse([2, 3]) };
            let text = wrong.describe(|index| format!("c{index:02}.png"));
            assert!(text.starts_with("c02.png and c03.png are not each other's inverse"), "{text}");
            assert_eq!(text.contains("--step"), is_fine, "{text}");
        }
    }
}
