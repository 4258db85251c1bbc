//! Boxes along the axes of a frame, and whether a camera may see them.

use nalgebra::{Matrix4, Point3, RowVector4, Vector3};

/// A box along the axes of a frame, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    low: Point3<f64>,
    high: Point3<f64>,
}

/// Position of a box relative to a camera's view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InFrustum {
    /// Beyond one side of the view.
    Outside,
    /// Anything else; corners of the view are not looked at.
    Crossing,
    /// Inside of all sides of the view.
    Inside,
}

impl Aabb {
    /// The box from its lowest to its highest corner.
    pub fn new(low: Point3<f64>, high: Point3<f64>) -> Self {
        Self { low, high }
    }

    /// The box around the finite positions; `None` without any.
    pub fn around(positions: impl IntoIterator<Item = [f32; 3]>) -> Option<Self> {
        let finite = positions.into_iter().filter(|position| position.iter().all(|c| c.is_finite()));
        let corners = finite.map(|position| (position, position)).reduce(|(low, high), (position, _)| {
            let each = |f: fn(f32, f32) -> f32, a: [f32; 3]| [0, 1, 2].map(|i| f(a[i], position[i]));
            (each(f32::min, low), each(f32::max, high))
        });
        corners.map(|(low, high)| Self::new(Point3::from(low).cast(), Point3::from(high).cast()))
    }

    /// The box around both.
    #[must_use]
    pub fn joined(self, other: Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    /// The box with its sides moved outwards, by metres.
    #[must_use]
    pub fn grown(&self, by_m: f64) -> Self {
        let by = Vector3::repeat(by_m);
        Self { low: self.low - by, high: self.high + by }
    }

    /// The corners.
    pub fn corners(&self) -> [Point3<f64>; 8] {
        std::array::from_fn(|i| {
            let side = |axis: usize| if i >> axis & 1 == 0 { self.low[axis] } else { self.high[axis] };
            Point3::new(side(0), side(1), side(2))
        })
    }

    /// The middle of the box.
    pub fn center(&self) -> Point3<f64> {
        nalgebra::center(&self.low, &self.high)
    }

    /// Half of its sides.
    pub fn half(&self) -> Vector3<f64> {
        (self.high - self.low) / 2.0
    }

    /// The box in another frame around the turned one.
    #[must_use]
    pub fn transformed(&self, target_from_box: &Matrix4<f64>) -> Self {
        let linear = target_from_box.fixed_view::<3, 3>(0, 0).abs();
        let (center, half) = (target_from_box.transform_point(&self.center()), linear * self.half());
        Self { low: center - half, high: center + half }
    }

    /// Where the box is relative to the view whose matrix to clip coordinates is given. It counts as crossing a side
    /// within `slack`, a share of the numbers that the distance from the side is computed from.
    pub fn in_frustum(&self, clip_from_box: &Matrix4<f64>, slack: f64) -> InFrustum {
        let row = |i: usize| clip_from_box.row(i).into_owned();
        let w = row(3);
        let mut found = InFrustum::Inside;
        for axis in [row(0), row(1), row(2)] {
            let slack = slack * (self.magnitude(&axis) + self.magnitude(&w));
            for plane in [w + axis, w - axis] {
                let (at, extent) = ((plane * self.center().to_homogeneous()).x, self.extent(&plane) + slack);
                if at < -extent {
                    return InFrustum::Outside;
                }
                // Nor where it is not a number.
                let is_inside = at > extent;
                if !is_inside {
                    found = InFrustum::Crossing;
                }
            }
        }
        found
    }

    /// The least and the greatest value in the box of a linear function of the place, with `slack` as a share of its
    /// [`magnitude`](Self::magnitude).
    pub fn range(&self, function: &RowVector4<f64>, slack: f64) -> [f64; 2] {
        let at = (function * self.center().to_homogeneous()).x;
        let extent = self.extent(function) + slack * self.magnitude(function);
        [at - extent, at + extent]
    }

    /// The sum of the magnitudes that a linear function of a place in the box is computed from, at most.
    pub fn magnitude(&self, function: &RowVector4<f64>) -> f64 {
        (function.abs() * self.center().coords.abs().push(1.0)).x + self.extent(function)
    }

    /// The most that a linear function of the place differs in the box from its value at the middle.
    fn extent(&self, function: &RowVector4<f64>) -> f64 {
        (function.fixed_columns::<3>(0).abs() * self.half()).x
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;

    use super::*;
    use crate::{Camera, Intrinsics};

    fn camera() -> Camera {
        // At 10 m the view reaches 10 m to each side.
        let p = [50.0, 0.0, 50.0, 0.0, 0.0, 50.0, 50.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        Camera::new(Intrinsics::from_p(100, 100, &p).unwrap(), &Isometry3::identity(), 0.01)
    }

    fn clip_from_fixed() -> Matrix4<f64> {
        camera().clip_from_view() * camera().fixed_from_view().inverse().to_homogeneous()
    }

    #[test]
    fn a_box_beyond_one_side_of_the_view_is_outside() {
        let bounds = Aabb::around([[-1.0, 0.0, 0.0], [f32::NAN; 3], [1.0, 0.0, 0.0]]).unwrap();
        let seen = |fixed_from_box: Matrix4<f64>| {
            bounds.transformed(&fixed_from_box).in_frustum(&clip_from_fixed(), 0.0) != InFrustum::Outside
        };
        let at = |x: f64, y: f64, z: f64| seen(Matrix4::new_translation(&Vector3::new(x, y, z)));
        assert!(at(0.0, 0.0, 10.0) && at(10.9, 9.9, 10.0) && at(-10.9, -9.9, 10.0));
        let outside = [(11.1, 0.0, 10.0), (-11.1, 0.0, 10.0), (0.0, 10.1, 10.0), (0.0, 0.0, -0.1), (0.0, 0.0, 100.1)];
        assert!(!outside.into_iter().any(|(x, y, z)| at(x, y, z)));
        // The box along the fixed frame's axes around the turned one.
        let turned = Matrix4::new_translation(&Vector3::new(10.6, 0.0, 10.0))
            * Matrix4::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_4);
        assert!(seen(turned));
        assert_eq!(Aabb::around([[f32::INFINITY; 3]]), None);
    }

    #[test]
    fn a_box_is_inside_only_with_all_of_it_and_the_slack() {
        let bounds = Aabb::new(Point3::new(-1.0, -1.0, 9.0), Point3::new(1.0, 1.0, 11.0));
        assert_eq!(bounds.in_frustum(&clip_from_fixed(), 1e-5), InFrustum::Inside);
        assert_eq!(bounds.in_frustum(&clip_from_fixed(), 0.5), InFrustum::Crossing);
        let beside = bounds.transformed(&Matrix4::new_translation(&Vector3::new(9.0, 0.0, 0.0)));
        assert_eq!(beside.in_frustum(&clip_from_fixed(), 1e-5), InFrustum::Crossing);
    }
}
