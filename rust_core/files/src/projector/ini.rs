//! Videre INI, as `camera_calibration_parsers` writes it; `ost.txt` of `camera_calibration` is one, too.
//!
//! A key stands on a line of its own, its numbers on the lines below:
//!
//! ```text
//! # Camera intrinsics
//! [image]
//! width
//! 640
//! [camera_name]
//! camera matrix
//! 500.0 0.0 320.0
//! ```

use std::ops::RangeInclusive;

use serde_yaml_ng::{Mapping, Value};

use super::key_error::KeyError;
use crate::yaml_text::beginning;

/// Keys of the format and of a CameraInfo, and how many numbers follow them. All of them are needed.
const KEYS: [(&str, &str, RangeInclusive<usize>); 6] = [
    ("width", "width", 1..=1),
    ("height", "height", 1..=1),
    ("camera matrix", "K", 9..=9),
    ("distortion", "D", 4..=14),
    ("rectification", "R", 9..=9),
    ("projection", "P", 12..=12),
];
/// Number of coefficients of a rational_polynomial; fewer are a plumb_bob's.
const RATIONAL_COEFFICIENTS: usize = 8;

/// Lines without comments and empty ones.
fn lines(text: &str) -> impl Iterator<Item = &str> {
    text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with(['#', ';']))
}

/// `true` for a text that begins as such a file does.
pub(super) fn is_ini(text: &str) -> bool {
    lines(text).next() == Some("[image]")
}

/// The values of a file by the keys of a CameraInfo. Unknown keys stay, for a warning.
///
/// # Errors
/// A key that is missing, given twice, or without numbers; a line that is neither key nor numbers.
pub(super) fn values(text: &str) -> Result<Mapping, KeyError> {
    let mut found: Vec<(&str, Vec<Value>)> = Vec::new();
    for line in lines(text) {
        let numbers: Option<Vec<Value>> = line.split_ascii_whitespace().map(number).collect();
        match (numbers, found.last_mut()) {
            (Some(numbers), Some((_, known))) => known.extend(numbers),
            (None, _) if line.starts_with('[') => {}
            (None, _) if line.starts_with(char::is_alphabetic) => found.push((line, Vec::new())),
            _ => {
                let reason = format!("the INI's line '{}' is neither a key nor numbers", beginning(line));
                return Err(("the file", reason));
            }
        }
    }
    let mut values = Mapping::new();
    for (name, key, counts) in KEYS {
        let mut given = found.iter().filter(|(given, _)| *given == name).map(|(_, numbers)| numbers);
        let numbers = given.next().cloned().unwrap_or_default();
        if given.next().is_some() {
            return Err((key, format!("the INI has '{name}' twice: leave the projector's part of it alone")));
        }
        if !counts.contains(&numbers.len()) {
            let (count, least) = (numbers.len(), counts.start());
            return Err((key, format!("the INI has {count} numbers of '{name}' where {least} are needed")));
        }
        if key == "D" && numbers.len() == RATIONAL_COEFFICIENTS {
            values.insert("distortion_model".into(), "rational_polynomial".into());
        }
        match <[Value; 1]>::try_from(numbers) {
            Ok([number]) if number.is_u64() => values.insert(key.into(), number),
            Ok(_) => return Err((key, "it is no whole number of pixels".to_owned())),
            Err(numbers) => values.insert(key.into(), numbers.into()),
        };
    }
    let is_unknown = |name: &str| KEYS.iter().all(|(known, ..)| *known != name);
    values.extend(found.into_iter().filter(|(name, _)| is_unknown(name)).map(|(name, of)| (name.into(), of.into())));
    Ok(values)
}

fn number(word: &str) -> Option<Value> {
    word.parse::<u64>().map(Value::from).or_else(|_| word.parse::<f64>().map(Value::from)).ok()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::projector::ProjectorFile;

    /// As `ost.txt` is written, and `camera_calibration_parsers convert` writes it with another comment.
    const OST: &str = "# oST version 5.0 parameters\n\n\n[image]\n\nwidth\n1280\n\nheight\n800\n\n[narrow_stereo]\n\n\
        camera matrix\n1900.500000 0.000000 640.000000\n0.000000 1890.000000 817.000000\n\
        0.000000 0.000000 1.000000\n\ndistortion\n-0.125740 0.100000 0.000100 -0.000200 0.000000\n\n\
        rectification\n1.000000 0.000000 0.000000\n0.000000 1.000000 0.000000\n0.000000 0.000000 1.000000\n\n\
        projection\n1910.000000 0.000000 641.000000 0.000000\n0.000000 1900.000000 818.000000 0.000000\n\
        0.000000 0.000000 1.000000 0.000000\n\n";

    fn parse(text: &str) -> Result<ProjectorFile, String> {
        ProjectorFile::parse(Path::new("ost.txt"), text).map_err(|error| error.to_string())
    }

    #[test]
    fn each_writers_file_is_read_whole() {
        let externals = OST.replace("[narrow", "[externals]\ntranslation\n1 2 3\nrotation\n0 0 0\n\n[narrow");
        for text in [OST, &OST.replace("oST version 5.0 parameters", "Camera intrinsics"), &externals] {
            let file = parse(text).unwrap();
            let info = &file.camera_info;
            assert_eq!((info.width, info.height, info.distortion_model.as_str()), (1280, 800, "plumb_bob"));
            assert_eq!(info.K, [1900.5, 0.0, 640.0, 0.0, 1890.0, 817.0, 0.0, 0.0, 1.0]);
            assert_eq!(info.D, [-0.12574, 0.1, 1e-4, -2e-4, 0.0]);
            assert_eq!((info.R[0], info.P[0], info.P[6]), (1.0, 1910.0, 818.0));
            let ignored: &[&str] = if text == externals { &["translation", "rotation"] } else { &[] };
            assert_eq!(file.ignored_keys, ignored);
        }
        assert_eq!(parse(&OST.replace('\n', "\r\n")), parse(OST));
        let rational = parse(&OST.replace("-0.000200 0.000000", "-0.000200 0.0 0.1 0.2 0.3")).unwrap().camera_info;
        assert_eq!((rational.distortion_model.as_str(), rational.D.len()), ("rational_polynomial", 8));
    }

    #[test]
    fn what_is_missing_repeated_or_no_number_is_refused_by_its_key() {
        for (from, to, expected) in [
            ("distortion\n", "distortions\n", "ost.txt: D: the INI has 0 numbers of 'distortion' where 4 are"),
            (
                "-0.125740 0.100000 0.000100 -0.000200 0.000000\n",
                "",
                "D: the INI has 0 numbers of 'distortion' where 4",
            ),
            ("-0.125740", "-0,125740", "the file: the INI's line '-0,125740 0.100000"),
            ("-0.125740", "nan", "not a finite number"),
            (
                "0.000000 0.000000 1.000000\n\ndist",
                "\ndist",
                "K: the INI has 6 numbers of 'camera matrix' where 9 are needed",
            ),
            ("1280", "1280.5", "width: it is no whole number of pixels"),
            ("1280", "1280 2", "width: the INI has 2 numbers of 'width' where 1 "),
            ("[image]\n", "[image]\n5\n", "the INI's line '5' is neither"),
        ] {
            let error = parse(&OST.replacen(from, to, 1)).unwrap_err();
            assert!(error.starts_with("ost.txt: ") && error.contains(expected), "{from}: {error}");
        }
        let stereo = OST.to_owned() + &OST.replace("narrow_stereo", "narrow_stereo/right");
        assert!(parse(&stereo).unwrap_err().contains("width: the INI has 'width' twice"));
    }
}
