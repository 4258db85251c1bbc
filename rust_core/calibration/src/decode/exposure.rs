//! Brings pictures whose exposure has changed to the exposure of white and black.
//!
//! A camera whose exposure settles makes all pixels of a picture darker or brighter by one factor. Stripes and their
//! inverse together are white and black together, which gives the factor of each pair. The camera's response and noise
//! are found from the same pictures, so that both are found twice.

use super::channels::{Channel, Channels};
use super::response::Response;
use super::Pictures;

/// The least difference of white and black at a pixel that tells, levels.
const LEAST_CONTRAST: u8 = 30;
/// The level from which on a pixel may be clipped.
const CLIPPED_FROM: u8 = 254;
/// A pixel is lit fully or not at all if the square of its contrast is larger.
const CLEAR: f64 = 0.25;
/// Pixels that are looked at, and the fewest that tell a factor.
const LOOKED_AT: usize = 20_000;
const LEAST_COMPARED: usize = 200;
/// Smaller changes do no harm, and are within what blur and a response that is not quite known make.
const LEAST_CHANGE: f64 = 0.1;
/// Rounds of finding factors and the camera's response.
const ROUNDS: usize = 2;

/// Pictures of one exposure.
#[derive(Debug)]
pub(super) struct Steadied {
    /// Grey levels in the order of the patterns.
    pub(super) levels: Vec<Vec<u8>>,
    /// Largest change of the exposure that was taken back: 0.1 where a pair was 10 % brighter or darker than white.
    pub(super) change: f64,
}

impl Steadied {
    /// The pictures as [`Pictures`].
    pub(super) fn pictures<'a>(&'a self, taken: &Pictures<'a>) -> Pictures<'a> {
        let levels = self.levels.iter().map(Vec::as_slice).collect();
        Pictures { size_px: taken.size_px, patterns: taken.patterns, levels }
    }
}

/// Takes changes of the exposure back; none where there is no large one.
pub(super) fn steadied(taken: &Pictures<'_>, channels: &Channels) -> Option<Steadied> {
    let mut steadied: Option<Steadied> = None;
    let mut factors = vec![1.0; taken.levels.len()];
    for _ in 0..ROUNDS {
        let pictures = steadied.as_ref().map(|steadied| steadied.pictures(taken));
        let pictures = pictures.as_ref().unwrap_or(taken);
        let response = Response::find(pictures, channels);
        let mut found = 1.0;
        for channel in channels.axes.iter().flat_map(|axis| &axis.all) {
            // The stripes of a pair that tells nothing are too fine: it was taken next to the one before it.
            found = factor(pictures, channels, &response, channel).unwrap_or(found);
            for picture in [channel.lit, channel.inverse] {
                factors[picture] *= found;
            }
        }
        let change = factors.iter().map(|factor| (factor - 1.0_f64).abs()).fold(0.0, f64::max);
        if change < LEAST_CHANGE {
            return None;
        }
        let scaled = |(levels, factor): (&&[u8], &f64)| {
            // Levels are a power of the light.
            let scale = factor.powf(-1.0 / response.gamma);
            levels.iter().map(|level| (f64::from(*level) * scale).round().min(255.0) as u8).collect()
        };
        let levels = taken.levels.iter().zip(&factors).map(scaled).collect();
        steadied = Some(Steadied { levels, change });
    }
    steadied
}

/// The factor by which a pair is brighter than white and black, the median over clear pixels.
fn factor(pictures: &Pictures<'_>, channels: &Channels, response: &Response, channel: &Channel) -> Option<f64> {
    let wanted = [channels.white, channels.black, channel.lit, channel.inverse];
    let [white, black, ..] = wanted.map(|picture| pictures.levels[picture]);
    let tells = |pixel: &usize| white[*pixel].saturating_sub(black[*pixel]) >= LEAST_CONTRAST;
    let every = (white.len() / LOOKED_AT).max(1);
    let ratio = |pixel: usize| {
        let seen = wanted.map(|picture| pictures.levels[picture][pixel]);
        let [white, black, lit, inverse] = seen.map(|level| f64::from(response.light(level)));
        let is_clear = ((lit - inverse) / (white + black)).powi(2) > CLEAR;
        (is_clear && seen.iter().all(|level| *level < CLIPPED_FROM)).then(|| (lit + inverse) / (white + black))
    };
    let mut ratios: Vec<f64> = (0..white.len()).step_by(every).filter(tells).filter_map(ratio).collect();
    let middle = ratios.len() / 2;
    (ratios.len() >= LEAST_COMPARED).then(|| *ratios.select_nth_unstable_by(middle, f64::total_cmp).1)
}
