//! Which pictures of a recording show which pattern.
//!
//! Three ways, the surest first:
//! - [`super::by_topic`]: the bag also has the topic on which the patterns were published.
//! - [`super::by_marks`]: a checkerboard was shown between the patterns, as `show --pause` does. A checkerboard's look
//!   differs from that of any stripes in half of its fields, whatever part of the picture the camera sees, and however
//!   blurred the stripes are. So the patterns lie between what recurs, and their number tells whether all were seen.
//! - [`super::by_order`]: the patterns follow one another, and a picture ends where the next one looks different.

use std::ops::Range;
use std::time::Duration;

use rcs_calibration::patterns::Pattern;

/// Where a recording shows each pattern.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sequence {
    /// Each pattern with the pictures that show it.
    pub(crate) shown: Vec<(Pattern, Range<usize>)>,
    /// Pictures early and late in it that show the same, if there are any.
    pub(crate) alike: Option<[Range<usize>; 2]>,
    /// How long it took from showing to seeing, if that is known.
    pub(crate) delay: Option<Duration>,
}

/// Why it is not known which pictures show which pattern.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SequenceError {
    /// More pictures than can be looked at.
    #[error("the recording has more than {most} pictures: cut it with rosbag filter, or record the scan by itself")]
    TooLong {
        /// How many can be.
        most: usize,
    },
    /// More happens than patterns being shown.
    #[error(
        "the camera's picture changes {count} times, for {patterns} patterns: is something moving, or was each shown \
         too briefly? Record the scan by itself, with each pattern for a second"
    )]
    Restless {
        /// Stretches of pictures that look the same.
        count: usize,
        /// How many patterns there are.
        patterns: usize,
    },
    /// Other than as many pictures between marks as there are patterns.
    #[error(
        "{seen} pictures are seen between the checkerboards from {:.1} s to {:.1} s of the recording, but there are \
         {patterns} patterns: was all of the show recorded once (--start skips what comes before), with this --size \
         and --step or these --patterns?",
        from.as_secs_f64(), to.as_secs_f64()
    )]
    BetweenMarks {
        /// How many were seen.
        seen: usize,
        /// How many patterns there are.
        patterns: usize,
        /// The first mark's time.
        from: Duration,
        /// The last one's.
        to: Duration,
    },
    /// No row of pictures is that of the patterns.
    #[error(
        "the camera sees {seen} different pictures in a row, and no {patterns} of them are the patterns in their \
         order: show them with projector_calibrate show --patterns DIR --seconds 1 --pause 0.5, and give the same \
         --patterns"
    )]
    NotInOrder {
        /// How many stretches there are.
        seen: usize,
        /// How many patterns there are.
        patterns: usize,
    },
    /// Several rows of pictures could be that of the patterns.
    #[error(
        "the patterns may begin {:.1} s or {:.1} s after the recording does: skip what comes before with --start, or \
         show them with projector_calibrate show --patterns DIR --seconds 1 --pause 0.5",
        one.as_secs_f64(), other.as_secs_f64()
    )]
    Ambiguous {
        /// When the first of them begins.
        one: Duration,
        /// When the next one does.
        other: Duration,
    },
    /// Patterns that the topic does not have.
    #[error(
        "{missing} of the {patterns} patterns are not among the {shown} pictures on the topic of --show-on: give the \
         same --size and --step, or the --patterns that were shown"
    )]
    NotShown {
        /// How many are missing.
        missing: usize,
        /// How many patterns there are.
        patterns: usize,
        /// How many pictures there are.
        shown: usize,
    },
    /// A pattern was replaced before it was seen.
    #[error(
        "the picture shown {:.1} s after the recording's beginning was not seen at rest before the next one: were the \
         camera's pictures recorded without gaps? Show each pattern longer",
        at.as_secs_f64()
    )]
    NotSettled {
        /// When it was shown.
        at: Duration,
    },
    /// White is not brighter than black.
    #[error(
        "the picture that should be white is not brighter than the black one: were other patterns shown, in another \
         order, or with a longer delay than each was shown for? Is the room dark enough?"
    )]
    NotWhite,
    /// Stripes and their inverse do not complement each other.
    #[error(
        "{:.0} % of the lit pixels are dark in stripes along {} and in their inverse, which is impossible: were other \
         patterns shown, in another order, or with a longer delay than each was shown for?",
        100.0 * share, axis
    )]
    NoPair {
        /// `x` or `y`.
        axis: &'static str,
        /// The share of lit pixels.
        share: f64,
    },
}
