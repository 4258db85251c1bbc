//! Poses of messages as rigid transforms, and back.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use rcs_messages::geometry_msgs::{Point, Pose};
use rcs_messages::{point_xyz, quaternion_xyzw};

/// A message's pose; none if a number is not finite. A quaternion of zeros, as planners leave it on the way, is no
/// rotation.
pub fn rigid_pose(pose: &Pose) -> Option<Isometry3<f64>> {
    let [x, y, z] = point_xyz(&pose.position);
    let [i, j, k, w] = quaternion_xyzw(&pose.orientation);
    if ![x, y, z, i, j, k, w].iter().all(|number| number.is_finite()) {
        return None;
    }
    let rotation = UnitQuaternion::try_new(Quaternion::new(w, i, j, k), 1e-6).unwrap_or_else(UnitQuaternion::identity);
    Some(Isometry3::from_parts(Translation3::new(x, y, z), rotation))
}

/// A rigid transform as a message.
pub fn pose_message(pose: &Isometry3<f64>) -> Pose {
    let (at, turned) = (pose.translation.vector, pose.rotation.coords);
    Pose {
        position: Point { x: at.x, y: at.y, z: at.z },
        orientation: rcs_messages::geometry_msgs::Quaternion { x: turned.x, y: turned.y, z: turned.z, w: turned.w },
    }
}
