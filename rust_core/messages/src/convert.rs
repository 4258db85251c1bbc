//! Messages as plain numbers, for code that should not name message types.

use crate::geometry_msgs::{Point, Pose, Quaternion, Transform, Vector3};
use rosrust::Time;

/// A translation in metres and a rotation as the quaternion x, y, z, w, exactly as sent: not normalised, not checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlainTransform {
    /// x, y, z in metres.
    pub translation: [f64; 3],
    /// x, y, z, w.
    pub rotation_xyzw: [f64; 4],
}

impl From<&Pose> for PlainTransform {
    fn from(pose: &Pose) -> Self {
        Self { translation: point_xyz(&pose.position), rotation_xyzw: quaternion_xyzw(&pose.orientation) }
    }
}

impl From<&Transform> for PlainTransform {
    fn from(transform: &Transform) -> Self {
        Self {
            translation: translation_xyz(&transform.translation),
            rotation_xyzw: quaternion_xyzw(&transform.rotation),
        }
    }
}

/// Nanoseconds since zero.
pub fn stamp_nanos(stamp: Time) -> i64 {
    stamp.nanos()
}

/// A point's coordinates.
pub fn point_xyz(point: &Point) -> [f64; 3] {
    [point.x, point.y, point.z]
}

/// A vector's coordinates.
pub fn translation_xyz(vector: &Vector3) -> [f64; 3] {
    [vector.x, vector.y, vector.z]
}

/// A quaternion's parts in the order x, y, z, w.
pub fn quaternion_xyzw(quaternion: &Quaternion) -> [f64; 4] {
    [quaternion.x, quaternion.y, quaternion.z, quaternion.w]
}
