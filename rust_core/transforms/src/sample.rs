//! A sample of a frame's pose in its parent, and interpolation between two.

use nalgebra::{Isometry3, Translation3, UnitQuaternion};

use crate::Time;

/// Index of a frame in its tree.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) struct FrameId(pub(crate) u32);

/// Pose of a frame in its parent at one instant.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct PoseSample {
    pub(crate) stamp: Time,
    pub(crate) parent: FrameId,
    pub(crate) parent_from_child: Isometry3<f64>,
}

/// The transform at `ratio` between `a` (0) and `b` (1): straight in translation, the shorter arc in rotation.
pub fn interpolate(a: &Isometry3<f64>, b: &Isometry3<f64>, ratio: f64) -> Isometry3<f64> {
    // Not `lerp` of the difference: `b - a` may overflow where both are finite.
    let translation = a.translation.vector * (1.0 - ratio) + b.translation.vector * ratio;
    Isometry3::from_parts(Translation3::from(translation), slerp(&a.rotation, &b.rotation, ratio))
}

/// The rotation at `ratio` along the shorter arc from `a` to `b`.
///
/// nalgebra's own takes the angle from the cosine and loses half the digits between rotations that are nearly equal,
/// which successive samples usually are.
fn slerp(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>, ratio: f64) -> UnitQuaternion<f64> {
    let a = a.into_inner();
    // q and -q are one rotation; of the two the nearer to `a` is on the shorter arc.
    let b = if a.coords.dot(&b.coords) < 0.0 { -b.into_inner() } else { b.into_inner() };
    let angle = 2.0 * (b - a).norm().atan2((b + a).norm());
    let (weight_a, weight_b) = if angle < STRAIGHT_ANGLE {
        (1.0 - ratio, ratio)
    } else {
        // Both would be divided by the angle's sine, but the sum is normalised.
        (((1.0 - ratio) * angle).sin(), (ratio * angle).sin())
    };
    UnitQuaternion::from_quaternion(a * weight_a + b * weight_b)
}

/// Quaternions nearer than this (radians) are joined by a straight line, which misses the arc by less than rounding.
const STRAIGHT_ANGLE: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    #[test]
    fn rotation_follows_the_shorter_arc_whatever_the_signs() {
        let a = UnitQuaternion::from_scaled_axis(Vector3::z() * 0.2);
        let b = UnitQuaternion::from_scaled_axis(Vector3::z() * 1.0);
        let minus_b = UnitQuaternion::new_unchecked(-b.into_inner());
        for end in [b, minus_b] {
            let middle = slerp(&a, &end, 0.25);
            assert!((middle.scaled_axis() - Vector3::z() * 0.4).norm() < 1e-12);
        }
    }

    /// nalgebra's `angle_to` does not resolve small angles.
    fn angle_between(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>) -> f64 {
        let (a, b) = (a.into_inner(), b.into_inner());
        4.0 * (b - a).norm().atan2((b + a).norm())
    }

    #[test]
    fn rotation_between_nearly_equal_and_opposite_ends_stays_a_rotation() {
        let a = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, -0.4, 1.0));
        for angle in [0.0, 1e-12, 1e-8, 1e-5, 1e-3, std::f64::consts::PI] {
            let b = a * UnitQuaternion::from_scaled_axis(Vector3::x() * angle);
            let middle = slerp(&a, &b, 0.5);
            assert!((middle.norm() - 1.0).abs() < 1e-12, "angle {angle}");
            assert!((angle_between(&a, &middle) - angle / 2.0).abs() < 1e-12, "angle {angle}");
        }
    }
}
