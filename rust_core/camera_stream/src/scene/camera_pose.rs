//! The camera that the scene is drawn with, from a CameraInfo and the transforms.

use rcs_camera::{is_distorted, optics, CameraModel, NoLens};
use rcs_displays::{CameraView, SceneState};
use rcs_files::projector::fields_of;
use rcs_render::View;
use rcs_scene::{Camera, CameraError, Scene};
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

/// The projection and pose of a camera, from its last CameraInfo and the latest or predicted transforms.
///
/// # Errors
/// See [`CameraProblem`]: no image can be drawn then.
pub fn camera(scene: &SceneState, view: &CameraView, model: impl Into<CameraModel>) -> Result<Camera, CameraProblem> {
    let topic = &view.settings.camera_info_topic;
    let info = scene.camera_info(view).ok_or_else(|| CameraProblem::NoCameraInfo { topic: topic.clone() })?;
    let bad = |error| CameraProblem::BadCameraInfo { topic: topic.clone(), error };
    let optics = optics(&fields_of(info), topic, model.into(), scene.lenses()).map_err(bad)?;
    let fixed_from_optical = scene
        .pose_of(&info.header.frame_id)
        .map_err(|error| CameraProblem::NoTransform { topic: topic.clone(), error: Box::new(error) })?;
    Ok(optics.camera(&fixed_from_optical, f64::from(view.settings.near_clip_m)))
}

/// Why the distortion of a camera's CameraInfo is unknown, if it has one that `drawn` lacks.
pub(crate) fn unknown_lens(scene: &SceneState, view: &CameraView, drawn: &Camera) -> Option<NoLens> {
    let is_straight = drawn.lens().is_none();
    let info = scene.camera_info(view).filter(|info| is_straight && is_distorted(&fields_of(info)));
    info.and_then(|_| scene.lenses().problem(&view.settings.camera_info_topic))
}

/// The renderer's input for a camera's image.
pub fn renderer_view<'a>(view: &'a CameraView, scene: &'a Scene, camera: &'a Camera) -> View<'a> {
    View {
        scene,
        camera,
        visible: &view.visible,
        background: view.settings.background_color,
        encoding: view.settings.image_encoding,
    }
}
