//! Comparison of the camera's images at a sample of pixels.

use std::collections::VecDeque;

use crate::failure::ScanFailure;

/// Most pixels that are compared.
const MAX_PIXELS: usize = 20_000;
/// Differences between consecutive frames that must be alike in a settled image,
const ALIKE_DIFFERENCES: usize = 4;
/// up to this factor and this number of levels.
const ALIKE_FACTOR: f64 = 1.5;
const ALIKE_LEVELS: f64 = 1.0;
/// Limit of the difference of two frames of the same image: a factor of the noise, and levels.
const NOISE_FACTOR: f64 = 1.3;
const NOISE_LEVELS: f64 = 0.5;
/// A changed pixel differs by this number of levels, and this multiple of the noise.
const CHANGED_LEVELS: f64 = 8.0;
const CHANGED_NOISE: f64 = 4.0;
/// Limit of a change of brightness during a scan, as a share.
const MAX_BRIGHTNESS: f64 = 0.05;
/// Limit of the share of lit pixels that differ between two images of the same pattern.
pub(crate) const MAX_MOVED: f64 = 0.02;
/// The level of clipped pixels.
pub(crate) const CLIPPED: u8 = 255;

/// Indices of pixels all over an image of this size, in all of its columns.
pub(crate) fn sample(size_px: [u32; 2]) -> Vec<usize> {
    let [width, height] = size_px.map(|side| side as usize);
    let share_divisor = |step: usize| (2..=step).any(|by| step.is_multiple_of(by) && width.is_multiple_of(by));
    let mut step = (width * height / MAX_PIXELS).max(1);
    while share_divisor(step) {
        step += 1;
    }
    (0..width * height).step_by(step).collect()
}

/// The mean level at some pixels.
pub(crate) fn mean(grey: &[u8], at: &[usize]) -> f64 {
    at.iter().map(|pixel| f64::from(grey[*pixel])).sum::<f64>() / at.len().max(1) as f64
}

/// The root mean square difference at some pixels, levels.
pub(crate) fn difference(one: &[u8], other: &[u8], at: &[usize]) -> f64 {
    let square = |pixel: &usize| (f64::from(one[*pixel]) - f64::from(other[*pixel])).powi(2);
    (at.iter().map(square).sum::<f64>() / at.len().max(1) as f64).sqrt()
}

/// `true` if two frames show the same image. `noise` is the difference of two such frames.
pub(crate) fn is_same(one: &[u8], other: &[u8], at: &[usize], noise: f64) -> bool {
    difference(one, other, at) <= NOISE_FACTOR * noise + NOISE_LEVELS
}

/// The change from an image to a later one of the same pattern.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ImageChange {
    /// Gain in brightness, as a share.
    pub(crate) brightness: f64,
    /// The share of pixels that have changed otherwise.
    pub(crate) moved: f64,
}

impl ImageChange {
    /// Compares two images. `noise` is the difference of two frames of the same image.
    pub(crate) fn between(before: &[u8], after: &[u8], at: &[usize], noise: f64) -> Self {
        let at: Vec<usize> =
            at.iter().copied().filter(|pixel| before[*pixel] != CLIPPED && after[*pixel] != CLIPPED).collect();
        let gain = mean(after, &at) / mean(before, &at).max(1.0);
        let limit = CHANGED_LEVELS.max(CHANGED_NOISE * noise);
        let has_changed =
            |pixel: &&usize| (f64::from(after[**pixel]) - gain * f64::from(before[**pixel])).abs() > limit;
        let moved = at.iter().filter(has_changed).count() as f64 / at.len().max(1) as f64;
        Self { brightness: gain - 1.0, moved }
    }

    /// Checks that both images may belong to a scan.
    ///
    /// # Errors
    /// [`ScanFailure::Unsteady`] and [`ScanFailure::Moved`].
    pub(crate) fn check(&self) -> Result<(), ScanFailure> {
        if self.brightness.abs() > MAX_BRIGHTNESS {
            return Err(ScanFailure::Unsteady(self.brightness.abs()));
        }
        if self.moved > MAX_MOVED {
            return Err(ScanFailure::Moved(self.moved));
        }
        Ok(())
    }
}

/// Detects when frames have settled, without knowing their noise: consecutive differences are alike.
#[derive(Debug, Default)]
pub(crate) struct SettledDetector {
    previous: Option<Vec<u8>>,
    differences: VecDeque<f64>,
}

impl SettledDetector {
    /// Adds the next frame.
    pub(crate) fn push(&mut self, grey: &[u8], at: &[usize]) {
        if let Some(previous) = &self.previous {
            self.differences.push_back(difference(previous, grey, at));
            if self.differences.len() > ALIKE_DIFFERENCES {
                self.differences.pop_front();
            }
        }
        self.previous = Some(grey.to_vec());
    }

    /// `true` if the last frames are settled.
    pub(crate) fn is_settled(&self) -> bool {
        let least = self.differences.iter().copied().fold(f64::INFINITY, f64::min);
        self.differences.len() == ALIKE_DIFFERENCES && self.noise() <= ALIKE_FACTOR * least + ALIKE_LEVELS
    }

    /// The largest of the last differences, levels.
    pub(crate) fn noise(&self) -> f64 {
        self.differences.iter().copied().fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_has_pixels_of_all_columns() {
        assert_eq!(sample([10, 10]).len(), 100);
        let columns: std::collections::HashSet<usize> =
            sample([640, 480]).into_iter().map(|pixel| pixel % 640).collect();
        assert_eq!(columns.len(), 640);
    }

    #[test]
    fn a_change_of_brightness_is_no_motion() {
        let before: Vec<u8> = (0..1000).map(|i| 50 + (i * 37 % 100) as u8).collect();
        let brighter: Vec<u8> = before.iter().map(|level| (f64::from(*level) * 1.2).round() as u8).collect();
        let moved: Vec<u8> = (0..1000).map(|i| before[(i + 1) % 1000]).collect();
        let at: Vec<usize> = (0..1000).collect();
        let change = ImageChange::between(&before, &brighter, &at, 1.0);
        assert!((change.brightness - 0.2).abs() < 0.01 && change.moved == 0.0, "{change:?}");
        let change = ImageChange::between(&before, &moved, &at, 1.0);
        assert!(change.brightness.abs() < 0.01 && change.moved > 0.9, "{change:?}");
    }

    #[test]
    fn frames_are_settled_when_differences_are_alike() {
        let mut detector = SettledDetector::default();
        for level in [0, 0, 60, 160, 200, 201, 200] {
            detector.push(&[level; 9], &[0, 4, 8]);
        }
        assert!(!detector.is_settled());
        for level in [201, 200] {
            detector.push(&[level; 9], &[0, 4, 8]);
        }
        assert!(detector.is_settled() && detector.noise() == 1.0);
    }
}
