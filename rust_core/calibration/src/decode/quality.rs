//! Whether the pictures of a scan belong together: nothing clipped, camera and things at rest, exposure steady.
//!
//! Stripes and their inverse together are white and black together. Where the camera has moved in between, they differ
//! along the picture's gradient; where the exposure has changed, everywhere by the same factor.

use std::fmt;

use nalgebra::{Matrix2, Vector2};

use super::channels::{Channel, Channels};
use super::response::Response;
use super::Pictures;

/// The level of clipped pixels.
const CLIPPED: u8 = 255;
/// A camera that has moved farther was not at rest, camera pixels.
const MOST_MOVED_PX: f64 = 0.5;
/// From this change on the exposure was not steady; from the other one on, nothing can be compared any more.
const UNSTEADY_EXPOSURE: f64 = 0.05;
const LOST_EXPOSURE: f64 = 0.3;
/// From this share of clipped pixels on the exposure was too long; from the other one on, most of what is decoded is
/// wrong.
const MUCH_CLIPPED: f64 = 0.02;
const LOST_CLIPPED: f64 = 0.5;
/// From this share of pixels beyond the projector's picture on, the patterns are not those of its size.
const MANY_BEYOND: f64 = 0.03;
/// Pixels that are looked at in each pair of pictures.
const LOOKED_AT: usize = 20_000;

/// What is known of how a scan was taken.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Quality {
    /// The share of lit pixels that are clipped in the white picture.
    pub clipped: f64,
    /// How far the picture has moved, at most, between white and black and a pair of stripes, camera pixels.
    pub moved_px: f64,
    /// The largest change of the exposure: 0.1 where a picture is 10 % brighter or darker than white and black are.
    pub exposure_change: f64,
    /// The shares of the lit pixels whose stripes lead beyond the projector's last column and row.
    pub beyond: [f64; 2],
    /// The exponent of the camera's response that was found: light = level ^ gamma.
    pub gamma: f64,
}

/// What was wrong when the scan was taken. Shown, it says what to do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ScanProblem {
    /// The camera or the things have moved by so many camera pixels.
    Moved(f64),
    /// The exposure has changed by this share.
    Exposure(f64),
    /// This share of the lit pixels is clipped.
    Clipped(f64),
    /// The stripes of this share of the lit pixels lead beyond the projector's last column, or row.
    Beyond {
        /// `column` or `row`.
        last: &'static str,
        /// 0 to 1.
        share: f64,
    },
}

impl ScanProblem {
    /// Whether a scan with this problem is to be refused, because what it tells is wrong.
    pub fn is_fatal(self) -> bool {
        match self {
            Self::Moved(_) | Self::Beyond { .. } => true,
            Self::Exposure(change) => change > LOST_EXPOSURE,
            Self::Clipped(share) => share > LOST_CLIPPED,
        }
    }
}

impl fmt::Display for ScanProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Moved(px) => write!(
                f,
                "the camera or the things have moved by {px:.1} pixels during the scan: keep both at rest and scan again"
            ),
            Self::Exposure(change) => write!(
                f,
                "the brightness has changed by {:.0} % during the scan: switch automatic exposure off, and lamps that flicker",
                100.0 * change
            ),
            Self::Clipped(share) => write!(
                f,
                "{:.0} % of the lit pixels are overexposed: shorten the exposure until white is not clipped",
                100.0 * share
            ),
            Self::Beyond { last, share } => write!(
                f,
                "the stripes of {:.0} % of the lit pixels lead beyond the projector's last {last}: the size of the \
                 projector is another one, or the list of patterns is not that of the pictures",
                100.0 * share
            ),
        }
    }
}

