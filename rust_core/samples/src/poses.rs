//! Conversion between pose messages and isometries.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use rcs_messages::geometry_msgs::{Point, Pose};
use rcs_messages::{point_xyz, quaternion_xyzw};

/// A message's pose; `None` if a number is not finite. A zero quaternion, which planners leave in paths, is the
/// identity.
pub(crate) fn rigid_pose(pose: &Pose) -> Option<Isometry3<f64>> {
    let [x, y, z] = point_xyz(&pose.position);
    let [i, j, k, w] = quaternion_xyzw(&pose.orientation);
    if ![x, y, z, i, j, k, w].iter().all(|number| number.is_finite()) {
        return None;
    }
    let rotation = UnitQuaternion::try_new(Quaternion::new(w, i, j, k), 1e-6).unwrap_or_else(UnitQuaternion::identity);
    Some(Isometry3::from_parts(Translation3::new(x, y, z), rotation))
}

/// A pose message.
pub(crate) fn pose_message(pose: &Isometry3<f64>) -> Pose {
    let (position, rotation) = (pose.translation.vector, pose.rotation.coords);
    Pose {
        position: Point { x: position.x, y: position.y, z: position.z },
        orientation: rcs_messages::geometry_msgs::Quaternion {
            x: rotation.x,
            y: rotation.y,
            z: rotation.z,
            w: rotation.w,
        },
    }
}
