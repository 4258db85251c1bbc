//! Patterns whose times are known, see [`super::sequence`].
//!
//! A pattern is seen some time after it was shown: in the frames from the last change on until the next one is shown.
//! If the delay is longer than the pattern was shown for, pairs of stripes do not match, see [`super::pairs`].

use std::ops::Range;
use std::time::Duration;

use rcs_calibration::patterns::Pattern;

use super::footage::ShownImage;
use super::sequence::{PatternSequence, PatternSequenceError};
use super::timeline::Timeline;

/// The least frames of a pattern.
const MIN_FRAMES: usize = 2;

/// Finds each pattern where it was shown last; white, where it was shown last before the stripes.
///
/// # Errors
/// [`PatternSequenceError::NotShown`] and [`PatternSequenceError::NotSettled`].
pub(crate) fn find(
    timeline: &Timeline,
    shown: &[ShownImage],
    patterns: &[Pattern],
) -> Result<PatternSequence, PatternSequenceError> {
    let last_of =
        |pattern: Pattern, before: usize| shown.get(..before)?.iter().rposition(|shown| shown.pattern == Some(pattern));
    let is_stripes = |pattern: &&Pattern| matches!(pattern, Pattern::GrayCode(_));
    let stripes = patterns.iter().filter(is_stripes).filter_map(|stripes| last_of(*stripes, shown.len()));
    let first_stripes = stripes.min().unwrap_or_default();
    let place = |pattern: &Pattern| {
        let before_stripes = (*pattern == Pattern::White).then(|| last_of(Pattern::White, first_stripes)).flatten();
        before_stripes.or_else(|| last_of(*pattern, shown.len()))
    };
    let places: Vec<Option<usize>> = patterns.iter().map(place).collect();
    let missing = places.iter().filter(|place| place.is_none()).count();
    if missing > 0 {
        return Err(PatternSequenceError::NotShown { missing, patterns: patterns.len(), shown: shown.len() });
    }
    let (mut found, mut delays) = (Vec::new(), Vec::new());
    for (pattern, place) in patterns.iter().zip(places.iter().flatten()) {
        let frames = frames_of(timeline, shown, *place)?;
        delays.push(timeline.time(frames.start).saturating_sub(shown[*place].at));
        found.push((*pattern, frames));
    }
    delays.sort_unstable();
    let white = patterns.iter().position(|pattern| *pattern == Pattern::White);
    let white_after = last_of(Pattern::White, shown.len()).filter(|after| places.iter().flatten().all(|at| at < after));
    let repeated = match (white, white_after) {
        (Some(white), Some(after)) => Some([found[white].1.clone(), frames_of(timeline, shown, after)?]),
        _ => None,
    };
    Ok(PatternSequence { shown: found, repeated, delay: delays.get(delays.len() / 2).copied() })
}

/// The frames that show an image.
fn frames_of(timeline: &Timeline, shown: &[ShownImage], index: usize) -> Result<Range<usize>, PatternSequenceError> {
    let at = shown[index].at;
    let until = shown.get(index + 1).map_or(Duration::MAX, |next| next.at);
    let (first, end) = (timeline.frame_at(at), timeline.frame_at(until));
    let start = (first..end).rev().find(|frame| timeline.is_cut(*frame)).unwrap_or(first);
    // A busy recorder may get the next image before the camera's last frames of this one.
    let late = (end..timeline.len()).take_while(|frame| !timeline.is_cut(*frame));
    let end = end + late.take(MIN_FRAMES.saturating_sub(end.saturating_sub(start))).count();
    if end.saturating_sub(start) < MIN_FRAMES {
        return Err(PatternSequenceError::NotSettled(at));
    }
    Ok(start..end)
}
