//! `projector.yaml`: a first guess of the lens and its pose, so that something is projected before the calibration.

use nalgebra::Isometry3;
use rcs_files::projector::{ProjectorFile, StaticFrame};
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::std_msgs::Header;

use crate::plan::Plan;
use crate::scene_names::{CAMERA_INFO_TOPIC, LENS_FRAME, PROJECTOR_FILE};

/// First words of a file that is a guess.
pub(crate) const MARK: &str = "# Not calibrated";

/// Focal length in widths of the image: that of a usual throw ratio.
const FOCAL_WIDTHS: f64 = 1.5;

/// The file's text.
///
/// # Errors
/// Frames that cannot be written.
pub(crate) fn text(plan: &Plan) -> Result<String, rcs_files::FileError> {
    let answers = &plan.answers;
    let [width, height] = answers.size_px;
    let (focal, cx, cy) = (FOCAL_WIDTHS * f64::from(width), f64::from(width) / 2.0, f64::from(height) / 2.0);
    let camera_info = CameraInfo {
        header: Header { frame_id: LENS_FRAME.to_owned(), ..Header::default() },
        width,
        height,
        distortion_model: "plumb_bob".to_owned(),
        D: vec![0.0; 5],
        K: [focal, 0.0, cx, 0.0, focal, cy, 0.0, 0.0, 1.0],
        R: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        P: [focal, 0.0, cx, 0.0, 0.0, focal, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
        ..CameraInfo::default()
    };
    let Isometry3 { translation, rotation } = answers.profile.mount_from_lens();
    let frame = StaticFrame {
        parent: answers.mount.clone(),
        child: LENS_FRAME.to_owned(),
        translation_m: translation.vector.into(),
        rotation,
    };
    let file = ProjectorFile {
        camera_info,
        camera_info_topic: Some(CAMERA_INFO_TOPIC.to_owned()),
        frames: vec![frame],
        ignored_keys: Vec::new(),
    };
    let yaml = file.to_yaml(&plan.folder.join(PROJECTOR_FILE))?;
    let pose = answers.profile.pose_text();
    Ok(format!("{MARK}: a guess of the lens, and of its pose: {pose}. The calibration replaces this file.\n{yaml}"))
}
