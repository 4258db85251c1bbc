//! Quality of a scan: clipping, motion, exposure.
//!
//! The sum of stripes and their inverse equals that of white and black. A motion in between makes a difference along
//! the image's gradient, a change of the exposure a common factor. Pixels clipped in any of these images are skipped.

use nalgebra::{Matrix4, Vector2, Vector4};

use super::channels::StripeChannel;
use super::exposure::{CLEAR, LEAST_COMPARED, SAMPLED};
use super::light_images::LightImages;
use super::response::CLIPPED_FROM;
use super::wrong_images::{ImageCheck, ImageFault, WrongImage};
use crate::statistics::median;

const CLIPPED: u8 = 255;
/// Maximum motion of a steady camera, camera pixels.
const MOST_MOVED_PX: f64 = 0.5;
/// Maximum change of a steady exposure, and of a usable one.
const UNSTEADY_EXPOSURE: f64 = 0.05;
const LOST_EXPOSURE: f64 = 0.3;
/// Maximum share of clipped pixels.
const MUCH_CLIPPED: f64 = 0.02;
/// Shares of clipped and of contradicted pixels that together make a scan unusable.
const LOST_CLIPPED: f64 = 0.5;
const MOST_CONTRADICTED: f64 = 0.5;
/// Maximum share of places at which coordinates run backwards.
const MANY_REVERSED: f64 = 0.02;
/// Maximum share of a bit's edges at which the next finer bit is dark.
const MANY_DARK_EDGES: f64 = 0.3;
/// Maximum share of pixels beyond the projector's image.
const MANY_BEYOND: f64 = 0.03;
/// Minimum significance of a motion, standard deviations. These come from the differences between blocks of the image,
/// as pixels of a block share errors other than noise; `BLOCKS` is their number along each side.
const MOVED_SIGMAS: f64 = 4.0;
const BLOCKS: usize = 8;

/// Quality measures of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Quality {
    /// Share of the lit pixels clipped in white.
    pub clipped: f64,
    /// Maximum motion between white and black and a pair of stripes, camera pixels.
    pub moved_px: f64,
    /// Maximum change of the exposure: 0.1 for an image 10 % brighter or darker than white and black.
    pub exposure_change: f64,
    /// Shares of the lit pixels whose stripes lead beyond the projector's last column and row.
    pub beyond: [f64; 2],
    /// Share of the decoded places at which coordinates run backwards; 1 if white is darker than black.
    pub reversed: f64,
    /// Share of a bit's edges at which the next finer bit is dark; the largest of all bits.
    pub dark_edges: f64,
    /// Image of another pattern than listed.
    pub wrong_image: Option<WrongImage>,
    /// Share of the lit pixels whose stripes fit no coordinate.
    pub contradicted: f64,
    /// Exponent of the camera's response: light = level ^ gamma.
    pub gamma: f64,
}

/// Problem of a scan, with advice as text.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ScanProblem {
    /// The camera or an object has moved by camera pixels.
    #[error(
        "the camera or an object has moved by {0:.1} pixels during the scan: keep everything at rest and scan again"
    )]
    Moved(f64),
    /// The exposure has changed by a share.
    #[error(
        "the brightness has changed by {:.0} % during the scan: switch automatic exposure off, and lamps that flicker",
        100.0 * .0
    )]
    Exposure(f64),
    /// A share of the lit pixels is clipped.
    #[error("{:.0} % of the lit pixels are overexposed: shorten the exposure until white is not clipped", 100.0 * .0)]
    Clipped(f64),
    /// Clipping of a share of the lit pixels, and no coordinate that fits the stripes of another share.
    #[error(
        "{:.0} % of the lit pixels are overexposed, and the stripes of {:.0} % fit no projector pixel: shorten the \
         exposure until white is not clipped",
        100.0 * clipped, 100.0 * contradicted
    )]
    Overexposed {
        /// Share of the lit pixels that is clipped.
        clipped: f64,
        /// Share of the lit pixels whose stripes fit no coordinate.
        contradicted: f64,
    },
    /// An image shows another pattern than listed.
    #[error("{}", .0.describe(|index| format!("picture {}", index + 1)))]
    WrongImage(WrongImage),
    /// White is darker than black, coordinates run backwards, or bits are exchanged.
    #[error(
        "the pictures are mirrored, or not in the order of the patterns (white before black, columns before rows, \
         stripes before their inverse): give them in that order, as the camera sees them"
    )]
    Order,
    /// The stripes of many lit pixels lead beyond the projector's image.
    #[error(
        "the stripes of {:.0} % of the lit pixels lead beyond the projector's last {last}: the projector has another \
         size, or the pictures are not in the order of the patterns",
        100.0 * share
    )]
    Beyond {
        /// `column` or `row`.
        last: &'static str,
        /// Share of the lit pixels.
        share: f64,
    },
}

