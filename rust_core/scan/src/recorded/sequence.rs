//! The frames of a recording that show each pattern.
//!
//! They are found in one of three ways, the surest first:
//! - [`super::by_topic`]: the bag also has the topic on which the patterns were published.
//! - [`super::by_marks`]: a checkerboard was shown between the patterns, as by `show --pause`. It differs from any
//!   stripes in half of its fields, whatever part of the image the camera sees, and however blurred the stripes are.
//!   So the patterns lie between what recurs, and their number tells whether all were seen.
//! - [`super::by_order`]: the patterns follow one another, and one ends where the image changes.

use std::ops::Range;
use std::time::Duration;

use rcs_calibration::patterns::Pattern;

/// The patterns of a recording.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PatternSequence {
    /// Each pattern with the frames that show it.
    pub(crate) shown: Vec<(Pattern, Range<usize>)>,
    /// Early and late frames of the same image, if there are any.
    pub(crate) repeated: Option<[Range<usize>; 2]>,
    /// The median delay from showing to seeing, if it is known.
    pub(crate) delay: Option<Duration>,
}

/// The reason why the patterns were not found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PatternSequenceError {
    /// More frames than this number, the limit.
    #[error("the recording has more than {0} pictures: cut it with rosbag filter, or record the scan by itself")]
    TooLong(usize),
    /// More changes than between patterns.
    #[error(
        "the camera's picture changes {count} times, for {patterns} patterns: is something moving, or was each shown \
         too briefly? Record the scan by itself, with each pattern for a second"
    )]
    Restless {
        /// Segments of frames of the same image.
        count: usize,
        /// Number of patterns.
        patterns: usize,
    },
    /// Another number of images between the checkerboards than of patterns.
    #[error(
        "{seen} pictures are seen between the checkerboards from {:.1} s to {:.1} s of the recording, but there are \
         {patterns} patterns: was all of the show recorded once (--start skips what comes before), with this --size \
         and --step or these --patterns?",
        from.as_secs_f64(), to.as_secs_f64()
    )]
    BetweenMarks {
        /// Number of images.
        seen: usize,
        /// Number of patterns.
        patterns: usize,
        /// Time of the first checkerboard.
        from: Duration,
        /// Time of the last checkerboard.
        to: Duration,
    },
    /// No images in a row are the patterns.
    #[error(
        "the camera sees {seen} different pictures in a row, and no {patterns} of them are the patterns in their \
         order: show them with projector_calibrate show --patterns DIR --seconds 1 --pause 0.5, and give the same \
         --patterns"
    )]
    NotInOrder {
        /// Number of segments.
        seen: usize,
        /// Number of patterns.
        patterns: usize,
    },
    /// The patterns may begin at either of these times.
    #[error(
        "the patterns may begin {:.1} s or {:.1} s after the recording does: skip what comes before with --start, or \
         show them with projector_calibrate show --patterns DIR --seconds 1 --pause 0.5",
        .0.as_secs_f64(), .1.as_secs_f64()
    )]
    Ambiguous(Duration, Duration),
    /// Patterns are missing on the topic.
    #[error(
        "{missing} of the {patterns} patterns are not among the {shown} pictures on the topic of --show-on: give the \
         same --size and --step, or the --patterns that were shown"
    )]
    NotShown {
        /// Number of missing patterns.
        missing: usize,
        /// Number of patterns.
        patterns: usize,
        /// Number of images on the topic.
        shown: usize,
    },
    /// A pattern was replaced before it was seen; the time at which it was shown.
    #[error(
        "the picture shown {:.1} s after the recording's beginning was not seen at rest before the next one: were the \
         camera's pictures recorded without gaps? Show each pattern longer",
        .0.as_secs_f64()
    )]
    NotSettled(Duration),
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
