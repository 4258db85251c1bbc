//! Names of distortion models, which differ between tools and their versions.

use rcs_calibration::DistortionModel;

use super::key_error::KeyError;
use crate::yaml_text::one_line;

/// The message's name of a tool's distortion model.
///
/// `camera_model` is the key of Melodic's camera_calibration, `fisheye_model` (0 or 1) that of OpenCV's sample.
pub(super) fn distortion_model(
    named: Option<String>,
    camera_model: Option<&str>,
    fisheye_model: Option<u64>,
) -> Result<String, KeyError> {
    use DistortionModel::{Equidistant, PlumbBob, RationalPolynomial};
    // OpenCV's alias is not a name in a message.
    let named = named.map(|name| if name == "fisheye" { Equidistant.name().to_owned() } else { name });
    let of_camera = match camera_model {
        None if fisheye_model == Some(1) => Some(Equidistant),
        None => None,
        Some("fisheye" | "equidistant") => Some(Equidistant),
        Some("pinhole" | "plumb_bob") => Some(PlumbBob),
        Some("rational_polynomial") => Some(RationalPolynomial),
        Some(other) => {
            let reason = format!("'{}' is not known (fisheye, pinhole, plumb_bob)", one_line(other));
            return Err(("camera_model", reason));
        }
    };
    match (named, of_camera) {
        (Some(named), Some(Equidistant)) if named != Equidistant.name() => {
            Err(("camera_model", format!("it is a fisheye's, but distortion_model is '{}'", one_line(&named))))
        }
        (Some(named), _) => Ok(named),
        (None, of_camera) => Ok(of_camera.unwrap_or(PlumbBob).name().to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::projector::ProjectorFile;

    #[test]
    fn the_model_is_named_by_the_keys_of_each_version_of_the_tools() {
        let of = |keys: &str| {
            let text = format!("width: 4\nheight: 3\nK: [5, 0, 2, 0, 6, 1, 0, 0, 1]\n{keys}");
            ProjectorFile::parse(Path::new("projector.yaml"), &text)
        };
        for (keys, model, d) in [
            ("camera_model: fisheye\nD: [0.1, 0, 0, 0]\n", "equidistant", 4),
            ("camera_model: fisheye\n", "equidistant", 4),
            ("distortion_model: fisheye\nD: [0.1, 0, 0, 0]\n", "equidistant", 4),
            ("camera_model: pinhole\nD: [0.1, 0, 0, 0, 0, 0, 0, 0]\n", "plumb_bob", 8),
            ("camera_model: plumb_bob\n", "plumb_bob", 5),
            ("camera_model: rational_polynomial\nD: [0.1, 0, 0, 0, 0, 0, 0, 0]\n", "rational_polynomial", 8),
            ("camera_model: pinhole\ndistortion_model: equidistant\n", "equidistant", 4),
            ("fisheye_model: 1\n", "equidistant", 4),
            ("fisheye_model: 0\n", "plumb_bob", 5),
        ] {
            let file = of(keys).unwrap();
            assert_eq!((file.camera_info.distortion_model.as_str(), file.camera_info.D.len()), (model, d), "{keys}");
            assert!(file.warnings().is_empty(), "{keys}: {:?}", file.warnings());
            assert_eq!(file.lens().unwrap().distortion.is_none(), model == "plumb_bob" && d == 5, "{keys}");
        }
        for (keys, expected) in [
            ("camera_model: omni\n", "camera_model: 'omni' is not known"),
            ("camera_model: fisheye\ndistortion_model: plumb_bob\n", "camera_model: it is a fisheye's, but"),
        ] {
            let error = of(keys).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
