//! The frames of a recording at a sample of pixels, divided into segments where one differs from the one before.

use std::ops::Range;
use std::time::Duration;

use super::footage::BagFootage;
use super::sequence::PatternSequenceError;
use crate::compare::{difference, sample};
use crate::failure::{check_size, ScanFailure};
use crate::light::average;

/// Step through the pixels of [`sample`].
const EVERY: usize = 4;
/// The longest recording, frames: half an hour at 30 Hz.
const MAX_FRAMES: usize = 54_000;
/// The least change of a pixel that shows patterns, levels.
const CHANGING_LEVELS: u8 = 12;
/// The least share of such pixels.
const MIN_CHANGING: f64 = 0.005;
/// Differences of frames of the same image: a quarter is below noise, and none above this multiple of that and this
/// number of levels, even in white, which is noisier.
const QUIET_SHARE: f64 = 0.25;
const MIN_NOISY: f64 = 0.4;
const CUT_FACTOR: f64 = 2.0;
const CUT_LEVELS: f64 = 1.0;
/// Most frames, the last ones, whose mean represents a segment.
const AVERAGED: usize = 5;

/// The frames of a recording at the pixels that change.
#[derive(Debug)]
pub(crate) struct Timeline {
    times: Vec<Duration>,
    levels: Vec<Vec<u8>>,
    /// All indices of a frame's levels.
    at: Vec<usize>,
    /// Difference of each frame from the one before; 0 for the first.
    differences: Vec<f64>,
    /// Largest difference of frames of the same image, levels.
    pub(crate) limit: f64,
}

/// Consecutive frames of the same image.
#[derive(Debug, Clone)]
pub(crate) struct TimelineSegment {
    /// The frames' numbers.
    pub(crate) frames: Range<usize>,
    /// Their mean at the pixels that change in the recording.
    pub(crate) levels: Vec<u8>,
}

impl Timeline {
    /// Reads all frames.
    ///
    /// # Errors
    /// [`ScanFailure`]: there are none, nothing changes in them, or they are unreadable.
    pub(crate) fn read(footage: &BagFootage) -> Result<Self, ScanFailure> {
        let camera_px = footage.lens.size_px;
        let pixels: Vec<usize> = sample(camera_px).into_iter().step_by(EVERY).collect();
        let (mut times, mut levels) = (Vec::new(), Vec::new());
        footage.frames(&|_| true, &mut |_, time, size_px, grey| {
            check_size("picture", size_px, grey.len(), camera_px)?;
            if levels.len() >= MAX_FRAMES {
                return Err(PatternSequenceError::TooLong(MAX_FRAMES).into());
            }
            times.push(time);
            levels.push(pixels.iter().map(|pixel| grey[*pixel]).collect::<Vec<u8>>());
            Ok(())
        })?;
        let changing = changing(&levels);
        if changing.len() < 2 || (changing.len() as f64) < MIN_CHANGING * pixels.len() as f64 {
            return Err(ScanFailure::NoLight(footage.name.clone()));
        }
        for frame in &mut levels {
            *frame = changing.iter().map(|pixel| frame[*pixel]).collect();
        }
        Ok(Self::new(times, levels))
    }

    /// From the levels of frames at the same pixels.
    fn new(times: Vec<Duration>, levels: Vec<Vec<u8>>) -> Self {
        let at: Vec<usize> = (0..levels.first().map_or(0, Vec::len)).collect();
        let between = levels.windows(2).map(|pair| difference(&pair[0], &pair[1], &at));
        let differences: Vec<f64> = std::iter::once(0.0).chain(between).collect();
        let quiet = quiet(&differences);
        Self { times, levels, at, differences, limit: CUT_FACTOR * quiet + CUT_LEVELS }
    }

    /// Number of frames.
    pub(crate) fn len(&self) -> usize {
        self.times.len()
    }

    /// Time of a frame; the last one's for numbers beyond.
    pub(crate) fn time(&self, frame: usize) -> Duration {
        self.times.get(frame).or(self.times.last()).copied().unwrap_or_default()
    }

    /// The first frame at a time or later.
    pub(crate) fn frame_at(&self, time: Duration) -> usize {
        self.times.partition_point(|at| *at < time)
    }

    /// `true` if a frame shows another image than the one before.
    pub(crate) fn is_cut(&self, frame: usize) -> bool {
        self.differences[frame] > self.limit
    }

    /// The difference of two frames or segments, levels.
    pub(crate) fn difference(&self, one: &[u8], other: &[u8]) -> f64 {
        difference(one, other, &self.at)
    }

