//! Defaults for what a message leaves out: sizes, orientations and handles, as in rviz's client.

use rcs_messages::geometry_msgs::Quaternion;
use rcs_messages::quaternion_xyzw;
use rcs_messages::visualization_msgs::{InteractiveMarker, InteractiveMarkerControl};

use super::handles;

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
