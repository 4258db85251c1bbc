//! A recording's pictures at a sample of pixels, and where one differs from the one before.

use std::ops::Range;
use std::time::Duration;

use super::footage::Footage;
use super::sequence::SequenceError;
use crate::compare::{difference, mean, sample};
use crate::failure::{check_size, ScanFailure};
use crate::light::average;

/// One of so many pixels of [`sample`] is looked at.
const EVERY: usize = 4;
/// The longest recording, pictures: half an hour at 30 Hz.
const MOST_PICTURES: usize = 54_000;
/// A pixel that changes by fewer levels shows nothing.
const CHANGING_LEVELS: u8 = 12;
/// The share of pixels that must change.
const LEAST_CHANGING: f64 = 0.005;
/// Differences of pictures that show the same: a quarter is below noise, and none above so many times that and so many
/// levels, also where white is shown, which is noisier.
const QUIET_SHARE: f64 = 0.25;
const LEAST_NOISY: f64 = 0.4;
const CUT_FACTOR: f64 = 2.0;
const CUT_LEVELS: f64 = 1.0;
/// What a stretch looks like is the mean of its last pictures, so many at most.
const LOOKED_AT: usize = 5;

/// The pictures of a recording at the pixels that change.
#[derive(Debug)]
pub(crate) struct Timeline {
    times: Vec<Duration>,
    looks: Vec<Vec<u8>>,
    /// All indices of a look.
    at: Vec<usize>,
    /// By how much a picture differs from the one before; nothing for the first.
    differences: Vec<f64>,
    /// Pictures that differ by more show something else.
    limit: f64,
}

/// Pictures in a row that show the same.
#[derive(Debug, Clone)]
pub(crate) struct Stretch {
    /// Their numbers.
    pub(crate) pictures: Range<usize>,
    /// Their mean where anything changes in the recording.
    pub(crate) look: Vec<u8>,
}

impl Timeline {
    /// Reads all pictures.
    ///
    /// # Errors
    /// [`ScanFailure`]: there are none, or nothing changes in them, or they cannot be read.
    pub(crate) fn read(footage: &dyn Footage) -> Result<Self, ScanFailure> {
        let camera_px = footage.lens().size_px;
        let pixels: Vec<usize> = sample(camera_px).into_iter().step_by(EVERY).collect();
        let (mut times, mut looks) = (Vec::new(), Vec::new());
        footage.pictures(&|_| true, &mut |_, time, size_px, grey| {
            check_size("picture", size_px, grey.len(), camera_px)?;
            if looks.len() >= MOST_PICTURES {
                return Err(SequenceError::TooLong { most: MOST_PICTURES }.into());
            }
            times.push(time);
            looks.push(pixels.iter().map(|pixel| grey[*pixel]).collect::<Vec<u8>>());
            Ok(())
        })?;
        let changing = changing(&looks);
        if changing.len() < 2 || (changing.len() as f64) < LEAST_CHANGING * pixels.len() as f64 {
            return Err(ScanFailure::NoLight { screen: footage.name() });
        }
        for look in &mut looks {
            *look = changing.iter().map(|pixel| look[*pixel]).collect();
        }
        Ok(Self::new(times, looks))
    }

    /// Of looks of the same number of pixels.
    pub(crate) fn new(times: Vec<Duration>, looks: Vec<Vec<u8>>) -> Self {
        let at: Vec<usize> = (0..looks.first().map_or(0, Vec::len)).collect();
        let between = looks.windows(2).map(|pair| difference(&pair[0], &pair[1], &at));
        let differences: Vec<f64> = std::iter::once(0.0).chain(between).collect();
        let quiet = quiet(&differences);
        Self { times, looks, at, differences, limit: CUT_FACTOR * quiet + CUT_LEVELS }
    }

    /// How many pictures there are.
    pub(crate) fn len(&self) -> usize {
        self.times.len()
    }

    /// When a picture was recorded; the last one's time for numbers beyond.
    pub(crate) fn time(&self, picture: usize) -> Duration {
        self.times.get(picture).or(self.times.last()).copied().unwrap_or_default()
    }

    /// The first picture at a time or later.
    pub(crate) fn picture_at(&self, time: Duration) -> usize {
        self.times.partition_point(|at| *at < time)
    }

    /// Whether a picture shows something else than the one before.
    pub(crate) fn is_cut(&self, picture: usize) -> bool {
        self.differences[picture] > self.limit
    }

    /// Whether two looks are those of the same thing.
    pub(crate) fn difference(&self, one: &[u8], other: &[u8]) -> f64 {
        difference(one, other, &self.at)
    }

    /// The largest difference of pictures that show the same, levels.
    pub(crate) fn limit(&self) -> f64 {
        self.limit
    }

