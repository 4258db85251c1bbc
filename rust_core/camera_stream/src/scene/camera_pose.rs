//! The camera that the scene is drawn with, from a CameraInfo and the transforms.

use rcs_camera::{optics, CameraModel, Lenses};
use rcs_displays::World;
use rcs_files::projector::fields_of;
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_scene::{Camera, CameraError};
use rcs_transforms::LookupError;
use thiserror::Error;

/// Why there is no camera to draw with.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum CameraProblem {
    /// No CameraInfo was received yet.
    #[error("No CameraInfo received on [{topic}]. Topic may not exist.")]
    NoCameraInfo {
        /// The config's "Camera Info Topic".
        topic: String,
    },
    /// The CameraInfo is invalid.
    #[error("CameraInfo on [{topic}]: {error}")]
    BadCameraInfo {
        /// The config's "Camera Info Topic".
        topic: String,
        /// The invalid field and its value.
        error: CameraError,
    },
    /// The pose of the camera's frame is unknown.
    #[error("camera of [{topic}]: {error}")]
    NoTransform {
        /// The config's "Camera Info Topic".
        topic: String,
        /// The missing transform; names both frames.
        error: Box<LookupError>,
    },
}

impl CameraProblem {
    /// The topic of the CameraInfo.
    pub fn topic(&self) -> &str {
        match self {
            Self::NoCameraInfo { topic } | Self::BadCameraInfo { topic, .. } | Self::NoTransform { topic, .. } => topic,
        }
    }
}

/// The camera of a CameraInfo, at the latest known pose of its frame, or the predicted one.
///
/// # Errors
/// See [`CameraProblem`].
pub(crate) fn camera(
    info: &CameraInfo,
    topic: &str,
    world: &World<'_>,
    near_m: f64,
    model: CameraModel,
    lenses: &Lenses,
) -> Result<Camera, CameraProblem> {
    let bad = |error| CameraProblem::BadCameraInfo { topic: topic.to_owned(), error };
    let optics = optics(&fields_of(info), topic, model, lenses).map_err(bad)?;
    let fixed_from_optical = world
        .fixed_from_moving(&info.header.frame_id)
        .map_err(|error| CameraProblem::NoTransform { topic: topic.to_owned(), error: Box::new(error) })?;
    Ok(optics.camera(&fixed_from_optical, near_m))
}
