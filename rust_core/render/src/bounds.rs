//! Ogre's culling of whole clouds: a cloud is culled when the box around its points' centres is off the picture,
//! however far its squares would reach into it.
//!
//! The box lies along the fixed frame's axes, around the corners of the box along the object's own. Other primitives
//! have boxes that hold all that they draw, so that culling does not show.

use nalgebra::{Matrix4, Point3, Vector3, Vector4};
use rcs_scene::Camera;

/// A box along the axes of an object's frame, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    low: Point3<f64>,
    high: Point3<f64>,
}

impl Bounds {
    /// Around the finite positions; `None` when there are none.
    pub(crate) fn around(positions: &[[f32; 3]]) -> Option<Self> {
        let mut finite = positions.iter().filter(|position| position.iter().all(|c| c.is_finite()));
        let first = *finite.next()?;
        let (low, high) = finite.fold((first, first), |(low, high), position| {
            let each = |f: fn(f32, f32) -> f32, a: [f32; 3]| std::array::from_fn(|i| f(a[i], position[i]));
            (each(f32::min, low), each(f32::max, high))
        });
        Some(Self { low: Point3::from(low).cast(), high: Point3::from(high).cast() })
    }

    /// Around positions that are all finite; `None` where one is not, and when there are none. Faster than
    /// [`Bounds::around`]: four points at a time, without a branch.
    pub(crate) fn around_finite(positions: &[[f32; 3]]) -> Option<Self> {
        let (fours, rest) = positions.as_chunks::<4>();
        let (mut lows, mut highs) = ([[f32::INFINITY; 3]; 4], [[f32::NEG_INFINITY; 3]; 4]);
        let mut all_finite = true;
        let mut take = |i: usize, position: &[f32; 3]| {
            for (axis, &c) in position.iter().enumerate() {
                all_finite &= c.abs() <= f32::MAX;
                lows[i][axis] = if c < lows[i][axis] { c } else { lows[i][axis] };
                highs[i][axis] = if c > highs[i][axis] { c } else { highs[i][axis] };
            }
        };
        for four in fours {
            four.iter().enumerate().for_each(|(i, position)| take(i, position));
        }
        rest.iter().for_each(|position| take(0, position));
        if !all_finite || positions.is_empty() {
            return None;
        }
        let each = |all: [[f32; 3]; 4], f: fn(f32, f32) -> f32, start: f32| {
            Point3::from([0, 1, 2].map(|axis| f64::from(all.iter().fold(start, |c, one| f(c, one[axis])))))
        };
        Some(Self { low: each(lows, f32::min, f32::INFINITY), high: each(highs, f32::max, f32::NEG_INFINITY) })
    }

    /// Around both.
    pub(crate) fn joined(self, other: Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    /// The largest distance of a point in it from the frame's origin, in metres.
    pub(crate) fn reach_m(&self) -> f64 {
        self.low.coords.abs().sup(&self.high.coords.abs()).norm()
    }

    /// The smallest w in clip coordinates, given the matrix from the object's frame to these.
    pub(crate) fn nearest_w(&self, clip_from_object: &Matrix4<f64>) -> f64 {
        let row = clip_from_object.row(3).transpose();
        let half: Vector3<f64> = (self.high - self.low) / 2.0;
        row.dot(&nalgebra::center(&self.low, &self.high).to_homogeneous()) - row.xyz().abs().dot(&half)
    }

    /// Whether Ogre draws what has these bounds.
    pub(crate) fn may_be_seen(&self, camera: &Camera, fixed_from_object: &Matrix4<f64>) -> bool {
        let clip_from_fixed = camera.clip_from_view() * camera.fixed_from_view().inverse().to_homogeneous();
        let center = fixed_from_object.transform_point(&nalgebra::center(&self.low, &self.high));
        let linear = fixed_from_object.fixed_view::<3, 3>(0, 0).abs();
        let half: Vector3<f64> = linear * ((self.high - self.low) / 2.0);
        let row = |i: usize| clip_from_fixed.row(i).transpose();
        let (x, y, z, w) = (row(0), row(1), row(2), row(3));
        let is_outside = |plane: Vector4<f64>| {
            let reach = plane.xyz().abs().dot(&half);
            plane.dot(&center.to_homogeneous()) < -reach
        };
        ![w + x, w - x, w + y, w - y, w + z, w - z].into_iter().any(is_outside)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;
    use rcs_scene::Intrinsics;

    use super::*;

    #[test]
    fn a_box_beyond_one_side_of_the_view_is_culled() {
        let bounds = Bounds::around(&[[-1.0, 0.0, 0.0], [f32::NAN; 3], [1.0, 0.0, 0.0]]).unwrap();
        // At 10 m the view reaches 10 m to each side.
        let p = [50.0, 0.0, 50.0, 0.0, 0.0, 50.0, 50.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let camera = Camera::new(Intrinsics::from_p(100, 100, &p).unwrap(), &Isometry3::identity(), 0.01);
        let seen =
            |x: f64, y: f64, z: f64| bounds.may_be_seen(&camera, &Matrix4::new_translation(&Vector3::new(x, y, z)));
        assert!(seen(0.0, 0.0, 10.0) && seen(10.9, 9.9, 10.0) && seen(-10.9, -9.9, 10.0));
        let outside = [(11.1, 0.0, 10.0), (-11.1, 0.0, 10.0), (0.0, 10.1, 10.0), (0.0, 0.0, -0.1), (0.0, 0.0, 100.1)];
        assert!(!outside.into_iter().any(|(x, y, z)| seen(x, y, z)));
        // The box along the fixed frame's axes around the turned one.
        let turned = Matrix4::new_translation(&Vector3::new(10.6, 0.0, 10.0))
            * Matrix4::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_4);
        assert!(bounds.may_be_seen(&camera, &turned));
        assert_eq!(Bounds::around(&[[f32::INFINITY; 3]]), None);
    }

    #[test]
    fn the_faster_way_finds_the_same_box_and_nonfinite_positions() {
        let position = |i: usize| [(i * 7 % 11) as f32 - 5.0, (i * 5 % 13) as f32, -((i * 3 % 17) as f32)];
        for count in 0..40 {
            let mut positions: Vec<_> = (0..count).map(position).collect();
            assert_eq!(Bounds::around_finite(&positions), Bounds::around(&positions));
            let (left, right) = positions.split_at(count / 3);
            let both = (Bounds::around_finite(left), Bounds::around_finite(right));
            if let (Some(left), Some(right)) = both {
                assert_eq!(Some(left.joined(right)), Bounds::around(&positions));
            }
            for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                if let Some(position) = positions.get_mut(count / 2) {
                    position[count % 3] = bad;
                    assert_eq!(Bounds::around_finite(&positions), None);
                }
            }
        }
    }
}
