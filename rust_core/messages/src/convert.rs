//! Messages as plain numbers, for code that does not name message types.

use crate::geometry_msgs::{Point, Pose, Quaternion, Transform, Vector3};
use rosrust::Time;

/// A translation and a quaternion as sent: not normalised, not checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlainTransform {
    /// x, y, z, metres.
    pub translation: [f64; 3],
    /// Quaternion x, y, z, w.
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

/// A stamp in nanoseconds.
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

/// A quaternion's x, y, z, w.
pub fn quaternion_xyzw(quaternion: &Quaternion) -> [f64; 4] {
    [quaternion.x, quaternion.y, quaternion.z, quaternion.w]
}
