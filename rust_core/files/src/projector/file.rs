//! Reading a projector's file.

use std::path::Path;

use rcs_calibration::Distortion;
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_scene::Intrinsics;

use super::frames::{check_placed_once, FrameEntry, StaticFrame};
use super::key_error::key_error;
use super::other_tools;
use super::raw_file::RawFile;
use crate::yaml_text::{brief, one_line};
use crate::FileError;

/// Largest file that is read.
const MOST_BYTES: u64 = 4 << 20;

/// Contents of a projector's file.
///
/// ```
/// use rcs_files::projector::ProjectorFile;
/// use std::path::Path;
///
/// let text = "frame_id: beamer\nwidth: 1280\nheight: 800\nK: [1900, 0, 640, 0, 1900, 750, 0, 0, 1]\n";
/// let mut file = ProjectorFile::parse(Path::new("projector.yaml"), text)?;
/// assert_eq!(file.camera_info.P[6], 750.0);
/// assert!(file.warnings().is_empty());
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("calibrated.yaml");
/// file.camera_info.D = vec![-0.02, 0.01, 0.0, 0.0, 0.0];
/// file.write(&path)?;
/// assert_eq!(ProjectorFile::read(&path)?, file);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ProjectorFile {
    /// Geometry of the projector; the header's stamp is zero and its `frame_id` may be empty.
    pub camera_info: CameraInfo,
    /// Topic for the CameraInfo, if the file names one.
    pub camera_info_topic: Option<String>,
    /// Static frames, in the order of the file.
    pub frames: Vec<StaticFrame>,
    /// Unknown keys, such as misspelt ones.
    pub ignored_keys: Vec<String>,
}

impl ProjectorFile {
    /// Reads a file.
    ///
    /// # Errors
    /// [`FileError`] with the file and, where there is one, key and line.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        Self::parse(path, &rcs_text::decode(&read(path)?))
    }

    /// Parses the text of a file; `path` is for errors. The first of several YAML documents counts, because
    /// `rostopic echo` ends each message with `---`.
    ///
    /// # Errors
    /// [`FileError`] with the file and, where there is one, key and line.
    pub fn parse(path: &Path, text: &str) -> Result<Self, FileError> {
        let key_error = |error| key_error(path, error);
        let (preamble, yaml) = split_preamble(text);
        // Errors have their line in the file.
        let text = "\n".repeat(preamble.matches('\n').count()) + yaml;
        let mut ignored_keys = Vec::new();
        let ignore = |key: serde_ignored::Path<'_>| ignored_keys.push(key.to_string());
        let raw: Result<RawFile, _> = match other_tools::values(&text).map_err(key_error)? {
            Some(values) => serde_ignored::deserialize(values, ignore),
            None => {
                let document = serde_yaml_ng::Deserializer::from_str(&text)
                    .next()
                    .ok_or_else(|| key_error(("the file", "it is empty".to_owned())))?;
                serde_ignored::deserialize(document, ignore)
            }
        };
        let raw = raw.map_err(|error| FileError::new(path, brief(&error)))?;
        let camera_info_topic = raw.camera_info_topic.clone();
        let frames = raw.frames.iter().map(|FrameEntry(frame)| frame.clone()).collect::<Vec<_>>();
        check_placed_once(&frames).map_err(|reason| key_error(("frames", reason)))?;
        Ok(Self { camera_info: raw.camera_info().map_err(key_error)?, camera_info_topic, frames, ignored_keys })
    }

    /// Problems that are not errors: unknown keys, a distortion that no lens model can have, and a P that only rviz's
    /// projection draws. Each is a phrase without the file's name.
    pub fn warnings(&self) -> Vec<String> {
        let ignored =
            self.ignored_keys.iter().map(|key| format!("key '{}' is not known and is ignored", one_line(key)));
        let distortion = Distortion::from_message(&self.camera_info.distortion_model, &self.camera_info.D);
        let problem = distortion.err().map(|problem| format!("{}: {problem}", problem.key()));
        let CameraInfo { width, height, P: p, .. } = &self.camera_info;
        let projection = Intrinsics::exactly(*width, *height, p).err().map(|error| error.to_string());
        ignored.chain(problem).chain(projection).collect()
    }
}

/// Reads the bytes of a file, which are text.
fn read(path: &Path) -> Result<Vec<u8>, FileError> {
    let bytes = rcs_user_files::read(path, MOST_BYTES).map_err(|error| FileError::new(path, error))?;
    if bytes.starts_with(b"MATLAB 5.0") {
        let problem = "the file: it seems to be a MAT-file of MATLAB: write the projector's size, K and D as text";
        return Err(FileError::new(path, problem));
    }
    Ok(bytes)
}

