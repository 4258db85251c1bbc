//! The lens that a CameraInfo tells of the pictures of a topic.

use rcs_calibration::Lens;
use rcs_files::projector::ProjectorFile;
use rcs_messages::sensor_msgs::CameraInfo;

/// The lens of a camera with pictures on this topic.
///
/// # Errors
/// What is wrong with the CameraInfo.
pub fn lens_of_topic(info: &CameraInfo, image_topic: &str) -> Result<Lens, String> {
    lens_of(info, is_rectified(image_topic))
}

/// Whether a topic has rectified pictures, by the names of image_proc and image_transport.
fn is_rectified(topic: &str) -> bool {
    let name = topic.strip_suffix("/compressed").unwrap_or(topic).rsplit('/').next();
    name.is_some_and(|name| name.starts_with("image_rect"))
}

/// The lens of a CameraInfo: K and D for raw pictures, the left part of P for rectified ones.
///
/// # Errors
/// What is wrong with it.
fn lens_of(info: &CameraInfo, is_rectified: bool) -> Result<Lens, String> {
    let mut camera_info = info.clone();
    if is_rectified {
        let [fx, skew, cx, _, below, fy, cy, _, row @ ..] = info.P;
        camera_info.K = [fx, skew, cx, below, fy, cy, row[0], row[1], row[2]];
        camera_info.D.clear();
        camera_info.distortion_model.clear();
    }
    if camera_info.width == 0 || camera_info.height == 0 {
        return Err(format!("the camera's size is {}x{} pixels", camera_info.width, camera_info.height));
    }
    let file = ProjectorFile { camera_info, camera_info_topic: None, frames: Vec::new(), ignored_keys: Vec::new() };
    file.camera_lens().map_err(|problem| problem.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectified_pictures_have_another_lens() {
        let info = CameraInfo {
            width: 640,
            height: 480,
            distortion_model: "plumb_bob".to_owned(),
            D: vec![0.1, 0.0, 0.0, 0.0, 0.0],
            K: [500.0, 0.0, 320.0, 0.0, 501.0, 240.0, 0.0, 0.0, 1.0],
            P: [510.0, 0.0, 321.0, 0.0, 0.0, 511.0, 241.0, 0.0, 0.0, 0.0, 1.0, 0.0],
            ..CameraInfo::default()
        };
        let (raw, rectified) = (lens_of(&info, false).unwrap(), lens_of(&info, true).unwrap());
        assert_eq!((raw.focal_px.x, raw.distortion.coefficients()[0]), (500.0, 0.1));
        assert_eq!(rectified, Lens::pinhole([640, 480], [510.0, 511.0], [321.0, 241.0]));
        assert!(is_rectified("/camera/rgb/image_rect_color") && !is_rectified("/camera/rgb/image_raw"));
        assert!(is_rectified("/camera/rgb/image_rect/compressed") && !is_rectified("/rgb/image_raw/compressed"));
    }

    #[test]
    fn an_uncalibrated_camera_is_an_error() {
        let info = CameraInfo { width: 640, height: 480, ..CameraInfo::default() };
        assert!(lens_of(&info, false).unwrap_err().contains("K"));
        assert!(lens_of(&CameraInfo::default(), false).unwrap_err().contains("0x0"));
    }
}
