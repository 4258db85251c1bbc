//! Values for single cameras, `CAMERA=VALUE`, and the cameras that they name.
//!
//! A value for a camera that does not exist is a rule that nobody follows: a mask that darkens nothing, say. So each
//! name has to be one of the config's, whether that camera is enabled or not.

use std::path::{Path, PathBuf};

use rcs_render::Orientation;
use rcs_window::MonitorChoice;

use rcs_node_support::key_value::split;
use rcs_node_support::node_options::InvalidOption;

/// The value that stands for not giving an option.
pub(crate) const NONE: &str = "none";

/// A value for one camera, or for all.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ForCamera<T> {
    /// The camera's name in the config; none for all of them.
    pub camera: Option<String>,
    /// The value.
    pub value: T,
}

/// Names in a config that options may have.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct ConfigNames {
    /// Cameras, enabled or not.
    pub(crate) cameras: Vec<String>,
    /// Other displays and their groups, enabled or not.
    pub(crate) displays: Vec<String>,
}

/// A list of cameras, for errors.
pub(super) fn cameras_text(cameras: &[String]) -> String {
    match cameras {
        [] => "it has none".to_owned(),
        cameras => format!("cameras: {}", cameras.join(", ")),
    }
}

/// A value of an option with `CAMERA=`.
pub trait CameraValue: Sized {
    /// Reads a value.
    ///
    /// # Errors
    /// One line that names the text.
    fn read(text: &str) -> Result<Self, String>;

    /// `true` if a text with a `=` that names no camera is a value as it stands.
    fn is_whole(_text: &str) -> bool {
        false
    }
}

/// A topic. No valid name of one has a `=` in it.
impl CameraValue for String {
    fn read(text: &str) -> Result<Self, String> {
        Ok(text.to_owned())
    }
}

impl CameraValue for PathBuf {
    fn read(text: &str) -> Result<Self, String> {
        Ok(text.into())
    }

    fn is_whole(text: &str) -> bool {
        Path::new(text).exists()
    }
}

impl CameraValue for MonitorChoice {
    fn read(text: &str) -> Result<Self, String> {
        text.parse().map_err(|never: std::convert::Infallible| match never {})
    }
}

impl CameraValue for Orientation {
    fn read(text: &str) -> Result<Self, String> {
        text.parse()
    }
}

impl<T: CameraValue> ForCamera<T> {
    /// Reads the values `CAMERA=VALUE` or `VALUE` of an option, where the cameras are those of the config: the longest
    /// name that fits counts. [`NONE`] is no value.
    ///
    /// # Errors
    /// The first that is wrong.
    pub(crate) fn read_all(option: &str, texts: &[String], cameras: &[String]) -> Result<Vec<Self>, InvalidOption> {
        let read = |text: &String| {
            Self::read(text, cameras).map_err(|reason| InvalidOption::new(option, text, reason)).transpose()
        };
        texts.iter().filter_map(read).collect()
    }

    fn read<'c>(text: &str, cameras: &'c [String]) -> Result<Option<Self>, String> {
        let text = text.trim();
        let named = |camera: &'c String| {
            let rest = text.strip_prefix(camera.trim()).filter(|_| !camera.trim().is_empty())?;
            Some((camera, rest.trim_start().strip_prefix('=')?.trim()))
        };
        let (camera, value) = match cameras.iter().filter_map(named).max_by_key(|(camera, _)| camera.trim().len()) {
            Some((camera, value)) => (Some(camera.clone()), value),
            None => match split(text).filter(|_| !T::is_whole(text)) {
                Some((key, _)) => {
                    return Err(format!("the config has no camera '{key}'; {}", cameras_text(cameras)));
                }
                None => (None, text),
            },
        };
        if value.is_empty() || (value.starts_with('=') && !T::is_whole(value)) {
            return Err("not VALUE or CAMERA=VALUE".to_owned());
        }
        (value != NONE).then(|| T::read(value)).transpose().map(|value| Some(Self { camera, value: value? }))
    }
}

/// A camera's value, or the one for all of them. The last one given wins.
pub(crate) fn of_camera<'v, T>(values: &'v [ForCamera<T>], camera: &str) -> Option<&'v T> {
    let last = |wanted: Option<&str>| values.iter().rev().find(|value| value.camera.as_deref() == wanted);
    last(Some(camera)).or_else(|| last(None)).map(|found| &found.value)
}

/// The names of cameras in values that are none of these cameras.
pub(super) fn unmatched<'v, T>(values: &'v [ForCamera<T>], cameras: &'v [String]) -> impl Iterator<Item = &'v str> {
    let named = values.iter().filter_map(|value| value.camera.as_deref());
    named.filter(|name| !cameras.iter().any(|camera| camera == name))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cameras() -> Vec<String> {
        ["Left", "Left = right", "cam"].map(str::to_owned).to_vec()
    }

    #[test]
    fn a_camera_has_its_own_value_or_that_of_all() {
        let texts = ["90", "Left = right=180", "270", "Left=mirrored"].map(str::to_owned);
        let values = ForCamera::<Orientation>::read_all("--orientation", &texts, &cameras()).unwrap();
        let of = |camera: &str| of_camera(&values, camera).map(ToString::to_string);
        assert_eq!(of("Left").as_deref(), Some("mirrored"));
        assert_eq!(of("Left = right").as_deref(), Some("180"));
        assert_eq!(of("other").as_deref(), Some("270"));
        assert_eq!(of_camera::<Orientation>(&[], "other"), None);
        for wrong in ["", "=90", "Left=", "45", "Left=45", "Leftmost=90"] {
            assert!(ForCamera::<Orientation>::read(wrong, &cameras()).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_name_that_is_no_cameras_is_refused_with_the_cameras() {
        let error = ForCamera::<String>::read_all("~mask_topic", &["camm=/people".to_owned()], &cameras()).unwrap_err();
        let expected = "invalid value 'camm=/people' for ~mask_topic: the config has no camera 'camm'; cameras: Left, \
                        Left = right, cam";
        assert_eq!(error.to_string(), expected);
        let error = ForCamera::<PathBuf>::read("Lef=/nowhere/left.png", &[]).unwrap_err();
        assert_eq!(error, "the config has no camera 'Lef'; it has none");
    }

    #[test]
    fn a_file_with_the_sign_in_its_path_is_a_value_as_a_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run=3");
        std::fs::write(&path, "").unwrap();
        let text = path.display().to_string();
        let read = |text: &str| ForCamera::<PathBuf>::read(text, &cameras());
        assert_eq!(read(&text), Ok(Some(ForCamera { camera: None, value: path.clone() })));
        let of_cam = Ok(Some(ForCamera { camera: Some("cam".to_owned()), value: path }));
        assert_eq!(read(&format!("cam={text}")), of_cam);
        assert!(read(&format!("{text}4")).is_err());
    }

    #[test]
    fn names_that_a_config_does_not_have_are_found() {
        let value = |camera: Option<&str>| ForCamera { camera: camera.map(str::to_owned), value: 0 };
        let values = [value(None), value(Some("cam")), value(Some("gone"))];
        assert_eq!(unmatched(&values, &cameras()).collect::<Vec<_>>(), ["gone"]);
        assert_eq!(unmatched(&values, &[]).collect::<Vec<_>>(), ["cam", "gone"]);
    }
}
