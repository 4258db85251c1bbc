//! The cylinder between a lens and its target.

use nalgebra::{Isometry3, Point3, Unit, UnitQuaternion, Vector3};

/// Radius of the cylinder and gaps at its ends, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CylinderShape {
    pub(super) radius_m: f64,
    /// Gap at the lens, for the projector itself.
    pub(super) lens_gap_m: f64,
    /// Gap at the target, which the arm may grasp.
    pub(super) target_gap_m: f64,
}

/// A cylinder around the origin, along z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cylinder {
    pub(super) pose: Isometry3<f64>,
    pub(super) length_m: f64,
    pub(super) radius_m: f64,
}

/// Minimum length, metres.
const LEAST_LENGTH_M: f64 = 1e-3;

impl Cylinder {
    /// The cylinder from lens to target without the gaps; `None` if nothing is left.
    pub(super) fn between(lens: Point3<f64>, target: Point3<f64>, shape: &CylinderShape) -> Option<Self> {
        let (along, distance_m) = Unit::try_new_and_get(target - lens, LEAST_LENGTH_M)?;
        let length_m = distance_m - shape.lens_gap_m - shape.target_gap_m;
        if length_m.is_nan() || length_m < LEAST_LENGTH_M {
            return None;
        }
        let middle = lens + along.into_inner() * (shape.lens_gap_m + length_m / 2.0);
        // Antiparallel to z the axis of rotation is arbitrary.
        let rotation = UnitQuaternion::rotation_between(&Vector3::z(), &along)
            .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
        let pose = Isometry3::from_parts(middle.coords.into(), rotation);
        Some(Self { pose, length_m, radius_m: shape.radius_m })
    }

    /// Centres of its ends, the one at the lens first.
    pub(super) fn ends(&self) -> [Point3<f64>; 2] {
        [-0.5, 0.5].map(|share| self.pose * Point3::new(0.0, 0.0, share * self.length_m))
    }

    /// Largest distance of its ends from those of another one, metres.
    pub(super) fn moved_from(&self, other: &Self) -> f64 {
        let ([a, b], [c, d]) = (self.ends(), other.ends());
        (a - c).norm().max((b - d).norm())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const SHAPE: CylinderShape = CylinderShape { radius_m: 0.05, lens_gap_m: 0.2, target_gap_m: 0.1 };

    #[test]
    fn what_is_too_near_leaves_no_cylinder() {
        let to = |x: f64| Cylinder::between(Point3::origin(), Point3::new(x, 0.0, 0.0), &SHAPE);
        assert_eq!((to(0.0), to(0.3), to(f64::NAN)), (None, None, None));
        assert!((to(0.5).unwrap().length_m - 0.2).abs() < 1e-12);
    }

    #[test]
    fn straight_down_is_a_direction_too() {
        let down = Cylinder::between(Point3::new(0.0, 0.0, 2.0), Point3::origin(), &SHAPE).unwrap();
        let [top, bottom] = down.ends();
        assert!((top - Point3::new(0.0, 0.0, 1.8)).norm() < 1e-12 && (bottom.z - 0.1).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn its_ends_are_on_the_line_with_the_gaps_before_them(lens in [-3.0..3.0, -3.0..3.0, 0.0..3.0], target in [-3.0..3.0, -3.0..3.0, 0.0..3.0]) {
            let (lens, target) = (Point3::from(lens), Point3::from(target));
            prop_assume!((target - lens).norm() > 0.35);
            let cylinder = Cylinder::between(lens, target, &SHAPE).unwrap();
            let [near, far] = cylinder.ends();
            prop_assert!(((near - lens).norm() - 0.2).abs() < 1e-9 && ((far - target).norm() - 0.1).abs() < 1e-9);
            prop_assert!((near - lens).cross(&(target - lens)).norm() < 1e-9 && cylinder.moved_from(&cylinder) == 0.0);
        }
    }
}
