//! Kalibr's camera: the only `camN` of a camchain, or its keys alone.

use serde_yaml_ng::{Mapping, Value};

use super::key_error::KeyError;
use super::own_form::{numbers_of, own_form};
use crate::yaml_text::beginning;

/// A list of `N` numbers.
fn exactly<const N: usize>(camera: &Mapping, key: &'static str) -> Result<[f64; N], KeyError> {
    let numbers = numbers_of(camera, key).and_then(|numbers| numbers.try_into().ok());
    numbers.ok_or_else(|| (key, format!("it is not the {N} numbers that Kalibr writes for a pinhole")))
}

/// The text of a key that Kalibr writes.
fn text<'a>(camera: &'a Mapping, key: &'static str) -> Result<&'a str, KeyError> {
    camera.get(key).and_then(Value::as_str).ok_or_else(|| (key, "missing: Kalibr writes a name".to_owned()))
}

/// The values of a camchain by this project's keys; `None` if it is no file of Kalibr.
///
/// # Errors
/// A file of several cameras or of another model than the pinhole, or an invalid key.
pub(super) fn values(values: &Mapping) -> Result<Option<Mapping>, KeyError> {
    let is_camera = |key: &Value| {
        let number = key.as_str().and_then(|key| key.strip_prefix("cam"));
        number.is_some_and(|number| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()))
    };
    let cameras: Vec<&Value> = values.iter().filter(|(key, _)| is_camera(key)).map(|(_, camera)| camera).collect();
    let camera = match cameras[..] {
        [Value::Mapping(camera)] => camera,
        [] if values.contains_key("intrinsics") && values.contains_key("resolution") => values,
        [] => return Ok(None),
        [_] => return Err(("the file", "its camera has no keys, where Kalibr writes intrinsics".to_owned())),
        _ => {
            let reason = "it seems to be Kalibr's camchain of several cameras, which does not say which is the \
                          projector: leave that camera alone in it";
            return Err(("the file", reason.to_owned()));
        }
    };
    let model = text(camera, "camera_model")?;
    if model != "pinhole" {
        return Err(("camera_model", format!("Kalibr's '{}' is not read, only pinhole", beginning(model))));
    }
    let d = match camera.get("distortion_coeffs") {
        Some(_) => numbers_of(camera, "distortion_coeffs"),
        None => Some(Vec::new()),
    };
    let d = d.ok_or_else(|| ("distortion_coeffs", "it is no list of numbers".to_owned()))?;
    let model = match (text(camera, "distortion_model")?, d.len()) {
        ("radtan", 4) => "plumb_bob",
        ("equidistant", 4) => "equidistant",
        ("none", 0) => "plumb_bob",
        (name @ ("radtan" | "equidistant" | "none"), count) => {
            return Err(("distortion_coeffs", format!("{count} numbers, which Kalibr's {name} does not have")));
        }
        (name, _) => {
            let reason = format!("Kalibr's '{}' is not read, only radtan, equidistant and none", beginning(name));
            return Err(("distortion_model", reason));
        }
    };
    let [fx, fy, cx, cy] = exactly(camera, "intrinsics")?;
    let [width, height] = exactly(camera, "resolution")?;
    let k = vec![fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0];
    let mut own = own_form(values, "Kalibr", k, d, Some((width.into(), height.into())))?;
    own.insert("distortion_model".into(), model.into());
    Ok(Some(own))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::projector::ProjectorFile;

    const CAMERA: &str =
        "cam0:\n  cam_overlaps: []\n  camera_model: pinhole\n  distortion_coeffs: [-0.0059, 0.0158,\n    \
        -0.0242, 0.0155]\n  distortion_model: equidistant\n  intrinsics: [277.9, 278.4, 315.5, 244.4]\n  \
        resolution: [640, 480]\n  rostopic: /cam0/image_raw\n";

    fn parse(text: &str) -> Result<ProjectorFile, String> {
        ProjectorFile::parse(Path::new("camchain.yaml"), text).map_err(|error| error.to_string())
    }

    #[test]
    fn a_single_camera_is_read_in_each_form() {
        let alone = CAMERA.replace("cam0:\n", "").replace("\n  ", "\n").replacen("  cam_", "cam_", 1);
        let moved = CAMERA.replace("cam0:", "cam1:")
            + "  T_cn_cnm1:\n  - [1.0, 0.0, 0.0, 0.1]\n  - [0.0, 1.0, 0.0, 0.0]\n  - [0.0, 0.0, 1.0, 0.0]\n  \
               - [0.0, 0.0, 0.0, 1.0]\n";
        for text in [CAMERA, &alone, &moved, &format!("frame_id: beamer\n{CAMERA}")] {
            let file = parse(text).unwrap_or_else(|error| panic!("{error}\n{text}"));
            let info = &file.camera_info;
            assert_eq!((info.width, info.height, info.distortion_model.as_str()), (640, 480, "equidistant"));
            assert_eq!(info.K, [277.9, 0.0, 315.5, 0.0, 278.4, 244.4, 0.0, 0.0, 1.0]);
            assert_eq!(info.D, [-0.0059, 0.0158, -0.0242, 0.0155]);
            assert_eq!(info.header.frame_id == "beamer", text.contains("beamer"));
            assert!(file.warnings().is_empty() && file.lens().is_ok(), "{:?}", file.warnings());
        }
        let info = parse(&CAMERA.replace("equidistant", "radtan")).unwrap().camera_info;
        assert_eq!((info.distortion_model.as_str(), info.D.len()), ("plumb_bob", 4));
        let none = CAMERA.replace("equidistant", "none").replace("[-0.0059, 0.0158,\n    -0.0242, 0.0155]", "[]");
        assert_eq!(parse(&none).unwrap().camera_info.D, [0.0; 5]);
    }

    #[test]
    fn another_camera_than_one_pinhole_is_refused_by_its_key() {
        let changed = |from: &str, to: &str| CAMERA.replace(from, to);
        for (text, expected) in [
            (CAMERA.to_owned() + &changed("cam0", "cam1"), "the file: it seems to be Kalibr's camchain of several"),
            (changed(": pinhole", ": omni"), "camera_model: Kalibr's 'omni' is not read"),
            (changed("camera_model: pinhole", "x: 1"), "camera_model: missing"),
            (changed(": equidistant", ": fov"), "distortion_model: Kalibr's 'fov' is not read"),
            (changed(": equidistant", ": none"), "distortion_coeffs: 4 numbers, which Kalibr's none does not have"),
            (changed(", 0.0155]", "]"), "distortion_coeffs: 3 numbers"),
            (changed("distortion_coeffs", "coeffs"), "distortion_coeffs: 0 numbers"),
            (changed(", 0.0155]", ", many]"), "distortion_coeffs: it is no list of numbers"),
            (changed("[277.9,", "[1.5, 277.9,"), "intrinsics: it is not the 4 numbers"),
            (changed("resolution", "size"), "resolution: it is not the 2 numbers"),
            (changed("[640,", "[640.5,"), "width: it is no whole number of pixels"),
            ("cam0: 5\n".to_owned(), "the file: its camera has no keys"),
        ] {
            let error = parse(&text).unwrap_err();
            assert!(error.starts_with("camchain.yaml: ") && error.contains(expected), "{error}");
        }
    }
}
