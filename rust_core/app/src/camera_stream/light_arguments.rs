//! Arguments of the node that decide where and when there may be light.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use rcs_render::Orientation;

use crate::camera_stream::depth_image::DepthEncoding;
use crate::camera_stream::node::StaleTimeout;

/// A value for one camera, `CAMERA=VALUE`, or for all, `VALUE`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ForCamera<T> {
    /// The camera's name in the config; none for all of them.
    pub camera: Option<String>,
    /// The value.
    pub value: T,
}

impl<T: FromStr<Err: std::fmt::Display>> FromStr for ForCamera<T> {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (camera, value) = text.rsplit_once('=').map_or((None, text), |(camera, value)| (Some(camera), value));
        if camera.is_some_and(str::is_empty) || value.is_empty() {
            return Err(format!("\"{text}\" is neither VALUE nor CAMERA=VALUE"));
        }
        let value = value.parse().map_err(|error: T::Err| error.to_string())?;
        Ok(Self { camera: camera.map(str::to_owned), value })
    }
}

/// That of a camera: its own, else the one for all; of several the last.
pub(crate) fn of_camera<'v, T>(values: &'v [ForCamera<T>], camera: &str) -> Option<&'v T> {
    let last = |wanted: Option<&str>| values.iter().rev().find(|value| value.camera.as_deref() == wanted);
    last(Some(camera)).or_else(|| last(None)).map(|found| &found.value)
}

/// A frame around which there must be no light: `FRAME=RADIUS`, metres.
#[derive(Clone, Debug, PartialEq)]
pub struct KeepOutFrame {
    /// The frame.
    pub frame: String,
    /// How far around its origin, metres.
    pub radius_m: f64,
}

impl FromStr for KeepOutFrame {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("\"{text}\" is not FRAME=RADIUS with a radius in metres, above 0 and not above 100");
        let (frame, radius) = text.split_once('=').ok_or_else(wrong)?;
        let radius_m = radius.parse::<f64>().ok().filter(|radius_m| *radius_m > 0.0 && *radius_m <= 100.0);
        match (frame.trim_start_matches('/'), radius_m) {
            ("", _) | (_, None) => Err(wrong()),
            (frame, Some(radius_m)) => Ok(Self { frame: frame.to_owned(), radius_m }),
        }
    }
}

/// Where there must be no light.
#[derive(Args, Clone, Debug, Default)]
pub struct EyeSafetyArgs {
    /// A mono8 image over the projector's picture, dark where there must be no light; with CAMERA= for one camera
    #[arg(long, value_name = "[CAMERA=]TOPIC")]
    pub mask_topic: Vec<ForCamera<String>>,
    /// No light within this distance of a frame's origin, in metres; may be given several times
    #[arg(long, value_name = "FRAME=RADIUS")]
    pub keep_out: Vec<KeepOutFrame>,
    /// Whether all is black while a mask or the place of a keep-out frame is missing or too old [default: true]
    #[arg(long, value_name = "true|false")]
    pub mask_required: Option<bool>,
}

/// The share of each projector where several light one surface.
#[derive(Args, Clone, Debug, Default)]
pub struct BlendArgs {
    /// The projector's share of the light, as projector_blend writes it, or a grey picture: white is all of it; with
    /// CAMERA= for one camera
    #[arg(long, value_name = "[CAMERA=]FILE.png")]
    pub blend: Vec<ForCamera<PathBuf>>,
    /// The gamma of the projectors: light is the level to its power [default: 2.2]
    #[arg(long, value_name = "GAMMA")]
    pub blend_gamma: Option<Gamma>,
    /// A grey picture over the projector's picture, dark or transparent where it must not light its surface; with
    /// CAMERA= for one camera
    #[arg(long, value_name = "[CAMERA=]FILE.png")]
    pub mask: Vec<ForCamera<PathBuf>>,
}

/// How a projector's light follows the level of a picture: as its power.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gamma(pub f32);

impl Default for Gamma {
    fn default() -> Self {
        Self(2.2)
    }
}

impl FromStr for Gamma {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let gamma = text.parse::<f32>().ok().filter(|gamma| (0.5..=5.0).contains(gamma));
        gamma.map(Self).ok_or_else(|| format!("{text} is not a gamma from 0.5 to 5"))
    }
}

/// The depths beside the pictures.
#[derive(Args, Clone, Copy, Debug, Default)]
pub struct DepthArgs {
    /// How depths are written: as metres (32FC1) or as millimetres (16UC1) [default: 32FC1]
    #[arg(long, value_enum, value_name = "32FC1|16UC1")]
    pub depth_encoding: Option<DepthEncoding>,
}

/// How a projector is mounted.
#[derive(Args, Clone, Debug, Default)]
pub struct MountingArgs {
    /// Turn the picture clockwise by 0, 90, 180 or 270 degrees, or mirror it before: mirrored, mirrored-90,
    /// mirrored-180, mirrored-270; with CAMERA= for one camera
    #[arg(long, value_name = "[CAMERA=]ORIENTATION")]
    pub orientation: Vec<ForCamera<Orientation>>,
}

/// When data are too old to be shown.
#[derive(Args, Clone, Debug, Default)]
pub struct StaleArgs {
    /// Do not draw data that are older than this, nor anything for a camera whose frame is; 0 turns it off. With
    /// TOPIC=SECS, TOPIC=held (as long as it has a publisher) or TOPIC=never for a single topic; may be given several
    /// times
    #[arg(long, value_name = "[TOPIC=]SECS")]
    pub stale_timeout: Vec<StaleTimeout>,
    /// Write into a picture that is black because of that why it is
    #[arg(long)]
    pub stale_note: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_has_its_own_value_or_that_of_all() {
        let values: Vec<ForCamera<Orientation>> =
            ["90", "Left = right=180", "270", "Left=mirrored"].iter().map(|text| text.parse().unwrap()).collect();
        let of = |camera: &str| of_camera(&values, camera).map(ToString::to_string);
        assert_eq!(of("Left").as_deref(), Some("mirrored"));
        assert_eq!(of("Left = right").as_deref(), Some("180"));
        assert_eq!(of("other").as_deref(), Some("270"));
        assert_eq!(of_camera::<Orientation>(&[], "other"), None);
        for wrong in ["", "=90", "Left=", "45"] {
            assert!(wrong.parse::<ForCamera<Orientation>>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_keep_out_frame_has_a_radius_in_metres() {
        let parse = |text: &str| text.parse::<KeepOutFrame>();
        assert_eq!(parse("/head=0.4"), Ok(KeepOutFrame { frame: "head".to_owned(), radius_m: 0.4 }));
        for wrong in ["head", "head=", "=1", "/=1", "head=0", "head=-1", "head=nan", "head=inf"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }
}
