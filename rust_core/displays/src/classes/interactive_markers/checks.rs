//! Checks of interactive markers: what rviz refuses to show.

use rcs_messages::geometry_msgs::{Pose, Quaternion};
use rcs_messages::visualization_msgs::{InteractiveMarker, Marker};
use rcs_messages::{point_xyz, quaternion_xyzw, translation_xyz, PlainTransform};

/// How far from 1 a quaternion's squared length may be.
const QUATERNION_TOLERANCE: f64 = 10e-3;

fn are_finite(values: &[f64]) -> bool {
    values.iter().all(|value| value.is_finite())
}

/// Whether a pose has neither NaN nor infinity.
pub(super) fn is_finite_pose(pose: &Pose) -> bool {
    let PlainTransform { translation, rotation_xyzw } = PlainTransform::from(pose);
    are_finite(&translation) && are_finite(&rotation_xyzw)
}

/// Whether a quaternion is a rotation or was left at zero.
pub(super) fn is_rotation(orientation: &Quaternion) -> bool {
    let xyzw = quaternion_xyzw(orientation);
    let squared_length: f64 = xyzw.iter().map(|value| value * value).sum();
    xyzw == [0.0; 4] || (squared_length - 1.0).abs() < QUATERNION_TOLERANCE
}

/// Whether a marker and all in it has neither NaN nor infinity.
pub(super) fn is_finite(marker: &InteractiveMarker) -> bool {
    is_finite_pose(&marker.pose)
        && marker.scale.is_finite()
        && marker.controls.iter().all(|control| {
            are_finite(&quaternion_xyzw(&control.orientation)) && control.markers.iter().all(is_finite_marker)
        })
}

fn is_finite_marker(marker: &Marker) -> bool {
    let color = &marker.color;
    is_finite_pose(&marker.pose)
        && are_finite(&translation_xyz(&marker.scale))
        && [color.r, color.g, color.b, color.a].iter().all(|channel| channel.is_finite())
        && marker.points.iter().all(|point| are_finite(&point_xyz(point)))
}
