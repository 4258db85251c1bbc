//! Whether the pictures of a scan belong together: nothing clipped, camera and things at rest, exposure steady.
//!
//! Stripes and their inverse together are white and black together. Where the camera has moved in between, they differ
//! along the picture's gradient; where the exposure has changed, everywhere by the same factor. Pixels that are clipped
//! in any of these pictures tell nothing.

use std::fmt;

use nalgebra::{Matrix4, Vector2, Vector4};

use super::channels::{Channel, Channels};
use super::order::{Order, PictureFault, WrongPicture};
use super::response::Response;
use super::Pictures;

/// The level of clipped pixels.
const CLIPPED: u8 = 255;
/// From this level on a pixel may be clipped.
const CLIPPED_FROM: u8 = 254;
/// A camera that has moved farther was not at rest, camera pixels.
const MOST_MOVED_PX: f64 = 0.5;
/// From this change on the exposure was not steady; from the other one on, nothing can be compared any more.
const UNSTEADY_EXPOSURE: f64 = 0.05;
const LOST_EXPOSURE: f64 = 0.3;
/// From this share of clipped pixels on the exposure was too long.
const MUCH_CLIPPED: f64 = 0.02;
/// Where so many pixels are clipped, the stripes of at most this share of the pixels may fit no place.
const LOST_CLIPPED: f64 = 0.5;
const MOST_CONTRADICTED: f64 = 0.5;
/// From this share of pixels beyond the projector's picture on, the patterns are not those of its size.
const MANY_BEYOND: f64 = 0.03;
/// Pixels that are looked at in each pair of pictures.
const LOOKED_AT: usize = 20_000;
/// Fewer of them tell nothing.
const LEAST_COMPARED: usize = 200;
/// A pixel is lit fully or not at all if the square of its contrast is larger.
const CLEAR: f64 = 0.25;
/// A motion is one if it is so many standard deviations from none. These come from how blocks of the picture differ, of
/// which there are so many along each side: pixels of a block share what is not noise.
const MOVED_SIGMAS: f64 = 4.0;
const BLOCKS: usize = 8;

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
    /// A picture that does not show what it is said to.
    pub wrong_picture: Option<WrongPicture>,
    /// The share of the lit pixels whose stripes fit no place.
    pub contradicted: f64,
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
    /// Clipping of so large a share that the stripes of many pixels fit no place.
    Overexposed {
        /// The share of the lit pixels that is clipped.
        clipped: f64,
        /// The share of the lit pixels whose stripes fit no place.
        contradicted: f64,
    },
    /// A picture does not show what it is said to.
    WrongPicture(WrongPicture),
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
            Self::Moved(_) | Self::WrongPicture(_) | Self::Overexposed { .. } | Self::Beyond { .. } => true,
            Self::Exposure(change) => change > LOST_EXPOSURE,
            Self::Clipped(_) => false,
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
            Self::Overexposed { clipped, contradicted } => write!(
                f,
                "{:.0} % of the lit pixels are overexposed, and the stripes of {:.0} % fit no place: shorten the exposure \
                 until white is not clipped",
                100.0 * clipped,
                100.0 * contradicted
            ),
            Self::WrongPicture(wrong_picture) => {
                write!(f, "{}", wrong_picture.describe(|index| format!("picture {}", index + 1)))
            }
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
        let clipped = (self.clipped > MUCH_CLIPPED).then(|| self.overexposed());
        // A motion between stripes and their inverse makes them no pair, too.
        let is_by_motion = moved.is_some()
            && self
                .wrong_picture
                .is_some_and(|wrong_picture| matches!(wrong_picture.fault, PictureFault::NoInverse(_)));
        let wrong_picture = self.wrong_picture.filter(|_| !is_by_motion).map(ScanProblem::WrongPicture);
        [wrong_picture, beyond, moved, exposure, clipped].into_iter().flatten().collect()
    }

    fn overexposed(&self) -> ScanProblem {
        let &Self { clipped, contradicted, .. } = self;
        if clipped > LOST_CLIPPED && contradicted > MOST_CONTRADICTED {
            ScanProblem::Overexposed { clipped, contradicted }
        } else {
            ScanProblem::Clipped(clipped)
        }
    }

    /// Measures it by pictures that `wrong_picture` leaves.
    pub(super) fn measure(order: &Order<'_>) -> Self {
        let Order { pictures, channels, response, noise } = *order;
        let wrong_picture = order.wrong_picture();
        let lit: Vec<usize> = (0..noise.len()).filter(|pixel| noise[*pixel].is_finite()).collect();
        let white = pictures.levels[channels.white];
        let clipped = lit.iter().filter(|pixel| white[**pixel] == CLIPPED).count();
        let mut quality = Self {
            clipped: clipped as f64 / lit.len().max(1) as f64,
            gamma: response.gamma,
            wrong_picture,
            ..Self::default()
        };
        let every = (lit.len() / LOOKED_AT).max(1);
        let sample: Vec<Sum> =
            lit.iter().step_by(every).filter_map(|pixel| Sum::at(pictures, channels, response, *pixel)).collect();
        if sample.len() < LEAST_COMPARED {
            return quality;
        }
        let is_as_said =
            |channel: &&Channel| wrong_picture.is_none_or(|wrong_picture| wrong_picture.stripes != channel.stripes);
        for channel in channels.axes.iter().flat_map(|axis| &axis.all).filter(is_as_said) {
            let comparison = compare(pictures, response, channel, &sample);
            quality.moved_px = quality.moved_px.max(comparison.moved_px);
            quality.exposure_change = quality.exposure_change.max(comparison.change.abs());
        }
        quality
    }
}

