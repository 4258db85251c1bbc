//! Completion of messages (sizes, orientations and handles) and their checks, as in rviz's client.

use rcs_messages::geometry_msgs::{Pose, Quaternion};
use rcs_messages::visualization_msgs::{InteractiveMarker, InteractiveMarkerControl, Marker};
use rcs_messages::{point_xyz, quaternion_xyzw, translation_xyz, PlainTransform};

use super::handles;
use crate::classes::marker::{is_finite_color, is_unit_quaternion};
use crate::framework::world::all_finite;

/// Completes a marker. Without `translucent` all visible markers of its controls become opaque.
pub(super) fn complete(marker: &mut InteractiveMarker, translucent: bool) {
    if marker.controls.is_empty() {
        return;
    }
    if marker.scale == 0.0 {
        marker.scale = 1.0;
    }
    set_orientation(&mut marker.pose.orientation);
    normalize(&mut marker.pose.orientation);
    for control in &mut marker.controls {
        complete_control(f64::from(marker.scale), control, translucent);
    }
}

/// Completes a control of a marker of a size in metres.
pub(super) fn complete_control(size_m: f64, control: &mut InteractiveMarkerControl, translucent: bool) {
    set_orientation(&mut control.orientation);
    if control.markers.is_empty() {
        handles::add_default(size_m, control);
    }
    for marker in &mut control.markers {
        for length in [&mut marker.scale.x, &mut marker.scale.y, &mut marker.scale.z] {
            if *length == 0.0 {
                *length = 1.0;
            }
        }
        set_orientation(&mut marker.pose.orientation);
        normalize(&mut marker.pose.orientation);
        if !translucent && marker.color.a > 0.0 {
            marker.color.a = 1.0;
        }
    }
}

/// Makes a quaternion that was not set the identity.
pub(super) fn set_orientation(orientation: &mut Quaternion) {
    if quaternion_xyzw(orientation) == [0.0; 4] {
        orientation.w = 1.0;
    }
}

fn normalize(orientation: &mut Quaternion) {
    let length = quaternion_xyzw(orientation).iter().map(|value| value * value).sum::<f64>().sqrt();
    for value in [&mut orientation.x, &mut orientation.y, &mut orientation.z, &mut orientation.w] {
        *value /= length;
    }
}

pub(super) fn is_finite_pose(pose: &Pose) -> bool {
    let PlainTransform { translation, rotation_xyzw } = PlainTransform::from(pose);
    all_finite(&translation) && all_finite(&rotation_xyzw)
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
            all_finite(&quaternion_xyzw(&control.orientation)) && control.markers.iter().all(is_finite_marker)
        })
}

fn is_finite_marker(marker: &Marker) -> bool {
    is_finite_pose(&marker.pose)
        && all_finite(&translation_xyz(&marker.scale))
        && is_finite_color(&marker.color)
        && marker.points.iter().all(|point| all_finite(&point_xyz(point)))
}
