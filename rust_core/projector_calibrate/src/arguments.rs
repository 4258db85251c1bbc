//! Values as a user types them: sizes in pixels, lengths in metres, times in seconds, files to write.

use std::path::Path;
use std::time::Duration;

use anyhow::anyhow;
use rcs_calibration::board::Chessboard;
use rcs_files::atomic_file::check_writable;
use rcs_files::sizes::pair;
pub(super) use rcs_files::sizes::size_px;

use super::Failure;

/// Numbers of a board's inner corners along a side, and lengths of its squares, metres.
const BOARD_CORNERS: std::ops::RangeInclusive<u32> = 3..=100;
const MIN_SQUARE_M: f64 = 0.001;
const MAX_SQUARE_M: f64 = 1.0;
/// The longest time that can be given, seconds.
const MAX_SECONDS: f64 = 1e6;

/// Two lengths, metres: `0.9x0.56`, `0.45,0.6`, `90cm x 56cm`.
pub(super) fn two_lengths_m(text: &str) -> Result<[f64; 2], String> {
    let [first, second] = pair(text).ok_or("not two lengths such as 0.9x0.56")?;
    Ok([length_m(first)?, length_m(second)?])
}

/// A printed chessboard: `chessboard:10x7:25mm`, inner corners and the length of a square's side.
pub(super) fn chessboard(text: &str) -> Result<Chessboard, String> {
    let example =
        "not a board such as chessboard:10x7:25mm (inner corners, where four squares meet, and a square's side)";
    let (corners, side) = text.strip_prefix("chessboard:").and_then(|rest| rest.split_once(':')).ok_or(example)?;
    let [columns, rows] = pair(corners).ok_or(example)?;
    let count = |text: &str| match text.parse() {
        Ok(count) if BOARD_CORNERS.contains(&count) => Ok(count),
        _ => Err(format!("'{text}' is not a number of inner corners from 3 to 100")),
    };
    let square_m = length_m(side)?;
    if !(MIN_SQUARE_M..=MAX_SQUARE_M).contains(&square_m) {
        return Err(format!("'{side}' is not a square's side from 1mm to 1m"));
    }
    Ok(Chessboard { corners: [count(columns)?, count(rows)?], square_m })
}

/// A length, metres: `1.25`, `1.25m`, `125cm`, `1250mm`; may be negative or not finite.
pub(super) fn length_m(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let units = [("mm", 1e3), ("cm", 1e2), ("m", 1.0)];
    let (number, units_in_metre) =
        units.iter().find_map(|(unit, count)| Some((text.strip_suffix(unit)?, *count))).unwrap_or((text, 1.0));
    // Dividing is exact where multiplying by 0.001 is not: 250 mm is 0.25 m.
    let length: f64 = number.trim().parse().map_err(|_| format!("'{text}' is not a length in metres such as 1.25"))?;
    Ok(length / units_in_metre)
}

/// A time in seconds.
pub(super) fn seconds(text: &str) -> Result<Duration, String> {
    match text.parse() {
        Ok(seconds) if (0.0..=MAX_SECONDS).contains(&seconds) => Ok(Duration::from_secs_f64(seconds)),
        _ => Err(format!("not a number of seconds from 0 to {MAX_SECONDS}")),
    }
}

/// A time in seconds that is not zero.
pub(super) fn positive_seconds(text: &str) -> Result<Duration, String> {
    let time = seconds(text)?;
    (!time.is_zero()).then_some(time).ok_or_else(|| "not more than 0 seconds".to_owned())
}

/// Checks that a file or a folder can be written, before anything is shown.
pub(super) fn check_output(path: &Path) -> Result<(), Failure> {
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !parent.is_dir() {
        return Err(Failure::Unreadable(anyhow!("{}: the folder {} does not exist", path.display(), parent.display())));
    }
    check_writable(path).map_err(|error| Failure::Unreadable(anyhow!("{}: cannot be written: {error}", path.display())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_metres_unless_they_have_a_unit() {
        for text in ["1.25", "1.25m", " 1.25 m", "125cm", "1250 mm"] {
            assert_eq!(length_m(text), Ok(1.25), "{text}");
        }
        assert_eq!(two_lengths_m("-0.1, 0.65"), Ok([-0.1, 0.65]));
        assert_eq!(two_lengths_m("90cm x 56cm"), Ok([0.9, 0.56]));
        for text in ["", "m", "1.2.3", "wide", "1,25x"] {
            assert!(length_m(text).is_err(), "{text}");
        }
        for text in ["", "0.9", "0.9x", "x"] {
            assert!(two_lengths_m(text).is_err(), "{text}");
        }
    }

    #[test]
    fn boards_are_inner_corners_and_a_length() {
        assert_eq!(chessboard("chessboard:10x7:25mm"), Ok(Chessboard { corners: [10, 7], square_m: 0.025 }));
        assert_eq!(chessboard("chessboard:9x7:0.075"), Ok(Chessboard { corners: [9, 7], square_m: 0.075 }));
        for text in ["10x7:25mm", "chessboard:10x7", "chessboard:2x7:25mm", "chessboard:10x7:25", "chessboard:axb:1cm"]
        {
            assert!(chessboard(text).is_err(), "{text}");
        }
    }

    #[test]
    fn times_are_finite_and_not_negative() {
        assert_eq!((positive_seconds("0.5"), seconds("0")), (Ok(Duration::from_millis(500)), Ok(Duration::ZERO)));
        assert!(positive_seconds("0").is_err());
        for text in ["-1", "nan", "inf", "1e9", "soon"] {
            assert!(seconds(text).is_err(), "{text}");
        }
    }
}