impl ScanProblem {
    /// `true` if the scan is unusable.
    pub fn is_fatal(self) -> bool {
        match self {
            Self::Moved(_) | Self::WrongImage(_) | Self::Order | Self::Overexposed { .. } | Self::Beyond { .. } => true,
            Self::Exposure(change) => change > LOST_EXPOSURE,
            Self::Clipped(_) => false,
        }
    }
}

impl Quality {
    /// Problems, the worst first.
    pub fn problems(&self) -> Vec<ScanProblem> {
        let beyond = ["column", "row"].into_iter().zip(self.beyond).filter(|(_, share)| *share > MANY_BEYOND);
        let beyond = beyond.map(|(last, share)| ScanProblem::Beyond { last, share }).next();
        let moved = (self.moved_px > MOST_MOVED_PX).then_some(ScanProblem::Moved(self.moved_px));
        let exposure = self.exposure_change > UNSTEADY_EXPOSURE;
        let exposure = exposure.then_some(ScanProblem::Exposure(self.exposure_change));
        let &Self { clipped, contradicted, .. } = self;
        let is_lost = clipped > LOST_CLIPPED && contradicted > MOST_CONTRADICTED;
        let overexposed = ScanProblem::Overexposed { clipped, contradicted };
        let problem = if is_lost { overexposed } else { ScanProblem::Clipped(clipped) };
        let clipped = (clipped > MUCH_CLIPPED).then_some(problem);
        // A motion between stripes and their inverse also breaks the pair.
        let is_by_motion = |wrong: &WrongImage| moved.is_some() && matches!(wrong.fault, ImageFault::NoInverse(_));
        let wrong_image = self.wrong_image.filter(|wrong| !is_by_motion(wrong)).map(ScanProblem::WrongImage);
        let is_out_of_order = self.reversed > MANY_REVERSED || self.dark_edges > MANY_DARK_EDGES;
        let order = is_out_of_order.then_some(ScanProblem::Order);
        [wrong_image, order, beyond, moved, exposure, clipped].into_iter().flatten().collect()
    }

    /// Measures the quality, without wrong images.
    pub(super) fn measure(check: &ImageCheck<'_>) -> Self {
        let ImageCheck { light, noise } = *check;
        let LightImages { images, channels, response } = *light;
        let wrong_image = check.wrong_image();
        let lit: Vec<usize> = (0..noise.len()).filter(|pixel| noise[*pixel].is_finite()).collect();
        let white = images.levels[channels.white];
        let clipped = lit.iter().filter(|pixel| white[**pixel] == CLIPPED).count();
        let mut quality = Self {
            clipped: clipped as f64 / lit.len().max(1) as f64,
            gamma: response.gamma,
            wrong_image,
            ..Self::default()
        };
        let every = (lit.len() / SAMPLED).max(1);
        let sample: Vec<LightSum> = lit.iter().step_by(every).filter_map(|pixel| LightSum::at(light, *pixel)).collect();
        if sample.len() < LEAST_COMPARED {
            return quality;
        }
        let is_right = |channel: &&StripeChannel| wrong_image.is_none_or(|wrong| wrong.stripes != channel.stripes);
        for channel in channels.axes.iter().flat_map(|axis| &axis.all).filter(is_right) {
            let comparison = compare(light, channel, &sample);
            quality.moved_px = quality.moved_px.max(comparison.moved_px);
            quality.exposure_change = quality.exposure_change.max(comparison.change.abs());
        }
        quality
    }
}

