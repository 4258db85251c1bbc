//! Names that the written files share.

/// Frame of the lens, an optical frame.
pub(crate) const LENS_FRAME: &str = "proj_view";
/// Topic of the projector image.
pub(crate) const IMAGE_TOPIC: &str = "/proj_view/image";
/// Topic of the projector's CameraInfo.
pub(crate) const CAMERA_INFO_TOPIC: &str = "/proj_view/camera_info";
/// Namespace of both.
pub(crate) const NAMESPACE: &str = "proj_view";

/// The projector's file.
pub(crate) const PROJECTOR_FILE: &str = "projector.yaml";
/// The scene.
pub(crate) const SCENE_FILE: &str = "scene.rviz";
/// The launch file.
pub(crate) const LAUNCH_FILE: &str = "projection.launch";
/// The launch file for the computer that the projector is connected to.
pub(crate) const WINDOW_LAUNCH_FILE: &str = "projector_computer.launch";
/// The next commands.
pub(crate) const README_FILE: &str = "README.md";
