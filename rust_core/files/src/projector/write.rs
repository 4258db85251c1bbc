//! Writing a projector's file: a CameraInfo's keys, `frame_id`, `camera_info_topic`, and `frames` with quaternions.
//!
//! Numbers are read back exactly, also by YAML 1.1 readers (to PyYAML, `1e-7` is a string). Strings are quoted.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use rcs_calibration::{Distortion, DistortionProblem};

use super::file::ProjectorFile;
use super::frames::{check_placed_once, named_frame, StaticFrame};
use super::key_error::{key_error, KeyError};
use super::raw_file::check_focal_lengths;
use crate::atomic_file::write_atomically;
use crate::yaml_text::{number, quoted};
use crate::FileError;

impl ProjectorFile {
    /// Writes or replaces the file, which appears whole or not at all, in an existing folder. Not written are
    /// [`ignored_keys`](Self::ignored_keys), sequence number and stamp.
    ///
    /// # Errors
    /// [`FileError`] with the file and, where there is one, the key: for values that could not be read again,
    /// and if the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), FileError> {
        write_text(path, &self.to_yaml(path)?)
    }

    /// Text of the file; `path` is for errors.
    ///
    /// # Errors
    /// [`FileError`] for numbers that are not finite, a size or a focal length of zero, a distortion
    /// model with a number of coefficients that it cannot have, frames without names or with two parents.
    pub fn to_yaml(&self, path: &Path) -> Result<String, FileError> {
        self.yaml().map_err(|error| key_error(path, error))
    }

    fn yaml(&self) -> Result<String, KeyError> {
        let info = &self.camera_info;
        for (key, size) in [("width", info.width), ("height", info.height)] {
            if size == 0 {
                return Err((key, "it is zero".to_owned()));
            }
        }
        match Distortion::from_message(&info.distortion_model, &info.D) {
            // How many coefficients another model has is not known here.
            Err(DistortionProblem::UnknownModel(_)) | Ok(_) => {}
            Err(problem) => return Err((problem.key(), problem.to_string())),
        }
        check_focal_lengths(&info.P)?;
        check_placed_once(&self.frames).map_err(|reason| ("frames", reason))?;

        let mut yaml = "# A CameraInfo and, in `frames`, where it is. Lengths are metres.\n".to_owned();
        let mut line = |key: &str, value: &str| {
            // Writing to a String cannot fail.
            let _ = writeln!(yaml, "{key}: {value}");
        };
        line("frame_id", &quoted(&info.header.frame_id));
        if let Some(topic) = &self.camera_info_topic {
            line("camera_info_topic", &quoted(topic));
        }
        line("width", &info.width.to_string());
        line("height", &info.height.to_string());
        line("distortion_model", &quoted(&info.distortion_model));
        line("D", &numbers("D", &info.D)?);
        line("K", &numbers("K", &info.K)?);
        line("R", &numbers("R", &info.R)?);
        line("P", &numbers("P", &info.P)?);
        for (key, binning) in [("binning_x", info.binning_x), ("binning_y", info.binning_y)] {
            if binning != 0 {
                line(key, &binning.to_string());
            }
        }
        let roi = &info.roi;
        if (roi.x_offset, roi.y_offset, roi.width, roi.height, roi.do_rectify) != (0, 0, 0, 0, false) {
            let region = format!(
                "{{x_offset: {}, y_offset: {}, height: {}, width: {}, do_rectify: {}}}",
                roi.x_offset, roi.y_offset, roi.height, roi.width, roi.do_rectify
            );
            line("roi", &region);
        }
        if !self.frames.is_empty() {
            yaml += "frames:\n";
        }
        for frame in &self.frames {
            yaml += &frame_entry(frame)?;
        }
        Ok(yaml)
    }
}

/// Writes or replaces a file.
pub(super) fn write_text(path: &Path, text: &str) -> Result<(), FileError> {
    write_atomically(
        path,
        |file| {
            let io_error = |error| FileError::writing(path, error);
            file.write_all(text.as_bytes()).map_err(io_error)?;
            // A calibration is not to be lost with the power.
            file.flush().and_then(|()| file.get_ref().sync_all()).map_err(io_error)
        },
        |error| FileError::writing(path, error),
    )
}

/// One entry of `frames`.
pub(super) fn frame_entry(frame: &StaticFrame) -> Result<String, KeyError> {
    let frame = named_frame(&frame.parent, &frame.child, frame.translation_m, frame.rotation)
        .map_err(|reason| ("frames", reason))?;
    let rotation = frame.rotation;
    Ok(format!(
        "  - {{parent: {}, child: {}, translation: {}, rotation_xyzw: {}}}\n",
        quoted(&frame.parent),
        quoted(&frame.child),
        numbers("frames", &frame.translation_m)?,
        numbers("frames", &[rotation.i, rotation.j, rotation.k, rotation.w])?,
    ))
}