    /// How much neighbours differ within a stretch: the root mean square, levels.
    pub(crate) fn noise(&self, pictures: &Range<usize>) -> f64 {
        let within = self.differences.get(pictures.start + 1..pictures.end).unwrap_or_default();
        let squares = within.iter().map(|difference| difference * difference).sum::<f64>();
        (squares / within.len().max(1) as f64).sqrt()
    }

    /// The mean level of a picture.
    pub(crate) fn level(&self, picture: usize) -> f64 {
        self.looks.get(picture).map_or(0.0, |look| mean(look, &self.at))
    }

    /// These pictures as a stretch.
    pub(crate) fn stretch(&self, pictures: Range<usize>) -> Stretch {
        let first = pictures.start.max(pictures.end.saturating_sub(LOOKED_AT));
        let look = average(self.looks.get(first..pictures.end).unwrap_or_default().iter());
        Stretch { pictures, look }
    }

    /// All stretches of two pictures and more, in the order of time. What is left out shows a change; so may the last
    /// of a stretch, which is left out if there are more.
    pub(crate) fn stretches(&self) -> Vec<Stretch> {
        let cuts = (1..self.len()).filter(|picture| self.is_cut(*picture));
        let starts: Vec<usize> = std::iter::once(0).chain(cuts).collect();
        let ends = starts.iter().skip(1).copied().chain([self.len()]);
        let ranges = starts.iter().zip(ends).map(|(start, end)| *start..end);
        let without_last = |range: Range<usize>| range.start..range.end - usize::from(range.len() > 2);
        ranges.filter(|range| range.len() >= 2).map(|range| self.stretch(without_last(range))).collect()
    }
}

/// The difference that a quarter of all are below. A driver that repeats pictures makes many that are nothing and tell
/// nothing of noise; pictures without noise make most of them nothing.
fn quiet(differences: &[f64]) -> f64 {
    let mut ranked = differences.to_vec();
    ranked.sort_by(f64::total_cmp);
    let noisy = &ranked[ranked.partition_point(|difference| *difference <= 0.0)..];
    let counted = if noisy.len() as f64 >= LEAST_NOISY * ranked.len() as f64 { noisy } else { &ranked };
    counted.get((QUIET_SHARE * counted.len() as f64) as usize).copied().unwrap_or_default()
}

/// The pixels that change.
fn changing(looks: &[Vec<u8>]) -> Vec<usize> {
    let Some(first) = looks.first() else { return Vec::new() };
    let mut ranges: Vec<(u8, u8)> = first.iter().map(|level| (*level, *level)).collect();
    for look in looks {
        for ((least, most), level) in ranges.iter_mut().zip(look) {
            (*least, *most) = ((*least).min(*level), (*most).max(*level));
        }
    }
    (0..ranges.len()).filter(|pixel| ranges[*pixel].1 - ranges[*pixel].0 > CHANGING_LEVELS).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pictures of 100 pixels with these levels, and noise of a level or two.
    fn timeline(levels: &[u8], noise: u8) -> Timeline {
        let noisy = |picture: usize, pixel: usize| ((37 * pixel + 101 * picture) % 256) as u8 % (noise + 1);
        let look = |(picture, level): (usize, &u8)| (0..100).map(|pixel| level + noisy(picture, pixel)).collect();
        let looks = levels.iter().enumerate().map(look).collect();
        Timeline::new((0..levels.len() as u64).map(Duration::from_secs).collect(), looks)
    }

    #[test]
    fn a_stretch_ends_where_the_next_looks_different() {
        for noise in [0, 2] {
            let timeline = timeline(&[10, 10, 10, 10, 60, 120, 120, 120, 120, 120, 10, 10], noise);
            let ranges: Vec<Range<usize>> = timeline.stretches().into_iter().map(|stretch| stretch.pictures).collect();
            assert_eq!(ranges, [0..3, 5..9, 10..12], "{noise}");
            assert!(timeline.is_cut(4) && timeline.is_cut(5) && !timeline.is_cut(6));
        }
    }

    #[test]
    fn repeated_pictures_tell_nothing_of_noise() {
        assert_eq!(quiet(&[0.0, 1.5, 0.0, 1.4, 0.0, 1.6, 0.0, 50.0]), 1.5);
        assert_eq!(quiet(&[0.0, 0.0, 0.0, 50.0, 0.0, 0.0, 0.0, 50.0]), 0.0);
        assert_eq!(quiet(&[]), 0.0);
    }

    #[test]
    fn times_lead_to_pictures() {
        let timeline = timeline(&[10, 10, 60], 0);
        let pictures = [0, 1, 2, 9].map(|secs| timeline.picture_at(Duration::from_secs(secs)));
        assert_eq!((pictures, timeline.picture_at(Duration::MAX)), ([0, 1, 2, 3], 3));
        assert_eq!([1, 7].map(|picture| timeline.time(picture).as_secs()), [1, 2]);
    }
}