/// Light of white and black together at a pixel, and its gradient.
struct Sum {
    pixel: usize,
    /// The block of the picture.
    block: usize,
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
        if around.iter().any(|pixel| white[*pixel] >= CLIPPED_FROM) {
            return None;
        }
        let [light, left, right, above, below] =
            around.map(|pixel| f64::from(response.light(white[pixel]) + response.light(black[pixel])));
        let block = y * BLOCKS / height * BLOCKS + x * BLOCKS / width;
        Some(Self { pixel, block, light, gradient: Vector2::new(right - left, below - above) / 2.0 })
    }
}

/// How a pair differs from white and black.
struct Comparison {
    /// How far it has moved, camera pixels; 0 if that is within its noise.
    moved_px: f64,
    /// The share by which it is brighter.
    change: f64,
}

/// Compares a pair with white and black: both pictures' exposures and one motion are fitted to what they leave over, so
/// that a motion is only what exposures do not explain.
fn compare(pictures: &Pictures<'_>, response: &Response, channel: &Channel, sample: &[Sum]) -> Comparison {
    let levels = [channel.lit, channel.inverse].map(|picture| pictures.levels[picture]);
    let mut light_square = 0.0;
    // How much brighter pixels are that stripes light fully or not at all.
    let mut changes = Vec::new();
    let (mut normal, mut right) = (Matrix4::zeros(), Vector4::zeros());
    // Of each pixel: its block, the weight, the terms, and what is to be explained.
    let mut rows = Vec::with_capacity(sample.len());
    for sum in sample {
        let seen = levels.map(|levels| levels[sum.pixel]);
        if seen.iter().any(|level| *level >= CLIPPED_FROM) {
            continue;
        }
        let [lit, inverse] = seen.map(|level| f64::from(response.light(level)));
        // Half lit pixels show the camera's response, if it is not quite known, rather than a change.
        let clear = ((lit - inverse) / sum.light).powi(2);
        if clear > CLEAR {
            changes.push((lit + inverse) / sum.light - 1.0);
        }
        light_square += clear * sum.light * sum.light;
        // Bounded, so that a few strong edges do not decide.
        let weight = clear / (1.0 + sum.gradient.norm_squared() / (0.1 * sum.light).powi(2));
        let terms = Vector4::new(sum.gradient.x, sum.gradient.y, lit, inverse);
        let miss = sum.light - lit - inverse;
        normal += weight * terms * terms.transpose();
        right += weight * miss * terms;
        rows.push((sum.block, weight, terms, miss));
    }
    let middle = changes.len() / 2;
    let change =
        if changes.len() < LEAST_COMPARED { 0.0 } else { *changes.select_nth_unstable_by(middle, f64::total_cmp).1 };
    // A picture without gradients tells nothing; noise in them would tell too much.
    normal += Matrix4::identity() * 1e-6 * light_square;
    let Some(inverse) = normal.try_inverse().filter(|_| rows.len() >= LEAST_COMPARED) else {
        return Comparison { moved_px: 0.0, change };
    };
    let solution = inverse * right;
    let mut scores = [Vector4::zeros(); BLOCKS * BLOCKS];
    for (block, weight, terms, miss) in &rows {
        scores[*block] += *weight * (miss - terms.dot(&solution)) * terms;
    }
    let between: Matrix4<f64> = scores.iter().map(|score| score * score.transpose()).sum();
    let covariance = inverse * between * inverse;
    let shift = solution.fixed_rows::<2>(0).into_owned();
    let moved_px = shift.norm();
    let variance =
        (shift.transpose() * covariance.fixed_view::<2, 2>(0, 0) * shift).x / (moved_px * moved_px).max(1e-12);
    let is_shown = moved_px > MOVED_SIGMAS * variance.sqrt();
    Comparison { moved_px: if is_shown { moved_px } else { 0.0 }, change }
}