/// A list of finite numbers.
fn numbers(key: &'static str, values: &[f64]) -> Result<String, KeyError> {
    let checked = |value: &f64| {
        if value.is_finite() {
            Ok(number(*value))
        } else {
            Err((key, format!("{value} is not a finite number")))
        }
    };
    let numbers: Result<Vec<String>, KeyError> = values.iter().map(checked).collect();
    Ok(format!("[{}]", numbers?.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Quaternion, UnitQuaternion};
    use proptest::prelude::*;
    use rcs_messages::sensor_msgs::{CameraInfo, RegionOfInterest};
    use std::f64::consts::PI;

    fn file() -> ProjectorFile {
        let text = "frame_id: proj_view\nwidth: 1280\nheight: 800\n\
                    P: [1900, 0, 640, 0, 0, 1900, 750, 0, 0, 0, 1, 0]\n\
                    frames: [1 2 3 0.1 0.2 0.3 base proj_link, 0 0 1 0 0 0 proj_link proj_view]\n";
        ProjectorFile::parse(Path::new("projector.yaml"), text).unwrap()
    }

    /// Numbers of every size, those with a meaning of their own among them.
    fn any_number() -> impl Strategy<Value = f64> {
        use proptest::num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
        prop_oneof![
            4 => -2000.0..2000.0,
            2 => POSITIVE | NEGATIVE | NORMAL | SUBNORMAL | ZERO,
            1 => prop::sample::select(vec![0.0, -0.0, 1.0, 1e-7, 1e16, 0.1, f64::MAX, f64::MIN_POSITIVE]),
        ]
    }

    /// Names that YAML may take for something else, or that need escapes.
    fn any_name() -> impl Strategy<Value = String> {
        prop_oneof![
            "[a-z_]{1,8}(/[a-z]{1,4})?",
            "[^/]\\PC{0,6}",
            prop::sample::select(vec![
                "true",
                "12",
                "~",
                "- a",
                "a: b",
                "#",
                "\"",
                "\\",
                "a\nb",
                "\u{0}",
                "\u{85}\u{2028}\u{feff}",
                "\u{ffff}",
                " ",
            ])
            .prop_map(str::to_owned)
        ]
    }

    fn any_distortion() -> impl Strategy<Value = (String, Vec<f64>)> {
        let of = |name: &'static str, count: usize| {
            prop::collection::vec(any_number(), count).prop_map(move |d| (name.to_owned(), d))
        };
        prop_oneof![
            of("plumb_bob", 5),
            of("plumb_bob", 4),
            of("plumb_bob", 0),
            of("rational_polynomial", 8),
            of("rational_polynomial", 14),
            of("equidistant", 4),
            of("somebody's own", 3),
        ]
    }

    fn any_frames() -> impl Strategy<Value = Vec<StaticFrame>> {
        let pose = (prop::array::uniform3(any_number()), prop::array::uniform3(-PI..PI));
        prop::collection::vec((any_name(), pose), 0..4).prop_map(|frames| {
            let frames = frames.into_iter().enumerate();
            frames
                .map(|(index, (name, (translation_m, [roll, pitch, yaw])))| StaticFrame {
                    parent: name.clone(),
                    child: format!("{name}{index}"),
                    translation_m,
                    rotation: UnitQuaternion::from_euler_angles(roll, pitch, yaw),
                })
                .collect()
        })
    }

    prop_compose! {
        fn any_info()(
            frame_id in any_name(),
            (width, height) in (1..=u32::MAX, 1..=u32::MAX),
            (distortion_model, d) in any_distortion(),
            k in prop::array::uniform9(any_number()),
            r in prop::array::uniform9(any_number()),
            p in prop::array::uniform12(any_number())
                .prop_filter("no focal length is zero", |p| p[0] != 0.0 && p[5] != 0.0),
            (binning_x, binning_y) in (any::<u32>(), 0..3_u32),
            (x_offset, do_rectify) in (0..2_u32, any::<bool>()),
        ) -> CameraInfo {
            let mut info = CameraInfo { height, width, distortion_model, D: d, K: k, R: r, P: p, ..CameraInfo::default() };
            info.header.frame_id = frame_id;
            (info.binning_x, info.binning_y) = (binning_x, binning_y);
            info.roi = RegionOfInterest { x_offset, do_rectify, ..RegionOfInterest::default() };
            info
        }
    }

    proptest! {
        #[test]
        fn what_was_written_is_read_back(
            camera_info in any_info(),
            camera_info_topic in proptest::option::of(any_name()),
            frames in any_frames(),
        ) {
            let mut file = ProjectorFile { camera_info, camera_info_topic, frames, ignored_keys: Vec::new() };
            let mut children = std::collections::HashSet::new();
            file.frames.retain(|frame| children.insert(frame.child.clone()));
            let path = Path::new("projector.yaml");
            let text = file.to_yaml(path).unwrap();
            let read = ProjectorFile::parse(path, &text);
            prop_assert!(read.is_ok(), "{}\n{text}", read.unwrap_err());
            prop_assert_eq!(read.unwrap(), file);
        }

        #[test]
        fn a_number_that_is_not_finite_is_refused_wherever_it_is(
            place in 0..7_usize,
            index in any::<prop::sample::Index>(),
            hostile in prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY]),
        ) {
            let mut file = file();
            let info = &mut file.camera_info;
            let (key, list) = match place {
                0 => ("D", info.D.as_mut_slice()),
                1 => ("K", info.K.as_mut_slice()),
                2 => ("R", info.R.as_mut_slice()),
                3 => ("P", info.P.as_mut_slice()),
                4 => ("frames", file.frames[0].translation_m.as_mut_slice()),
                5 => ("frames", file.frames[1].translation_m.as_mut_slice()),
                _ => {
                    file.frames[1].rotation = UnitQuaternion::new_unchecked(Quaternion::new(hostile, 0.0, 0.0, 0.0));
                    ("frames", Default::default())
                }
            };
            if !list.is_empty() {
                let index = index.index(list.len());
                list[index] = hostile;
            }
            let error = file.to_yaml(Path::new("projector.yaml")).unwrap_err().to_string();
            prop_assert!(error.starts_with(&format!("projector.yaml: {key}: ")), "{error}");
        }
    }

    #[test]
    fn the_text_is_what_a_person_would_write() {
        let text = file().to_yaml(Path::new("projector.yaml")).unwrap();
        for line in [
            "frame_id: \"proj_view\"\n",
            "width: 1280\n",
            "D: [0.0, 0.0, 0.0, 0.0, 0.0]\n",
            "P: [1900.0, 0.0, 640.0, 0.0, 0.0, 1900.0, 750.0, 0.0, 0.0, 0.0, 1.0, 0.0]\n",
            "  - {parent: \"proj_link\", child: \"proj_view\", translation: [0.0, 0.0, 1.0], rotation_xyzw: [0.0, 0.0, 0.0, 1.0]}\n",
        ] {
            assert!(text.contains(line), "{line}\n{text}");
        }
        assert!(!text.contains("roi") && !text.contains("binning") && !text.contains("camera_info_topic"), "{text}");
    }

    #[test]
    fn what_could_not_be_read_again_is_refused_by_its_key() {
        type Change = fn(&mut ProjectorFile);
        let cases: [(Change, &str); 8] = [
            (|file| file.camera_info.width = 0, "width: it is zero"),
            (|file| file.camera_info.height = 0, "height: it is zero"),
            (|file| file.camera_info.P[5] = 0.0, "P: a focal length is zero (fx 1900, fy 0)"),
            (|file| file.camera_info.D = vec![0.1; 7], "D: 7 coefficients, but plumb_bob has 4, 5, 8, 12 or 14"),
            (|file| file.frames[0].parent.clear(), "frames: parent and child need names"),
            (|file| file.frames[0].child = "/base".to_owned(), "frames: frame 'base' cannot be its own parent"),
            (|file| file.frames[1].child = "proj_link".to_owned(), "frames: frame 'proj_link' is placed twice"),
            (|file| file.frames[1].child = "/proj_link".to_owned(), "frames: frame 'proj_link' is placed twice"),
        ];
        for (change, expected) in cases {
            let mut file = file();
            change(&mut file);
            let error = file.to_yaml(Path::new("projector.yaml")).unwrap_err().to_string();
            assert_eq!(error, format!("projector.yaml: {expected}"));
        }
    }

    #[test]
    fn a_file_is_replaced_as_a_whole_or_left_as_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("projector.yaml");
        file().write(&path).unwrap();
        let mut changed = file();
        changed.camera_info.width = 640;
        changed.write(&path).unwrap();
        assert_eq!(ProjectorFile::read(&path).unwrap(), changed);
        changed.camera_info.K[0] = f64::NAN;
        assert!(changed.write(&path).is_err());
        assert_eq!(ProjectorFile::read(&path).unwrap().camera_info.width, 640);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        let error = file().write(Path::new("missing/projector.yaml")).unwrap_err().to_string();
        assert!(error.starts_with("missing/projector.yaml: cannot write: "), "{error}");
    }
}
