//! Patterns one after the other without checkerboards, see [`super::sequence`].
//!
//! Where the camera does not see the difference between two of them (the finest stripes and their inverse, or coarse
//! ones of which it sees a part), they are one segment, which is divided if each was shown for the same time.

use rcs_calibration::patterns::Pattern;

use super::pairs;
use super::sequence::{PatternSequence, PatternSequenceError};
use super::timeline::{Timeline, TimelineSegment};

/// Tolerance of the length of a segment, as a share of the median length.
const REGULAR: f64 = 0.25;
/// The least share of segments of the median length.
const MIN_REGULAR: f64 = 0.6;
/// The share of a divided segment's part that is dropped on both sides, because the change is not seen.
const MARGIN: f64 = 0.2;

/// Finds the patterns.
///
/// # Errors
/// [`PatternSequenceError::NotInOrder`] and [`PatternSequenceError::Ambiguous`].
pub(crate) fn find(
    timeline: &Timeline,
    segments: &[TimelineSegment],
    patterns: &[Pattern],
) -> Result<PatternSequence, PatternSequenceError> {
    let divided = divide(timeline, segments);
    for segments in [segments, &divided] {
        let is_found = |row: &&[TimelineSegment]| {
            let levels: Vec<&[u8]> = row.iter().map(|segment| segment.levels.as_slice()).collect();
            pairs::are_plausible(patterns, &levels)
        };
        let mut found = segments.windows(patterns.len().max(1)).filter(is_found);
        if let Some(row) = found.next() {
            if let Some(other) = found.next() {
                let [one, other] = [row, other].map(|row| timeline.time(row[0].frames.start));
                return Err(PatternSequenceError::Ambiguous(one, other));
            }
            let shown = row.iter().map(|segment| segment.frames.clone());
            return Ok(PatternSequence {
                shown: patterns.iter().copied().zip(shown).collect(),
                repeated: None,
                delay: None,
            });
        }
    }
    Err(PatternSequenceError::NotInOrder { seen: segments.len(), patterns: patterns.len() })
}

/// Divides segments that are several times as long as the median.
fn divide(timeline: &Timeline, segments: &[TimelineSegment]) -> Vec<TimelineSegment> {
    let end = |index: usize| segments.get(index + 1).map_or(timeline.len(), |next| next.frames.start);
    let secs = |index: usize| {
        (timeline.time(end(index)).saturating_sub(timeline.time(segments[index].frames.start))).as_secs_f64()
    };
    let lengths: Vec<f64> = (0..segments.len()).map(secs).collect();
    let mut ranked = lengths.clone();
    ranked.sort_by(f64::total_cmp);
    let Some(median) = ranked.get(ranked.len() / 2).copied().filter(|median| *median > 0.0) else {
        return segments.to_vec();
    };
    let regular = lengths.iter().filter(|length| (*length / median - 1.0).abs() <= REGULAR).count();
    if (regular as f64) < MIN_REGULAR * lengths.len() as f64 {
        return segments.to_vec();
    }
    let mut divided = Vec::new();
    for (index, segment) in segments.iter().enumerate() {
        let times = lengths[index] / median;
        let parts = times.round();
        if parts < 2.0 || (times - parts).abs() > REGULAR {
            divided.push(segment.clone());
            continue;
        }
        let (first, length) = (segment.frames.start as f64, (end(index) - segment.frames.start) as f64 / parts);
        for part in 0..parts as usize {
            let at = |share: f64| (first + (part as f64 + share) * length).round() as usize;
            let frames = at(MARGIN)..at(1.0 - MARGIN).min(segment.frames.end);
            if frames.len() >= 2 {
                divided.push(timeline.segment(frames));
            }
        }
    }
    divided
}
