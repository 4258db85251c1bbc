//! Checks by which rviz refuses interactive markers.

use rcs_messages::geometry_msgs::{Pose, Quaternion};
use rcs_messages::visualization_msgs::{InteractiveMarker, Marker};
use rcs_messages::{point_xyz, quaternion_xyzw, translation_xyz, PlainTransform};

use crate::classes::marker::{is_finite_color, is_unit_quaternion};

fn are_finite(values: &[f64]) -> bool {
    values.iter().all(|value| value.is_finite())
}

pub(super) fn is_finite_pose(pose: &Pose) -> bool {
    let PlainTransform { translation, rotation_xyzw } = PlainTransform::from(pose);
    are_finite(&translation) && are_finite(&rotation_xyzw)
}

/// `true` for a rotation and for all zeros, which is unset.
pub(super) fn is_rotation(orientation: &Quaternion) -> bool {
    let xyzw = quaternion_xyzw(orientation);
    xyzw == [0.0; 4] || is_unit_quaternion(xyzw)
}

/// `true` if a marker and its controls have neither NaN nor infinity.
pub(super) fn is_finite(marker: &InteractiveMarker) -> bool {
    is_finite_pose(&marker.pose)
        && marker.scale.is_finite()
        && marker.controls.iter().all(|control| {
            are_finite(&quaternion_xyzw(&control.orientation)) && control.markers.iter().all(is_finite_marker)
        })
}

fn is_finite_marker(marker: &Marker) -> bool {
    is_finite_pose(&marker.pose)
        && are_finite(&translation_xyz(&marker.scale))
        && is_finite_color(&marker.color)
        && marker.points.iter().all(|point| are_finite(&point_xyz(point)))
}