impl Quality {
    /// What was wrong, the worst first.
    pub fn problems(&self) -> Vec<ScanProblem> {
        let beyond = ["column", "row"].into_iter().zip(self.beyond).filter(|(_, share)| *share > MANY_BEYOND);
        let beyond = beyond.map(|(last, share)| ScanProblem::Beyond { last, share }).next();
        let moved = (self.moved_px > MOST_MOVED_PX).then_some(ScanProblem::Moved(self.moved_px));
        let exposure = self.exposure_change > UNSTEADY_EXPOSURE;
        let exposure = exposure.then_some(ScanProblem::Exposure(self.exposure_change));
        let clipped = (self.clipped > MUCH_CLIPPED).then_some(ScanProblem::Clipped(self.clipped));
        [beyond, moved, exposure, clipped].into_iter().flatten().collect()
    }

    pub(super) fn measure(pictures: &Pictures<'_>, channels: &Channels, response: &Response, noise: &[f32]) -> Self {
        let lit: Vec<usize> = (0..noise.len()).filter(|pixel| noise[*pixel].is_finite()).collect();
        let white = pictures.levels[channels.white];
        let clipped = lit.iter().filter(|pixel| white[**pixel] == CLIPPED).count();
        let mut quality =
            Self { clipped: clipped as f64 / lit.len().max(1) as f64, gamma: response.gamma, ..Self::default() };
        let every = (lit.len() / LOOKED_AT).max(1);
        let sample: Vec<Sum> =
            lit.iter().step_by(every).filter_map(|pixel| Sum::at(pictures, channels, response, *pixel)).collect();
        if sample.len() < 200 {
            return quality;
        }
        for channel in channels.axes.iter().flat_map(|axis| &axis.all) {
            let (moved, change) = compare(pictures, response, channel, &sample);
            quality.moved_px = quality.moved_px.max(moved);
            quality.exposure_change = quality.exposure_change.max(change.abs());
        }
        quality
    }
}

/// Light of white and black together at a pixel, and its gradient.
struct Sum {
    pixel: usize,
    light: f64,
    gradient: Vector2<f64>,
}

impl Sum {
    /// None at the margin and where something is clipped.
    fn at(pictures: &Pictures<'_>, channels: &Channels, response: &Response, pixel: usize) -> Option<Self> {
        let [width, height] = pictures.size_px.map(|side| side as usize);
        let (x, y) = (pixel % width, pixel / width);
        if x == 0 || y == 0 || x + 1 >= width || y + 1 >= height {
            return None;
        }
        let (white, black) = (pictures.levels[channels.white], pictures.levels[channels.black]);
        let around = [pixel, pixel - 1, pixel + 1, pixel - width, pixel + width];
        if around.iter().any(|pixel| white[*pixel] == CLIPPED) {
            return None;
        }
        let [light, left, right, above, below] =
            around.map(|pixel| f64::from(response.light(white[pixel]) + response.light(black[pixel])));
        Some(Self { pixel, light, gradient: Vector2::new(right - left, below - above) / 2.0 })
    }
}

/// How far a pair has moved, and the share by which it is brighter.
fn compare(pictures: &Pictures<'_>, response: &Response, channel: &Channel, sample: &[Sum]) -> (f64, f64) {
    let (lit, inverse) = (pictures.levels[channel.lit], pictures.levels[channel.inverse]);
    let (mut light, mut light_square) = (0.0, 0.0);
    for sum in sample {
        let pair = f64::from(response.light(lit[sum.pixel]) + response.light(inverse[sum.pixel]));
        light += pair * sum.light;
        light_square += sum.light * sum.light;
    }
    let factor = light / light_square;
    let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
    for sum in sample {
        let pair = f64::from(response.light(lit[sum.pixel]) + response.light(inverse[sum.pixel]));
        let miss = pair - factor * sum.light;
        // Bounded, so that a few strong edges do not decide.
        let weight = 1.0 / (1.0 + sum.gradient.norm_squared() / (0.1 * sum.light).powi(2));
        normal += weight * sum.gradient * sum.gradient.transpose();
        right -= weight * sum.gradient * miss;
    }
    // A picture without gradients tells nothing; noise in them would tell too much.
    normal += Matrix2::identity() * 1e-6 * light_square;
    let moved = normal.try_inverse().map_or(0.0, |inverse| (inverse * right).norm());
    (moved, factor - 1.0)
}
