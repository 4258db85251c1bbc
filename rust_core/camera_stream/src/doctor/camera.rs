//! Checks of a camera: its CameraInfo, and the transform between the fixed frame and its lens.

use std::path::Path;

use rcs_displays::CameraView;
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::Image;

use super::finding::{secs, Finding};
use super::look::Look;
use crate::safety::names::of_camera;
use crate::scene::camera_pose::CameraProblem;
use crate::scene::{self, status_tree::deviations_of};

/// Age of a lens's newest transform that is a fault where no limit is set, seconds.
const MAX_AGE_SECS: f64 = 1.0;

const START_PROJECTOR: &str = "start the node projector with the projector's file, or correct camera_info_topic";
const CORRECT_FILE: &str = "correct the projector's file, or the node that publishes it";

/// The fault of a projector's file that is not there.
pub(super) fn missing_file(file: &Path) -> Option<Finding> {
    let advice = "calibrate (projector_calibrate), or name another file: projector:=FILE";
    (!file.is_file()).then(|| Finding::bad("projector file", format!("{} is not there", file.display()), advice))
}

/// The CameraInfo: there, valid, drawn as it says, and that of the image.
pub(super) fn info(look: &Look<'_>, camera: &CameraView) -> Finding {
    let name = look.name("camera_info", camera);
    match scene::camera(look.scene, camera, look.options.model) {
        Err(problem @ CameraProblem::NoCameraInfo { .. }) => Finding::bad(name, problem.to_string(), START_PROJECTOR),
        Err(problem @ CameraProblem::BadCameraInfo { .. }) => Finding::bad(name, problem.to_string(), CORRECT_FILE),
        Ok(_) | Err(CameraProblem::NoTransform { .. }) => {
            let Some(info) = look.scene.camera_info(camera) else {
                return Finding::bad(name, "no CameraInfo", START_PROJECTOR);
            };
            let deviations = deviations_of(look.scene, camera, look.options.model);
            if !deviations.is_empty() {
                return Finding::bad(name, deviations.join("; "), "");
            }
            let orientation = of_camera(&look.options.light.orientations, &camera.name).copied().unwrap_or_default();
            let image = look.observed.images.get(look.whole_name(&camera.settings.image_topic).as_str());
            match image.and_then(|image| mismatch(info, image, orientation.size_px([info.width, info.height]))) {
                Some(text) => {
                    Finding::bad(name, text, "another node publishes one of the two topics: rostopic info names it")
                }
                None => {
                    let CameraInfo { width, height, ref header, .. } = **info;
                    Finding::good(name, format!("{width}x{height}, frame {}", header.frame_id))
                }
            }
        }
    }
}

/// How an image differs from the CameraInfo that it should be drawn with; `size_px` is the size that it should have.
fn mismatch(info: &CameraInfo, image: &Image, size_px: [u32; 2]) -> Option<String> {
    let [width, height] = size_px;
    if [image.width, image.height] != size_px {
        return Some(format!("the image is {}x{}, by the CameraInfo {width}x{height}", image.width, image.height));
    }
    let (of_image, of_info) = (&image.header.frame_id, &info.header.frame_id);
    (of_image != of_info).then(|| format!("the image's frame is {of_image}, the CameraInfo's {of_info}"))
}

/// The transform between the fixed frame and the lens, and its age.
pub(super) fn transform(look: &Look<'_>, camera: &CameraView) -> Finding {
    let name = look.name("transform", camera);
    let topic = &camera.settings.camera_info_topic;
    let frame = look.scene.received_camera_info(topic).map(|(frame, _)| frame).unwrap_or_default();
    match scene::camera(look.scene, camera, look.options.model) {
        Err(CameraProblem::NoTransform { error, .. }) => {
            let advice = "publish it (robot_state_publisher: the robot, projector: the lens), or correct fixed_frame";
            Finding::bad(name, error.to_string(), advice)
        }
        Err(_) => Finding::unknown(name, "the lens's frame is unknown without a valid CameraInfo", ""),
        Ok(_) => {
            let between = format!("{} to {frame}", look.scene.frames().1);
            let limit_secs = look.limits.of_transforms().map(|limit| limit.as_secs_f64());
            aged(name, &between, look.observed.lens_ages_secs.get(topic).copied(), limit_secs)
        }
    }
}

/// The finding for a transform that is as old as this at times; `None` for one that does not move.
fn aged(name: String, between: &str, age_secs: Option<f64>, limit_secs: Option<f64>) -> Finding {
    let Some(age_secs) = age_secs else { return Finding::good(name, format!("{between}, static")) };
    let text = format!("{between}, up to {} old", secs(age_secs));
    let slow = "see whether its publisher runs and how often (rosrun tf tf_monitor)";
    match limit_secs {
        Some(limit) if age_secs > limit => {
            let text = format!("{text}, the limit is {}: the light goes out", secs(limit));
            Finding::bad(name, text, format!("{slow}, or add {{topic: /tf, limit: SECS}} to stale_timeouts"))
        }
        None if age_secs > MAX_AGE_SECS => Finding::bad(name, text, slow),
        _ if age_secs < -MAX_AGE_SECS => {
            let text = format!("{between}, stamped {} in the future", secs(-age_secs));
            Finding::bad(name, text, "correct the clock of its publisher's computer (chrony, ntp)")
        }
        _ => Finding::good(name, text),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rcs_messages::std_msgs::Header;

    use super::*;

    #[test]
    fn a_transform_is_too_old_by_its_limit_or_after_a_second() {
        let line = |age_secs, limit_secs| aged("transform".to_owned(), "map to lens", age_secs, limit_secs).to_string();
        assert_eq!(line(None, Some(1.0)), "✓ transform: map to lens, static");
        assert_eq!(line(Some(0.125), Some(1.0)), "✓ transform: map to lens, up to 0.12 s old");
        assert!(line(Some(3.0), None).starts_with("✗ transform: map to lens, up to 3 s old; see whether"));
        assert!(line(Some(3.0), Some(5.0)).starts_with('✓'));
        let stale = line(Some(0.75), Some(0.5));
        assert!(
            stale.starts_with("✗ transform: map to lens, up to 0.75 s old, the limit is 0.5 s: the light goes out; ")
        );
        assert!(line(Some(-2.0), Some(1.0)).starts_with("✗ transform: map to lens, stamped 2 s in the future; "));
    }

    #[test]
    fn an_image_of_another_size_or_frame_is_not_that_of_the_camera_info() {
        let image = |frame: &str, width: u32| {
            let header = Header { frame_id: frame.to_owned(), ..Header::default() };
            Image::new(header, [width, 2], "mono8", width, Arc::new(vec![0; width as usize * 2]))
        };
        let mut info = CameraInfo { width: 4, height: 2, ..CameraInfo::default() };
        info.header.frame_id = "lens".to_owned();
        assert_eq!(mismatch(&info, &image("lens", 4), [4, 2]), None);
        assert_eq!(mismatch(&info, &image("lens", 5), [4, 2]).unwrap(), "the image is 5x2, by the CameraInfo 4x2");
        assert_eq!(
            mismatch(&info, &image("eye", 4), [4, 2]).unwrap(),
            "the image's frame is eye, the CameraInfo's lens"
        );
    }
}