    /// The root mean square difference of consecutive frames, levels.
    pub(crate) fn noise(&self, frames: &Range<usize>) -> f64 {
        let within = self.differences.get(frames.start + 1..frames.end).unwrap_or_default();
        let squares = within.iter().map(|difference| difference * difference).sum::<f64>();
        (squares / within.len().max(1) as f64).sqrt()
    }

    /// These frames as a segment.
    pub(crate) fn segment(&self, frames: Range<usize>) -> TimelineSegment {
        let first = frames.start.max(frames.end.saturating_sub(AVERAGED));
        let levels = average(self.levels.get(first..frames.end).unwrap_or_default().iter());
        TimelineSegment { frames, levels }
    }

    /// All segments of two frames and more, in the order of time. Shorter ones show a change; so may the last frame of
    /// a segment, which is dropped if there are more.
    pub(crate) fn segments(&self) -> Vec<TimelineSegment> {
        let cuts = (1..self.len()).filter(|frame| self.is_cut(*frame));
        let starts: Vec<usize> = std::iter::once(0).chain(cuts).collect();
        let ends = starts.iter().skip(1).copied().chain([self.len()]);
        let ranges = starts.iter().zip(ends).map(|(start, end)| *start..end);
        let without_last = |range: Range<usize>| range.start..range.end - usize::from(range.len() > 2);
        ranges.filter(|range| range.len() >= 2).map(|range| self.segment(without_last(range))).collect()
    }
}

/// The first quartile of the differences. Those of frames that a driver repeats are 0 and do not count, unless most
/// are, as without noise.
fn quiet(differences: &[f64]) -> f64 {
    let mut ranked = differences.to_vec();
    ranked.sort_by(f64::total_cmp);
    let noisy = &ranked[ranked.partition_point(|difference| *difference <= 0.0)..];
    let counted = if noisy.len() as f64 >= MIN_NOISY * ranked.len() as f64 { noisy } else { &ranked };
    counted.get((QUIET_SHARE * counted.len() as f64) as usize).copied().unwrap_or_default()
}

/// The pixels that change.
fn changing(frames: &[Vec<u8>]) -> Vec<usize> {
    let Some(first) = frames.first() else { return Vec::new() };
    let mut ranges: Vec<(u8, u8)> = first.iter().map(|level| (*level, *level)).collect();
    for frame in frames {
        for ((least, most), level) in ranges.iter_mut().zip(frame) {
            (*least, *most) = ((*least).min(*level), (*most).max(*level));
        }
    }
    (0..ranges.len()).filter(|pixel| ranges[*pixel].1 - ranges[*pixel].0 > CHANGING_LEVELS).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames of 100 pixels with these levels and noise.
    fn timeline(levels: &[u8], noise: u8) -> Timeline {
        let noisy = |frame: usize, pixel: usize| ((37 * pixel + 101 * frame) % 256) as u8 % (noise + 1);
        let frame = |(number, level): (usize, &u8)| (0..100).map(|pixel| level + noisy(number, pixel)).collect();
        let frames = levels.iter().enumerate().map(frame).collect();
        Timeline::new((0..levels.len() as u64).map(Duration::from_secs).collect(), frames)
    }

    #[test]
    fn a_segment_ends_where_the_image_changes() {
        for noise in [0, 2] {
            let timeline = timeline(&[10, 10, 10, 10, 60, 120, 120, 120, 120, 120, 10, 10], noise);
            let ranges: Vec<Range<usize>> = timeline.segments().into_iter().map(|segment| segment.frames).collect();
            assert_eq!(ranges, [0..3, 5..9, 10..12], "{noise}");
            assert!(timeline.is_cut(4) && timeline.is_cut(5) && !timeline.is_cut(6));
        }
    }

    #[test]
    fn repeated_frames_do_not_count_as_quiet() {
        assert_eq!(quiet(&[0.0, 1.5, 0.0, 1.4, 0.0, 1.6, 0.0, 50.0]), 1.5);
        assert_eq!(quiet(&[0.0, 0.0, 0.0, 50.0, 0.0, 0.0, 0.0, 50.0]), 0.0);
        assert_eq!(quiet(&[]), 0.0);
    }

    #[test]
    fn frames_are_found_by_time() {
        let timeline = timeline(&[10, 10, 60], 0);
        let frames = [0, 1, 2, 9].map(|secs| timeline.frame_at(Duration::from_secs(secs)));
        assert_eq!((frames, timeline.frame_at(Duration::MAX)), ([0, 1, 2, 3], 3));
        assert_eq!([1, 7].map(|frame| timeline.time(frame).as_secs()), [1, 2]);
    }
}
