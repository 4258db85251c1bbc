//! The cylinder between a lens and what it lights.

use nalgebra::{Isometry3, Point3, Unit, UnitQuaternion, Vector3};

/// How the cylinder lies on the line, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shape {
    pub(super) radius_m: f64,
    /// Left free before the lens, for the projector itself.
    pub(super) lens_gap_m: f64,
    /// Left free before the target, which the arm may be about to grasp.
    pub(super) target_gap_m: f64,
}

/// A cylinder around the origin, along z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cylinder {
    pub(super) pose: Isometry3<f64>,
    pub(super) length_m: f64,
    pub(super) radius_m: f64,
}

/// A shorter one is none, metres.
const LEAST_LENGTH_M: f64 = 1e-3;

impl Cylinder {
    /// From the lens to the target, less the gaps; none where nothing is left.
    pub(super) fn between(lens: Point3<f64>, target: Point3<f64>, shape: &Shape) -> Option<Self> {
        let (along, distance_m) = Unit::try_new_and_get(target - lens, LEAST_LENGTH_M)?;
        let length_m = distance_m - shape.lens_gap_m - shape.target_gap_m;
        if length_m.is_nan() || length_m < LEAST_LENGTH_M {
            return None;
        }
        let middle = lens + along.into_inner() * (shape.lens_gap_m + length_m / 2.0);
        // Straight down there is more than one shortest way; any of them will do.
        let rotation = UnitQuaternion::rotation_between(&Vector3::z(), &along)
            .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
        let pose = Isometry3::from_parts(middle.coords.into(), rotation);
        Some(Self { pose, length_m, radius_m: shape.radius_m })
    }

    /// The middles of its ends, that at the lens first.
    pub(super) fn ends(&self) -> [Point3<f64>; 2] {
        [-0.5, 0.5].map(|share| self.pose * Point3::new(0.0, 0.0, share * self.length_m))
    }

    /// How far its ends are from those of another one, metres.
    pub(super) fn moved_from(&self, other: &Self) -> f64 {
        let ([a, b], [c, d]) = (self.ends(), other.ends());
        (a - c).norm().max((b - d).norm())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const SHAPE: Shape = Shape { radius_m: 0.05, lens_gap_m: 0.2, target_gap_m: 0.1 };

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
