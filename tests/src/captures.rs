//! Captures of patterns of which it is known where the light comes from, and what goes wrong with the order of their
//! images.

use std::path::Path;

use anyhow::{Context, Result};
use rcs_calibration::patterns::{gray_code, Axis, Pattern};
use rcs_calibration::{decode, Decoded, Images};
use rcs_files::capture::Capture;
use rcs_scan_simulator::{Conditions, Rig, Room, Scan, View};

/// The projector of simulated captures, pixels.
const PROJECTOR_PX: [u32; 2] = [1280, 800];
/// A decoded place is wrong if it is off by more, projector pixels.
const WRONG_PX: f64 = 2.0;
/// Stripes at least so wide are clear if they differ from their inverse by this share of white and black.
const WIDE_PX: f64 = 5.0;
const CLEAR: f64 = 0.25;

/// A capture, and where its light comes from.
pub struct KnownCapture {
    /// Width and height of the camera's images, pixels.
    pub size_px: [u32; 2],
    /// Width and height of the projector's image, pixels.
    pub projector_px: [u32; 2],
    /// The pattern that each image shows.
    pub patterns: Vec<Pattern>,
    /// Grey levels of the camera's images, row by row.
    pub greys: Vec<Vec<u8>>,
    /// The projector's column and row that light each pixel, where that is known.
    pub truth: Vec<Option<[f64; 2]>>,
}

/// How a decoded capture compares with the truth.
#[derive(Debug, Clone, Copy)]
pub struct DecodedShares {
    /// Pixels that are decoded, of those whose truth is known.
    pub decoded: f64,
    /// Pixels that are off by more than two projector pixels, of those that are decoded.
    pub wrong: f64,
}

impl KnownCapture {
    /// A capture folder. Truth is what signs of stripes less their inverse say where they are clear.
    ///
    /// # Errors
    /// A folder that cannot be read, or is without white, black or an inverse.
    pub fn read(folder: &Path) -> Result<Self> {
        let capture = Capture::read(folder)?;
        let patterns: Vec<Pattern> = capture.images.iter().map(|image| image.pattern).collect();
        let (size_px, projector_px) = (capture.image_size_px(), capture.projector_size_px);
        let greys: Vec<Vec<u8>> = capture.images.into_iter().map(|image| image.grey).collect();
        let truth = by_signs(&patterns, &greys)?;
        Ok(Self { size_px, projector_px, patterns, greys, truth })
    }

    /// A scan of a simulated room.
    pub fn simulated(seed: u64) -> Self {
        Self::simulated_under(seed, Conditions::random(seed))
    }

    /// A scan of a simulated room under some conditions.
    pub fn simulated_under(seed: u64, conditions: Conditions) -> Self {
        let view = View::new(&Room::cluttered(seed), &Rig::random(seed));
        let patterns = gray_code(PROJECTOR_PX);
        let greys = Scan::new(&view, conditions).capture_all(&patterns);
        let size_px = view.size_px();
        let pixels = (0..size_px[1]).flat_map(|v| (0..size_px[0]).map(move |u| (u, v)));
        let truth = pixels.map(|(u, v)| view.truth(u, v).map(|at| [at.x, at.y])).collect();
        Self { size_px, projector_px: PROJECTOR_PX, patterns, greys, truth }
    }

    /// Decodes with each image replaced by the one with this index.
    ///
    /// # Errors
    /// Patterns that cannot be decoded.
    pub fn decode(&self, order: &[usize]) -> Result<Decoded> {
        let levels = order.iter().map(|image| self.greys[*image].as_slice()).collect();
        let images = Images { size_px: self.size_px, patterns: &self.patterns, levels };
        Ok(decode(&images, self.projector_px)?)
    }

    /// How many pixels are decoded, and how many of them wrongly.
    pub fn shares(&self, decoded: &Decoded) -> DecodedShares {
        let known = self.truth.iter().zip(&decoded.pixels).filter_map(|(truth, pixel)| Some(((*truth)?, pixel)));
        let (mut all, mut found, mut wrong) = (0_u32, 0_u32, 0_u32);
        for (truth, pixel) in known {
            all += 1;
            if pixel.is_decoded() {
                found += 1;
                wrong += u32::from((0..2).any(|axis| (f64::from(pixel.at[axis]) - truth[axis]).abs() > WRONG_PX));
            }
        }
        DecodedShares {
            decoded: f64::from(found) / f64::from(all.max(1)),
            wrong: f64::from(wrong) / f64::from(found.max(1)),
        }
    }

    /// The images as they should be.
    pub fn in_order(&self) -> Vec<usize> {
        (0..self.greys.len()).collect()
    }

    /// Orders in which an image is the one before or after it, or a pair is the pair before or after it, or two pairs
    /// come one too early; each with its name and the first image that is another.
    pub fn lapses(&self) -> Vec<(String, usize, Vec<usize>)> {
        let count = self.greys.len();
        let shifted = |from: usize, images: usize, by: isize| {
            let mut order = self.in_order();
            for place in order.iter_mut().skip(from).take(images) {
                *place = place.checked_add_signed(by).filter(|other| *other < count)?;
            }
            Some((format!("{images} from {from} by {by}"), from, order))
        };
        let singles = (0..count).flat_map(|at| [shifted(at, 1, -1), shifted(at, 1, 1)]);
        // Pairs begin after white and black, and are not those.
        let pairs = (2..count.saturating_sub(1)).step_by(2).flat_map(|at| {
            let before = if at > 2 { shifted(at, 2, -2) } else { None };
            [before, shifted(at, 2, 2), (at + 4 <= count).then(|| shifted(at, 4, 2)).flatten()]
        });
        singles.chain(pairs).flatten().collect()
    }
}

/// Where light comes from by the signs of stripes less their inverse.
fn by_signs(patterns: &[Pattern], greys: &[Vec<u8>]) -> Result<Vec<Option<[f64; 2]>>> {
    let find = |wanted: Pattern| {
        let index = patterns.iter().position(|pattern| *pattern == wanted);
        index.with_context(|| format!("{wanted:?} is missing"))
    };
    let (white, black) = (&greys[find(Pattern::White)?], &greys[find(Pattern::Black)?]);
    let mut axes = [Vec::new(), Vec::new()];
    for (image, pattern) in patterns.iter().enumerate() {
        if let Pattern::GrayCode(stripes) = pattern {
            if !stripes.inverted {
                let inverse = find(Pattern::GrayCode(stripes.inverse()))?;
                axes[stripes.axis.index()].push((stripes, &greys[image], &greys[inverse]));
            }
        }
    }
    let at = |pixel: usize, axis: Axis| {
        let (mut place, mut bit) = (0_u32, 0);
        let range = f64::from(white[pixel]) - f64::from(black[pixel]);
        for (stripes, lit, inverse) in &axes[axis.index()] {
            let difference = f64::from(lit[pixel]) - f64::from(inverse[pixel]);
            let least = if stripes.width_px() > WIDE_PX { CLEAR * range } else { 3.0 };
            if range < 10.0 || difference.abs() < least {
                return None;
            }
            bit ^= u32::from(difference > 0.0);
            place = 2 * place + bit;
        }
        Some(f64::from(place))
    };
    Ok((0..white.len()).map(|pixel| Some([at(pixel, Axis::X)?, at(pixel, Axis::Y)?])).collect())
}
