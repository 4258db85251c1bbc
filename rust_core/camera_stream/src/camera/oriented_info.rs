//! The CameraInfo that is published beside an image: one whose K, D, R and P lead a point to its pixel.
//!
//! The image is the whole one, whatever binning and region of interest the CameraInfo had that it was drawn for. A
//! turned image's CameraInfo has a frame of its own, `FRAME_rotated_90` for a quarter to the right, which
//! [`turned_frame`] places in the camera's frame.

use std::sync::Arc;

use nalgebra::UnitQuaternion;
use rcs_camera::QuarterTurns;
use rcs_files::projector::fields_of;
use rcs_messages::geometry_msgs::{Quaternion, Transform, TransformStamped};
use rcs_messages::sensor_msgs::{CameraInfo, RegionOfInterest};
use rcs_render::Orientation;

/// The frame of a turned image's CameraInfo.
fn frame_of(frame: &str, orientation: Orientation) -> String {
    match orientation.degrees() {
        0 => frame.to_owned(),
        degrees => format!("{frame}_rotated_{degrees}"),
    }
}

/// The pose of that frame in the camera's own; `None` where it is the same.
pub(crate) fn turned_frame(frame: &str, orientation: Orientation) -> Option<TransformStamped> {
    if orientation.degrees() == 0 || frame.is_empty() {
        return None;
    }
    let own_from_turned = quarter_turns(orientation).turned_from_optical().inverse();
    let [x, y, z, w] = UnitQuaternion::from_rotation_matrix(&own_from_turned).coords.into();
    let mut placed = TransformStamped::default();
    frame.clone_into(&mut placed.header.frame_id);
    placed.child_frame_id = frame_of(frame, orientation);
    placed.transform = Transform { rotation: Quaternion { x, y, z, w }, ..Transform::default() };
    Some(placed)
}

/// The CameraInfo of the whole image when it is turned.
fn oriented(info: &CameraInfo, orientation: Orientation) -> CameraInfo {
    let mut turned = CameraInfo { binning_x: 0, binning_y: 0, roi: RegionOfInterest::default(), ..info.clone() };
    if orientation != Orientation::default() {
        let oriented = quarter_turns(orientation).info(&fields_of(info));
        [turned.width, turned.height] = oriented.size_px;
        (turned.D, turned.K, turned.R, turned.P) = (oriented.d, oriented.k, oriented.r, oriented.p);
        turned.header.frame_id = frame_of(&info.header.frame_id, orientation);
    }
    turned
}

fn quarter_turns(orientation: Orientation) -> QuarterTurns {
    QuarterTurns { is_mirrored: orientation.is_mirrored, quarters: orientation.degrees() / 90 }
}

/// The CameraInfo of a camera's images, made again only when the one that they are drawn for changes.
#[derive(Debug, Default)]
pub(crate) struct TurnedInfo {
    last: Option<(Arc<CameraInfo>, Orientation, Arc<CameraInfo>)>,
}

impl TurnedInfo {
    /// The [`oriented`] CameraInfo.
    pub(crate) fn of(&mut self, info: &Arc<CameraInfo>, orientation: Orientation) -> Arc<CameraInfo> {
        let known = self.last.take().filter(|(own, how, _)| Arc::ptr_eq(own, info) && *how == orientation);
        let made = || (Arc::clone(info), orientation, Arc::new(oriented(info, orientation)));
        let (_, _, turned) = self.last.insert(known.unwrap_or_else(made));
        Arc::clone(turned)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_camera_info_is_that_of_the_whole_image() {
        let mut own = CameraInfo { width: 1280, height: 800, binning_x: 4, binning_y: 2, ..CameraInfo::default() };
        own.P = [1400.0, 0.0, 630.0, -70.0, 0.0, 1390.0, 780.0, 20.0, 0.0, 0.0, 1.0, 0.0];
        own.roi = RegionOfInterest { x_offset: 10, y_offset: 20, width: 300, height: 40, do_rectify: true };
        own.header.frame_id = "lens".to_owned();
        let mut turned = TurnedInfo::default();
        let own = Arc::new(own);
        for text in ["0", "90", "180", "270", "mirrored", "mirrored-90", "mirrored-180", "mirrored-270"] {
            let orientation: Orientation = text.parse().unwrap();
            let published = turned.of(&own, orientation);
            assert_eq!((published.binning_x, published.binning_y), (0, 0), "{text}");
            assert_eq!(published.roi, RegionOfInterest::default(), "{text}");
            let size = orientation.size_px([1280, 800]);
            assert_eq!([published.width, published.height], size, "{text}");
            assert!(Arc::ptr_eq(&published, &turned.of(&own, orientation)), "{text}");
            let placed = turned_frame("lens", orientation);
            let frame = placed.as_ref().map_or("lens", |placed| &placed.child_frame_id);
            assert_eq!(published.header.frame_id, frame, "{text}");
            assert!(placed.is_none_or(|placed| placed.header.frame_id == "lens"), "{text}");
        }
        assert_eq!(oriented(&own, Orientation::default()).P, own.P);
    }

    #[test]
    fn what_points_up_is_to_the_right_after_a_quarter_to_the_right() {
        let placed = turned_frame("lens", "90".parse().unwrap()).unwrap();
        let Quaternion { x, y, z, w } = placed.transform.rotation;
        let own_from_turned = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
        let right = own_from_turned.inverse() * -nalgebra::Vector3::y();
        assert!((right - nalgebra::Vector3::x()).norm() < 1e-12, "{right}");
    }
}
