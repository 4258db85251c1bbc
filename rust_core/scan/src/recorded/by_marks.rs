//! Patterns between marks, see [`super::sequence`].

use std::ops::Range;

use rcs_calibration::patterns::Pattern;

use super::sequence::{Sequence, SequenceError};
use super::timeline::{Stretch, Timeline};

/// Stretches that differ less than this share of what neighbours typically differ by show the same.
const ALIKE: f64 = 0.3;

/// Finds patterns with a mark before, between and after them; none if nothing recurs so often.
///
/// # Errors
/// [`SequenceError::BetweenMarks`].
pub(crate) fn find(
    timeline: &Timeline,
    stretches: &[Stretch],
    patterns: &[Pattern],
) -> Option<Result<Sequence, SequenceError>> {
    let marks = marks(timeline, stretches);
    if 2 * marks.iter().filter(|is_mark| **is_mark).count() <= patterns.len() {
        return None;
    }
    let first = marks.iter().position(|is_mark| *is_mark)?;
    let last = marks.iter().rposition(|is_mark| *is_mark)?;
    let mut shown: Vec<Range<usize>> = Vec::new();
    for between in (first..last).collect::<Vec<_>>().split(|index| marks[*index]) {
        // What is brief is the change from one to the other.
        let longest = between.iter().map(|index| &stretches[*index].pictures).max_by_key(|pictures| pictures.len());
        shown.extend(longest.cloned());
    }
    if shown.len() != patterns.len() {
        return Some(Err(SequenceError::BetweenMarks {
            seen: shown.len(),
            patterns: patterns.len(),
            from: timeline.time(stretches[first].pictures.start),
            to: timeline.time(stretches[last].pictures.start),
        }));
    }
    let alike = Some([&stretches[first], &stretches[last]].map(|mark| mark.pictures.clone()));
    Some(Ok(Sequence { shown: patterns.iter().copied().zip(shown).collect(), alike, delay: None }))
}

/// Which stretches show what recurs most often.
fn marks(timeline: &Timeline, stretches: &[Stretch]) -> Vec<bool> {
    let between = |pair: &[Stretch]| timeline.difference(&pair[0].look, &pair[1].look);
    let mut typical: Vec<f64> = stretches.windows(2).map(between).collect();
    typical.sort_by(f64::total_cmp);
    let typical = typical.get(typical.len() / 2).copied().unwrap_or_default();
    let limit = (ALIKE * typical).max(timeline.limit());
    let alike_to = |one: &Stretch| -> Vec<bool> {
        stretches.iter().map(|other| timeline.difference(&one.look, &other.look) <= limit).collect()
    };
    let count = |alike: &Vec<bool>| alike.iter().filter(|is_alike| **is_alike).count();
    stretches.iter().map(alike_to).max_by_key(count).unwrap_or_default()
}
