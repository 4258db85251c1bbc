//! Patterns one after the other without marks, see [`super::sequence`].
//!
//! Where the camera does not see the difference between two of them (the finest stripes and their inverse, or coarse
//! ones of which it sees a part), they are one stretch; if each was shown for the same time, that is divided.

use rcs_calibration::patterns::Pattern;

use super::pairs;
use super::sequence::{Sequence, SequenceError};
use super::timeline::{Stretch, Timeline};

/// A stretch is as long as one or several others if it is so within this share of one.
const REGULAR: f64 = 0.25;
/// The share of stretches that must be as long as the middle one.
const LEAST_REGULAR: f64 = 0.6;
/// The share of a stretch's part that is left out on both sides, since the change is not seen.
const MARGIN: f64 = 0.2;

/// Finds the patterns.
///
/// # Errors
/// [`SequenceError::NotInOrder`] and [`SequenceError::Ambiguous`].
pub(crate) fn find(
    timeline: &Timeline,
    stretches: &[Stretch],
    patterns: &[Pattern],
) -> Result<Sequence, SequenceError> {
    let divided = divide(timeline, stretches);
    for stretches in [stretches, &divided] {
        let is_found = |row: &&[Stretch]| {
            let levels: Vec<&[u8]> = row.iter().map(|stretch| stretch.look.as_slice()).collect();
            pairs::look_like(patterns, &levels)
        };
        let mut found = stretches.windows(patterns.len().max(1)).filter(is_found);
        if let Some(row) = found.next() {
            if let Some(other) = found.next() {
                let [one, other] = [row, other].map(|row| timeline.time(row[0].pictures.start));
                return Err(SequenceError::Ambiguous { one, other });
            }
            let shown = row.iter().map(|stretch| stretch.pictures.clone());
            return Ok(Sequence { shown: patterns.iter().copied().zip(shown).collect(), alike: None, delay: None });
        }
    }
    Err(SequenceError::NotInOrder { seen: stretches.len(), patterns: patterns.len() })
}

/// Divides stretches that are several times as long as the others.
fn divide(timeline: &Timeline, stretches: &[Stretch]) -> Vec<Stretch> {
    let end = |index: usize| stretches.get(index + 1).map_or(timeline.len(), |next| next.pictures.start);
    let secs = |index: usize| {
        (timeline.time(end(index)).saturating_sub(timeline.time(stretches[index].pictures.start))).as_secs_f64()
    };
    let lengths: Vec<f64> = (0..stretches.len()).map(secs).collect();
    let mut ranked = lengths.clone();
    ranked.sort_by(f64::total_cmp);
    let Some(middle) = ranked.get(ranked.len() / 2).copied().filter(|middle| *middle > 0.0) else {
        return stretches.to_vec();
    };
    let regular = lengths.iter().filter(|length| (*length / middle - 1.0).abs() <= REGULAR).count();
    if (regular as f64) < LEAST_REGULAR * lengths.len() as f64 {
        return stretches.to_vec();
    }
    let mut divided = Vec::new();
    for (index, stretch) in stretches.iter().enumerate() {
        let times = lengths[index] / middle;
        let parts = times.round();
        if parts < 2.0 || (times - parts).abs() > REGULAR {
            divided.push(stretch.clone());
            continue;
        }
        let (first, length) = (stretch.pictures.start as f64, (end(index) - stretch.pictures.start) as f64 / parts);
        for part in 0..parts as usize {
            let at = |share: f64| (first + (part as f64 + share) * length).round() as usize;
            let pictures = at(MARGIN)..at(1.0 - MARGIN).min(stretch.pictures.end);
            if pictures.len() >= 2 {
                divided.push(timeline.stretch(pictures));
            }
        }
    }
    divided
}
