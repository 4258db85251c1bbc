//! Exposure compensation: scales images to the exposure of white and black.
//!
//! A settling exposure scales all pixels of an image by one factor. The sum of stripes and their inverse equals that of
//! white and black, which gives the factor of each pair. Response and factors depend on each other, so both are
//! estimated twice.

use super::channels::{Channels, StripeChannel};
use super::response::{Response, CLIPPED_FROM};
use super::Images;
use crate::statistics::median;

/// Minimum difference of white and black, levels.
const LEAST_CONTRAST: u8 = 30;
/// Minimum squared contrast of a pixel that stripes light fully or not at all.
pub(super) const CLEAR: f64 = 0.25;
/// Number of sampled pixels, and minimum for a result.
pub(super) const SAMPLED: usize = 20_000;
pub(super) const LEAST_COMPARED: usize = 200;
/// Minimum compensated change: smaller ones are harmless, and within the errors of blur and response.
const LEAST_CHANGE: f64 = 0.1;
/// Rounds of estimating factors and response.
const ROUNDS: usize = 2;

/// Images of one exposure.
#[derive(Debug)]
pub(super) struct Steadied {
    /// Grey levels in the order of the patterns.
    pub(super) levels: Vec<Vec<u8>>,
    /// Largest compensated change: 0.1 for a pair that was 10 % brighter or darker than white.
    pub(super) change: f64,
}

impl Steadied {
    pub(super) fn images<'a>(&'a self, taken: &Images<'a>) -> Images<'a> {
        let levels = self.levels.iter().map(Vec::as_slice).collect();
        Images { size_px: taken.size_px, patterns: taken.patterns, levels }
    }
}

/// Compensates changes of the exposure; `None` if there is no large one.
pub(super) fn steadied(taken: &Images<'_>, channels: &Channels) -> Option<Steadied> {
    let mut steadied: Option<Steadied> = None;
    let mut factors = vec![1.0; taken.levels.len()];
    for _ in 0..ROUNDS {
        let images = steadied.as_ref().map(|steadied| steadied.images(taken));
        let images = images.as_ref().unwrap_or(taken);
        let response = Response::find(images, channels);
        let mut found = 1.0;
        for channel in channels.axes.iter().flat_map(|axis| &axis.all) {
            // Pairs of too fine stripes take the factor of the pair before.
            found = factor(images, channels, &response, channel).unwrap_or(found);
            for image in [channel.lit, channel.inverse] {
                factors[image] *= found;
            }
        }
        let change = factors.iter().map(|factor| (factor - 1.0_f64).abs()).fold(0.0, f64::max);
        if change < LEAST_CHANGE {
            return None;
        }
        let scaled = |(levels, factor): (&&[u8], &f64)| {
            // Level = light ^ (1 / gamma).
            let scale = factor.powf(-1.0 / response.gamma);
            levels.iter().map(|level| (f64::from(*level) * scale).round().min(255.0) as u8).collect()
        };
        let levels = taken.levels.iter().zip(&factors).map(scaled).collect();
        steadied = Some(Steadied { levels, change });
    }
    steadied
}

/// Ratio of a pair's light and that of white and black: the median over clear pixels.
fn factor(images: &Images<'_>, channels: &Channels, response: &Response, channel: &StripeChannel) -> Option<f64> {
    let wanted = [channels.white, channels.black, channel.lit, channel.inverse];
    let [white, black, ..] = wanted.map(|image| images.levels[image]);
    let tells = |pixel: &usize| white[*pixel].saturating_sub(black[*pixel]) >= LEAST_CONTRAST;
    let every = (white.len() / SAMPLED).max(1);
    let ratio = |pixel: usize| {
        let seen = wanted.map(|image| images.levels[image][pixel]);
        let [white, black, lit, inverse] = seen.map(|level| f64::from(response.light(level)));
        let is_clear = ((lit - inverse) / (white + black)).powi(2) > CLEAR;
        (is_clear && seen.iter().all(|level| *level < CLIPPED_FROM)).then(|| (lit + inverse) / (white + black))
    };
    let mut ratios: Vec<f64> = (0..white.len()).step_by(every).filter(tells).filter_map(ratio).collect();
    (ratios.len() >= LEAST_COMPARED).then(|| median(&mut ratios))
}
