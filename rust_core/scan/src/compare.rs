//! Comparing the camera's pictures at a sample of pixels.

use std::collections::VecDeque;

use crate::failure::ScanFailure;

/// Pixels that are compared, at most.
const MOST_PIXELS: usize = 20_000;
/// So many differences between frames in a row must be alike for the picture to be at rest,
const LIKE_DIFFERENCES: usize = 4;
/// up to this factor and so many levels.
const LIKE_FACTOR: f64 = 1.5;
const LIKE_LEVELS: f64 = 1.0;
/// Two frames of the same are farther apart than noise by no more than this factor and so many levels.
const NOISE_FACTOR: f64 = 1.3;
const NOISE_LEVELS: f64 = 0.5;
/// A pixel has changed if it differs by so many levels, and by so many times the noise.
const CHANGED_LEVELS: f64 = 8.0;
const CHANGED_NOISE: f64 = 4.0;
/// Brightness may change by this share during a scan.
const MOST_BRIGHTNESS: f64 = 0.05;
/// The share of lit pixels that may differ between two pictures of the same.
pub(crate) const MOST_MOVED: f64 = 0.02;
/// The level of clipped pixels.
pub(crate) const CLIPPED: u8 = 255;

/// Indices of pixels all over a picture of this size, in all of its columns.
pub(crate) fn sample(size_px: [u32; 2]) -> Vec<usize> {
    let [width, height] = size_px.map(|side| side as usize);
    let share_divisor = |step: usize| (2..=step).any(|by| step.is_multiple_of(by) && width.is_multiple_of(by));
    let mut step = (width * height / MOST_PIXELS).max(1);
    while share_divisor(step) {
        step += 1;
    }
    (0..width * height).step_by(step).collect()
}

/// The mean level at some pixels.
pub(crate) fn mean(grey: &[u8], at: &[usize]) -> f64 {
    at.iter().map(|pixel| f64::from(grey[*pixel])).sum::<f64>() / at.len().max(1) as f64
}

/// The root of the mean squared difference at some pixels, levels.
pub(crate) fn difference(one: &[u8], other: &[u8], at: &[usize]) -> f64 {
    let square = |pixel: &usize| (f64::from(one[*pixel]) - f64::from(other[*pixel])).powi(2);
    (at.iter().map(square).sum::<f64>() / at.len().max(1) as f64).sqrt()
}

/// Whether two frames show the same. `noise` is the difference of two frames at rest.
pub(crate) fn is_same(one: &[u8], other: &[u8], at: &[usize], noise: f64) -> bool {
    difference(one, other, at) <= NOISE_FACTOR * noise + NOISE_LEVELS
}

/// How a picture differs from an earlier one of the same pattern.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Change {
    /// By which share it is brighter.
    pub(crate) brightness: f64,
    /// The share of pixels that have changed otherwise.
    pub(crate) moved: f64,
}

impl Change {
    /// Between two pictures. `noise` is the difference of two frames at rest.
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

    /// Whether both may belong to a scan.
    ///
    /// # Errors
    /// [`ScanFailure::Unsteady`] and [`ScanFailure::Moved`].
    pub(crate) fn check(&self) -> Result<(), ScanFailure> {
        if self.brightness.abs() > MOST_BRIGHTNESS {
            return Err(ScanFailure::Unsteady { change: self.brightness.abs() });
        }
        if self.moved > MOST_MOVED {
            return Err(ScanFailure::Moved { share: self.moved });
        }
        Ok(())
    }
}

/// Finds out when frames have come to rest without knowing their noise: differences in a row are alike.
#[derive(Debug, Default)]
pub(crate) struct Rest {
    previous: Option<Vec<u8>>,
    differences: VecDeque<f64>,
}

impl Rest {
    /// Takes the next frame.
    pub(crate) fn push(&mut self, grey: &[u8], at: &[usize]) {
        if let Some(previous) = &self.previous {
            self.differences.push_back(difference(previous, grey, at));
            if self.differences.len() > LIKE_DIFFERENCES {
                self.differences.pop_front();
            }
        }
        self.previous = Some(grey.to_vec());
    }

    /// Whether the last frames are at rest.
    pub(crate) fn is_reached(&self) -> bool {
        let least = self.differences.iter().copied().fold(f64::INFINITY, f64::min);
        self.differences.len() == LIKE_DIFFERENCES && self.noise() <= LIKE_FACTOR * least + LIKE_LEVELS
    }

    /// The largest of the last differences.
    pub(crate) fn noise(&self) -> f64 {
        self.differences.iter().copied().fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_meets_all_columns() {
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
        let change = Change::between(&before, &brighter, &at, 1.0);
        assert!((change.brightness - 0.2).abs() < 0.01 && change.moved == 0.0, "{change:?}");
        let change = Change::between(&before, &moved, &at, 1.0);
        assert!(change.brightness.abs() < 0.01 && change.moved > 0.9, "{change:?}");
    }

    #[test]
    fn rest_is_reached_when_differences_are_alike() {
        let mut rest = Rest::default();
        for level in [0, 0, 60, 160, 200, 201, 200] {
            rest.push(&[level; 9], &[0, 4, 8]);
        }
        assert!(!rest.is_reached());
        for level in [201, 200] {
            rest.push(&[level; 9], &[0, 4, 8]);
        }
        assert!(rest.is_reached() && rest.noise() == 1.0);
    }
}