/// Sum of white and black at a pixel, with its gradient.
struct LightSum {
    pixel: usize,
    block: usize,
    light: f64,
    gradient: Vector2<f64>,
}

impl LightSum {
    /// `None` at the image's edge and where a pixel is clipped.
    fn at(images: &LightImages<'_>, pixel: usize) -> Option<Self> {
        let LightImages { images, channels, response } = *images;
        let [width, height] = images.size_px.map(|side| side as usize);
        let (x, y) = (pixel % width, pixel / width);
        if x == 0 || y == 0 || x + 1 >= width || y + 1 >= height {
            return None;
        }
        let (white, black) = (images.levels[channels.white], images.levels[channels.black]);
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

/// Difference of a pair and white and black.
struct Comparison {
    /// Motion, camera pixels; 0 if insignificant.
    moved_px: f64,
    /// Relative change of the exposure.
    change: f64,
}

/// Compares a pair with white and black by fitting both images' exposures and one motion together, so that changes of
/// the exposure do not count as motion.
fn compare(images: &LightImages<'_>, channel: &StripeChannel, sample: &[LightSum]) -> Comparison {
    let levels = [channel.lit, channel.inverse].map(|image| images.images.levels[image]);
    let mut light_square = 0.0;
    let mut changes = Vec::new();
    let (mut normal, mut right) = (Matrix4::zeros(), Vector4::zeros());
    // Block, weight, terms and right-hand side of each pixel.
    let mut rows = Vec::with_capacity(sample.len());
    for sum in sample {
        let pair = levels.map(|levels| levels[sum.pixel]);
        if pair.iter().any(|level| *level >= CLIPPED_FROM) {
            continue;
        }
        let [lit, inverse] = pair.map(|level| f64::from(images.response.light(level)));
        // Half lit pixels depend on errors of the response.
        let clear = ((lit - inverse) / sum.light).powi(2);
        if clear > CLEAR {
            changes.push((lit + inverse) / sum.light - 1.0);
        }
        light_square += clear * sum.light * sum.light;
        // Bounded, so that a few strong edges do not decide.
        let weight = clear / (1.0 + sum.gradient.norm_squared() / (0.1 * sum.light).powi(2));
        let terms = Vector4::new(sum.gradient.x, sum.gradient.y, lit, inverse);
        let difference = sum.light - lit - inverse;
        normal += weight * terms * terms.transpose();
        right += weight * difference * terms;
        rows.push((sum.block, weight, terms, difference));
    }
    let change = if changes.len() < LEAST_COMPARED { 0.0 } else { median(&mut changes) };
    // Regularises images without gradients.
    normal += Matrix4::identity() * 1e-6 * light_square;
    let Some(inverse) = normal.try_inverse().filter(|_| rows.len() >= LEAST_COMPARED) else {
        return Comparison { moved_px: 0.0, change };
    };
    let solution = inverse * right;
    let mut scores = [Vector4::zeros(); BLOCKS * BLOCKS];
    for (block, weight, terms, difference) in &rows {
        scores[*block] += *weight * (difference - terms.dot(&solution)) * terms;
    }
    let between: Matrix4<f64> = scores.iter().map(|score| score * score.transpose()).sum();
    let covariance = inverse * between * inverse;
    let shift = solution.fixed_rows::<2>(0).into_owned();
    let moved_px = shift.norm();
    let variance =
        (shift.transpose() * covariance.fixed_view::<2, 2>(0, 0) * shift).x / (moved_px * moved_px).max(1e-12);
    let is_significant = moved_px > MOVED_SIGMAS * variance.sqrt();
    Comparison { moved_px: if is_significant { moved_px } else { 0.0 }, change }
}
