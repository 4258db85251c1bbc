//! Patterns between checkerboards, see [`super::sequence`].

use std::ops::Range;

use rcs_calibration::patterns::Pattern;

use super::sequence::{PatternSequence, PatternSequenceError};
use super::timeline::{Timeline, TimelineSegment};

/// Limit of the difference of segments of the same image, as a share of the median difference of neighbours.
const ALIKE: f64 = 0.3;

/// Finds patterns with a checkerboard before, between and after them; `None` if no image recurs so often.
///
/// # Errors
/// [`PatternSequenceError::BetweenMarks`].
pub(crate) fn find(
    timeline: &Timeline,
    segments: &[TimelineSegment],
    patterns: &[Pattern],
) -> Option<Result<PatternSequence, PatternSequenceError>> {
    let marks = marks(timeline, segments);
    if 2 * marks.iter().filter(|is_mark| **is_mark).count() <= patterns.len() {
        return None;
    }
    let first = marks.iter().position(|is_mark| *is_mark)?;
    let last = marks.iter().rposition(|is_mark| *is_mark)?;
    let mut shown: Vec<Range<usize>> = Vec::new();
    for between in (first..last).collect::<Vec<_>>().split(|index| marks[*index]) {
        // The brief ones show the change from one image to the other.
        let longest = between.iter().map(|index| &segments[*index].frames).max_by_key(|frames| frames.len());
        shown.extend(longest.cloned());
    }
    if shown.len() != patterns.len() {
        return Some(Err(PatternSequenceError::BetweenMarks {
            seen: shown.len(),
            patterns: patterns.len(),
            from: timeline.time(segments[first].frames.start),
            to: timeline.time(segments[last].frames.start),
        }));
    }
    let repeated = Some([&segments[first], &segments[last]].map(|mark| mark.frames.clone()));
    Some(Ok(PatternSequence { shown: patterns.iter().copied().zip(shown).collect(), repeated, delay: None }))
}

/// Flags the segments of the image that recurs most often.
fn marks(timeline: &Timeline, segments: &[TimelineSegment]) -> Vec<bool> {
    let between = |pair: &[TimelineSegment]| timeline.difference(&pair[0].levels, &pair[1].levels);
    let mut differences: Vec<f64> = segments.windows(2).map(between).collect();
    differences.sort_by(f64::total_cmp);
    let median = differences.get(differences.len() / 2).copied().unwrap_or_default();
    let limit = (ALIKE * median).max(timeline.limit);
    let alike_to = |one: &TimelineSegment| -> Vec<bool> {
        segments.iter().map(|other| timeline.difference(&one.levels, &other.levels) <= limit).collect()
    };
    let count = |alike: &Vec<bool>| alike.iter().filter(|is_alike| **is_alike).count();
    segments.iter().map(alike_to).max_by_key(count).unwrap_or_default()
}
