//! Warns of CameraInfos whose projected image misses its objects.

use rcs_camera::CameraModel;
use rcs_displays::CameraView;
use rcs_files::projector::fields_of;
use rcs_messages::sensor_msgs::CameraInfo;

use crate::scene::status_tree::deviations_of;
use crate::scene::SceneState;

/// Logs the [deviations](deviations_of) of a camera's CameraInfo, when they change.
#[derive(Debug, Default)]
pub(crate) struct ProjectionWarning {
    checked: Option<CameraInfo>,
    logged: String,
}

impl ProjectionWarning {
    /// Checks the camera's last CameraInfo, if it has changed.
    pub(crate) fn check(&mut self, scene: &SceneState, view: &CameraView, model: CameraModel) {
        let Some(info) = scene.camera_info(view) else { return };
        if self.checked.as_ref().is_some_and(|checked| fields_of(checked) == fields_of(info)) {
            return;
        }
        self.checked = Some(CameraInfo::clone(info));
        let text = deviations_of(scene, view, model).join("; ");
        if !text.is_empty() && text != self.logged {
            log::warn!("camera {}: CameraInfo on [{}]: {text}", view.name, view.settings.camera_info_topic);
        }
        self.logged = text;
    }
}
