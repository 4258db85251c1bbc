//! Patterns whose times are known, see [`super::sequence`].
//!
//! A pattern is seen some time after it was shown. What the camera sees before the next one is shown, since the last
//! change, is the pattern, unless the delay is longer than it was shown for; then pairs of stripes are none, see
//! [`super::pairs`].

use std::ops::Range;
use std::time::Duration;

use rcs_calibration::patterns::Pattern;

use super::footage::Shown;
use super::sequence::{Sequence, SequenceError};
use super::timeline::Timeline;

/// A pattern must be seen in so many pictures.
const LEAST_PICTURES: usize = 2;

/// Finds the patterns, of each the last time it was shown; white, the last time before the stripes.
///
/// # Errors
/// [`SequenceError::NotShown`] and [`SequenceError::NotSettled`].
pub(crate) fn find(timeline: &Timeline, shown: &[Shown], patterns: &[Pattern]) -> Result<Sequence, SequenceError> {
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
        return Err(SequenceError::NotShown { missing, patterns: patterns.len(), shown: shown.len() });
    }
    let (mut found, mut delays) = (Vec::new(), Vec::new());
    for (pattern, place) in patterns.iter().zip(places.iter().flatten()) {
        let pictures = seen(timeline, shown, *place)?;
        delays.push(timeline.time(pictures.start).saturating_sub(shown[*place].at));
        found.push((*pattern, pictures));
    }
    delays.sort_unstable();
    let white = patterns.iter().position(|pattern| *pattern == Pattern::White);
    let white_after = last_of(Pattern::White, shown.len()).filter(|after| places.iter().flatten().all(|at| at < after));
    let alike = match (white, white_after) {
        (Some(white), Some(after)) => Some([found[white].1.clone(), seen(timeline, shown, after)?]),
        _ => None,
    };
    Ok(Sequence { shown: found, alike, delay: delays.get(delays.len() / 2).copied() })
}

/// The pictures that show what was shown.
fn seen(timeline: &Timeline, shown: &[Shown], index: usize) -> Result<Range<usize>, SequenceError> {
    let at = shown[index].at;
    let until = shown.get(index + 1).map_or(Duration::MAX, |next| next.at);
    let (first, end) = (timeline.picture_at(at), timeline.picture_at(until));
    let start = (first..end).rev().find(|picture| timeline.is_cut(*picture)).unwrap_or(first);
    // A recorder that is busy gets the next picture's message before the camera's last pictures of this one.
    let late = (end..timeline.len()).take_while(|picture| !timeline.is_cut(*picture));
    let end = end + late.take(LEAST_PICTURES.saturating_sub(end.saturating_sub(start))).count();
    if end.saturating_sub(start) < LEAST_PICTURES {
        return Err(SequenceError::NotSettled { at });
    }
    Ok(start..end)
}