/// Reads the text of a file that is to be written again, byte for byte.
pub(super) fn read_text(path: &Path) -> Result<String, FileError> {
    let problem = "the file: it is not UTF-8: save it as UTF-8 before a pose is written into it";
    String::from_utf8(read(path)?).map_err(|_| FileError::new(path, problem))
}

/// The text up to its YAML, and the YAML: a byte order mark, and the directive that OpenCV writes, which is not YAML;
/// camera_calibration's files carry it at times.
pub(super) fn split_preamble(text: &str) -> (&str, &str) {
    let yaml = text.trim_start_matches('\u{feff}');
    let yaml = match yaml.split_once('\n') {
        Some((first, rest)) if first.starts_with("%YAML:") => rest,
        _ => yaml,
    };
    text.split_at(text.len() - yaml.len())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use nalgebra::UnitQuaternion;

    use super::*;

    const MESSAGE: &str = "\
header:
  seq: 0
  stamp:
    secs: 0
    nsecs: 0
  frame_id: 'proj_view'
height: 800
width: 1280
distortion_model: plumb_bob

D: [0.1, 0.0, 0.0, 0.0, 0.0]
K: [1900.0, 0.0, 640.0, 0.0, 1900.0, 817.0, 0.0, 0.0, 1.0]
R: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
P: [1900.0, 0.0, 640, 0.0, 0.0, 1900.0, 750.0, 0.0, 0.0, 0.0, 1.0, 0.0]

binning_x: 0
binning_y: 2
roi:
  x_offset: 1
  y_offset: 0
  height: 0
  width: 0
  do_rectify: false
";

    const CALIBRATION: &str = "\
image_width: 1280
image_height: 720
camera_name: projector
camera_matrix:
  rows: 3
  cols: 3
  data: [1000, 0, 640, 0, 1100, 700.5, 0, 0, 1]
distortion_model: rational_polynomial
distortion_coefficients:
  rows: 1
  cols: 8
  data: [1, 2, 3, 4, 5, 6, 7, 8]
rectification_matrix:
  rows: 3
  cols: 3
  data: [0, 1, 0, 1, 0, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [900, 0, 630, -45, 0, 910, 690, 0, 0, 0, 1, 0]
";

    fn parse(text: &str) -> Result<ProjectorFile, FileError> {
        ProjectorFile::parse(Path::new("projector.yaml"), text)
    }

    fn error(text: &str) -> String {
        parse(text).unwrap_err().to_string()
    }

    #[test]
    fn the_message_form_is_read_whole() {
        let file = parse(MESSAGE).unwrap();
        let info = &file.camera_info;
        assert_eq!(info.header.frame_id, "proj_view");
        assert_eq!((info.width, info.height), (1280, 800));
        assert_eq!(info.D, [0.1, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(info.K[5], 817.0);
        assert_eq!(info.P[6], 750.0);
        assert_eq!((info.binning_y, info.roi.x_offset), (2, 1));
        assert!(file.ignored_keys.is_empty() && file.frames.is_empty());
        assert_eq!(file.camera_info_topic, None);
    }

    #[test]
    fn what_ros_2_prints_is_the_message_form_in_small_letters() {
        let small = [("D: [", "d: ["), ("K: [", "k: ["), ("R: [", "r: ["), ("P: [", "p: ["), ("nsecs", "nanosec")];
        let text = small.iter().fold(MESSAGE.to_owned(), |text, (from, to)| text.replace(from, to));
        let text = text.replace("  seq: 0\n", "").replace("secs:", "sec:") + "---\n";
        assert_eq!(parse(&text).unwrap(), parse(MESSAGE).unwrap());
        let both = error(&format!("{MESSAGE}k: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"));
        assert!(both.contains("duplicate field `K`"), "{both}");
    }

    #[test]
    fn comments_in_other_encodings_are_read_and_not_written_over() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.yaml");
        let latin = |text: &str| text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect::<Vec<u8>>();
        for text in [MESSAGE, CALIBRATION] {
            let commented = format!("# Größe in Pixeln\r\n{text}");
            std::fs::write(&path, latin(&commented)).unwrap();
            assert_eq!(ProjectorFile::read(&path).unwrap(), parse(text).unwrap());
            let error = read_text(&path).unwrap_err().to_string();
            assert!(error.ends_with("the file: it is not UTF-8: save it as UTF-8 before a pose is written into it"));
        }
    }

    #[test]
    fn what_rostopic_echo_printed_is_read_with_its_separator() {
        let file = parse(&format!("{MESSAGE}---\n{}---\n", MESSAGE.replace("1280", "64"))).unwrap();
        assert_eq!(file, parse(MESSAGE).unwrap());
    }

    #[test]
    fn the_calibration_form_is_read_whole() {
        let with_directive = format!("%YAML:1.0\n{CALIBRATION}");
        let marked = ["\u{feff}", CALIBRATION].concat();
        for text in [CALIBRATION.to_owned(), format!("\u{feff}{with_directive}"), with_directive, marked] {
            let info = parse(&text).unwrap().camera_info;
            assert_eq!((info.width, info.height), (1280, 720));
            assert_eq!(info.distortion_model, "rational_polynomial");
            assert_eq!(info.D, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
            assert_eq!(info.K, [1000.0, 0.0, 640.0, 0.0, 1100.0, 700.5, 0.0, 0.0, 1.0]);
            assert_eq!(info.R[1], 1.0);
            assert_eq!(info.P[3], -45.0);
            assert_eq!(info.header.frame_id, "");
        }
    }

    #[test]
    fn what_is_missing_is_filled_in() {
        let info = parse("width: 4\nheight: 3\nK: [5, 0, 2, 0, 6, 1, 0, 0, 1]\n").unwrap().camera_info;
        assert_eq!(info.P, [5.0, 0.0, 2.0, 0.0, 0.0, 6.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        assert_eq!(info.R, [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
        assert_eq!((info.distortion_model.as_str(), info.D.len()), ("plumb_bob", 5));
        let info = parse("width: 4\nheight: 3\nP: [5, 0, 2, 9, 0, 6, 1, 9, 0, 0, 1, 0]\n").unwrap().camera_info;
        assert_eq!(info.K, [5.0, 0.0, 2.0, 0.0, 6.0, 1.0, 0.0, 0.0, 1.0]);
    }

    #[test]
    fn own_keys_name_frame_topic_and_static_frames() {
        let text = format!(
            "{MESSAGE}frame_id: beamer\ncamera_info_topic: /beamer/info\nframes:\n\
             - {{parent: /base, child: a, translation: [1, 2, 3], rotation_rpy: [0, 0, {FRAC_PI_2}]}}\n\
             - {{parent: a, child: b, rotation_xyzw: [0, 0, 0.7071, 0.7071]}}\n\
             - {{parent: b, child: c, transform: '1 2 3 {FRAC_PI_2} 0 0'}}\n\
             - 0.5 0 0 0 0 0 1 c d 100\n\
             - 0 0 0 {FRAC_PI_2} 0 -{FRAC_PI_2} d e\n"
        );
        let file = parse(&text).unwrap();
        assert_eq!(file.camera_info.header.frame_id, "beamer");
        assert_eq!(file.camera_info_topic.as_deref(), Some("/beamer/info"));
        let quarter = UnitQuaternion::from_euler_angles(0.0, 0.0, FRAC_PI_2);
        let names: Vec<_> = file.frames.iter().map(|f| (f.parent.as_str(), f.child.as_str())).collect();
        assert_eq!(names, [("base", "a"), ("a", "b"), ("b", "c"), ("c", "d"), ("d", "e")]);
        assert_eq!(file.frames[0].translation_m, [1.0, 2.0, 3.0]);
        for frame in &file.frames[..3] {
            assert!(frame.rotation.angle_to(&quarter) < 1e-9, "{frame:?}");
        }
        assert_eq!(file.frames[3].translation_m, [0.5, 0.0, 0.0]);
        assert_eq!(file.frames[3].rotation, UnitQuaternion::identity());
        // Roll by -90 degrees turns z to y, yaw by 90 then turns y to -x.
        let axis = file.frames[4].rotation * nalgebra::Vector3::z();
        assert!((axis - nalgebra::Vector3::new(-1.0, 0.0, 0.0)).norm() < 1e-9, "{axis}");
    }

    #[test]
    fn errors_name_file_key_and_line() {
        let cases = [
            (MESSAGE.replace("[1900.0, 0.0, 640.0,", "[1900.0, 640.0,"), "K", "8 numbers where 9", 12),
            (MESSAGE.replace("[0.1, ", "[.nan, "), "D", "not a finite number", 11),
            (MESSAGE.replace("640, 0.0, 0.0, 1900.0", "640, 0.0, zero, 1900.0"), "P[4]", "zero", 14),
            (MESSAGE.replace("height: 800", "height: -800"), "height", "-800", 7),
            (MESSAGE.replace("width: 1280", "width: 0"), "width", "a whole number from 1", 8),
            (CALIBRATION.replace("cols: 4", "cols: 3"), "projection_matrix.cols", "expected 4", 19),
            (CALIBRATION.replace("700.5, 0, 0, 1]", "700.5]"), "camera_matrix.data", "6 numbers where 9", 7),
            (format!("{MESSAGE}frames:\n- 1 2 3 a b\n"), "frames[0]", "3 numbers where 6", 25),
            (format!("{MESSAGE}frames:\n- 1 2 3 0 0 0\n"), "frames[0]", "parent and child", 25),
            (format!("{MESSAGE}frames:\n- {{parent: a, child: /a}}\n"), "frames[0]", "own parent", 25),
            (format!("{MESSAGE}frames:\n- {{parent: a, chid: b}}\n"), "frames[0]", "chid", 25),
            (
                format!("{MESSAGE}frames:\n- {{parent: a, child: b, rotation_xyzw: [0, 0, 0, 0]}}\n"),
                "frames[0]",
                "norm 0.000",
                25,
            ),
            (MESSAGE.replace("D: [", "D: {"), "", "", 11),
        ];
        for (text, key, reason, line) in cases {
            let error = error(&text);
            assert!(error.starts_with("projector.yaml: "), "{error}");
            assert!(error.contains(key) && error.contains(reason), "{error}");
            assert!(error.contains(&format!("line {line} ")), "line {line}: {error}");
        }
    }

    #[test]
    fn missing_contradicting_and_repeated_keys_are_named() {
        let cases = [
            (MESSAGE.replace("width: 1280", ""), "width: missing (or image_width)"),
            (format!("{MESSAGE}image_width: 1280\n"), "width: the file has image_width too"),
            ("width: 4\nheight: 3\n".to_owned(), "P: missing"),
            (MESSAGE.replace("P: [1900.0", "P: [0"), "P: a focal length is zero"),
            (format!("{MESSAGE}height: 800\n"), "duplicate"),
            (format!("{MESSAGE}frames: [1 2 3 0 0 0 a b, 1 2 3 0 0 0 c b]\n"), "frames: frame 'b' is placed twice"),
            (String::new(), ""),
            ("- 1\n".to_owned(), "expected"),
        ];
        for (text, expected) in cases {
            let error = error(&text);
            assert!(error.starts_with("projector.yaml: ") && error.contains(expected), "{error}\n{expected}");
        }
        let error = ProjectorFile::read(Path::new("missing/projector.yaml")).unwrap_err().to_string();
        assert!(error.starts_with("missing/projector.yaml: "), "{error}");
    }

    #[test]
    fn unknown_keys_and_an_impossible_distortion_are_warnings() {
        let file = parse(&format!("{MESSAGE}Kk: [1]\nroii: {{a: 1}}\n")).unwrap();
        assert_eq!(file.ignored_keys, ["Kk", "roii"]);
        assert_eq!(file.warnings()[0], "key 'Kk' is not known and is ignored");
        assert_eq!(file.warnings().len(), 2);
        let file = parse(&format!("{MESSAGE}\"K\\nk\": 1\n")).unwrap();
        assert_eq!(file.warnings()[0], "key 'K k' is not known and is ignored");
        let file = parse(&MESSAGE.replace("D: [0.1, 0.0,", "D: [0.1,")).unwrap();
        assert!(file.warnings().is_empty(), "four coefficients: {:?}", file.warnings());
        let file = parse(&MESSAGE.replace("D: [0.1, 0.0, 0.0,", "D: [0.1,")).unwrap();
        assert_eq!(file.warnings(), ["D: 3 coefficients, but plumb_bob has 4, 5, 8, 12 or 14"]);
        let file =
            parse(&MESSAGE.replace("750.0, 0.0, 0.0, 0.0, 1.0, 0.0]", "750.0, 0.0, 0.0, 0.0, 0.0, 0.0]")).unwrap();
        assert!(file.warnings()[0].starts_with("the third row of P, P[8] to P[11], is [0.0"), "{:?}", file.warnings());
        let file = parse(&format!("{MESSAGE}Kk: [1]\nroii: {{a: 1}}\n")).unwrap();
        assert_eq!(file.camera_info, parse(MESSAGE).unwrap().camera_info);
    }
}
