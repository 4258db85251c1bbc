//! Arguments of the node that decide where and when there may be light.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use rcs_render::Orientation;

use crate::cli::NodeArgs;
use crate::outputs::depth_image::DepthEncoding;
use crate::safety::ages::limits::StaleTimeout;
use crate::safety::names::{CameraValue, ForCamera};
use crate::safety::rules::KeepOutFrame;

/// Where there must be no light.
#[derive(Args, Clone, Debug, Default)]
pub struct EyeSafetyArgs {
    /// A mono8 image over the projector's picture, dark where there must be no light; with CAMERA= for one camera
    #[arg(long, value_name = "[CAMERA=]TOPIC")]
    pub mask_topic: Vec<String>,
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
    pub blend: Vec<String>,
    /// The gamma of the projectors: light is the level to its power [default: 2.2]
    #[arg(long, value_name = "GAMMA")]
    pub blend_gamma: Option<Gamma>,
    /// A grey picture over the projector's picture, dark or transparent where it must not light its surface; with
    /// CAMERA= for one camera
    #[arg(long, value_name = "[CAMERA=]FILE.png")]
    pub mask: Vec<String>,
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
    pub orientation: Vec<String>,
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

/// Reads the values of options with `CAMERA=` for a config with these cameras.
///
/// # Errors
/// One line that names the option, the value, and the cameras where it names none of them.
pub(crate) fn check_cameras(node: &NodeArgs, cameras: &[String]) -> Result<(), String> {
    fn check<T: CameraValue>(option: &str, given: &[String], cameras: &[String]) -> Result<(), String> {
        ForCamera::<T>::read_all(given, cameras).map(drop).map_err(|error| format!("{option}: {error}"))
    }
    check::<String>("--mask-topic", &node.eye_safety.mask_topic, cameras)?;
    check::<PathBuf>("--mask", &node.blend.mask, cameras)?;
    check::<PathBuf>("--blend", &node.blend.blend, cameras)?;
    check::<Orientation>("--orientation", &node.mounting.orientation, cameras)
}
