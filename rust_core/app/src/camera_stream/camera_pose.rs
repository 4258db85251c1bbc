//! From a CameraInfo and the frames to the camera that the scene is drawn with.

use rcs_displays::World;
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_scene::{require_finite, Camera, CameraError, Intrinsics};
use rcs_transforms::LookupError;
use thiserror::Error;

use super::projector_lens::{is_distorted, Lenses};

/// How a CameraInfo's P becomes a projection.
///
/// ```
/// use clap::ValueEnum;
/// use rcs_app::camera_stream::camera_pose::{rviz_differs, Projection};
/// use rcs_messages::sensor_msgs::CameraInfo;
///
/// assert_eq!(Projection::from_str("exact", true), Ok(Projection::Exact));
/// // With one focal length and no P[7], both draw the same picture.
/// let mut info = CameraInfo { width: 1280, height: 800, ..CameraInfo::default() };
/// info.P = [1900.0, 0.0, 640.0, 0.0, 0.0, 1900.0, 750.0, 0.0, 0.0, 0.0, 1.0, 0.0];
/// assert!(!rviz_differs(&info));
/// info.P[5] = 2000.0;
/// assert!(rviz_differs(&info));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum Projection {
    /// As rviz's CameraPub draws: one focal length for both axes, `P[7]` upwards. Exact if fx = fy and P[7] = 0
    #[default]
    Rviz,
    /// As P says, to the pixel: for a projector
    Exact,
}

/// How a CameraInfo becomes a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct CameraModel {
    /// How its P becomes a projection.
    pub projection: Projection,
    /// Where it has a distortion, the picture is bent so that it is right after the lens of K and D. P is taken
    /// [exactly](Projection::Exact) then.
    pub undistort: bool,
}

impl From<Projection> for CameraModel {
    fn from(projection: Projection) -> Self {
        Self { projection, undistort: false }
    }
}

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
        /// What is wrong; names the field.
        error: CameraError,
    },
    /// The pose of the camera's frame is unknown.
    #[error("camera of [{topic}]: {error}")]
    NoTransform {
        /// The config's "Camera Info Topic".
        topic: String,
        /// What is missing; names both frames.
        error: Box<LookupError>,
    },
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
    for (field, values) in [("D", &info.D[..]), ("K", &info.K[..]), ("R", &info.R[..])] {
        require_finite(field, values).map_err(bad)?;
    }
    let intrinsics = Intrinsics::from_p(info.width, info.height, &info.P).map_err(bad)?;
    let through_lens = match model.undistort && is_distorted(info) {
        // What is wrong with a lens is a status of the camera.
        true => lenses.of(topic, info, &intrinsics).ok(),
        false => None,
    };
    let drawn = match (&through_lens, model.projection) {
        (Some(lens), _) => lens.intrinsics,
        (None, Projection::Rviz) => intrinsics.as_rviz_draws(),
        (None, Projection::Exact) => intrinsics.as_p_means(),
    };
    let fixed_from_optical = world
        .fixed_from_moving(&info.header.frame_id)
        .map_err(|error| CameraProblem::NoTransform { topic: topic.to_owned(), error: Box::new(error) })?;
    let camera = Camera::new(drawn, &fixed_from_optical, near_m);
    Ok(match through_lens {
        Some(lens) => camera.with_lens(lens.map),
        None => camera,
    })
}

/// Whether rviz's projection of this CameraInfo differs from what P says by more than half a pixel.
///
pub fn rviz_differs(info: &CameraInfo) -> bool {
    Intrinsics::from_p(info.width, info.height, &info.P).is_ok_and(|intrinsics| !intrinsics.rviz_is_exact())
}
