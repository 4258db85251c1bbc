//! Ogre's culling of whole clouds: a cloud is left out when the box around its points' centres is off the picture,
//! however far its squares would reach in.
//!
//! The box lies along the fixed frame's axes, around the corners of the box along the object's own. Other primitives
//! have boxes that hold all that they draw, so that culling does not show.

use nalgebra::{Matrix4, Point3, Vector3, Vector4};

use super::geometry::is_finite;

/// A box along the axes of an object's frame, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    low: Point3<f64>,
    high: Point3<f64>,
}

impl Bounds {
    /// Around the positions that lie somewhere; `None` when there are none.
    pub(super) fn around(positions: &[[f32; 3]]) -> Option<Self> {
        let mut finite = positions.iter().filter(|position| is_finite(position));
        let first = *finite.next()?;
        let (low, high) = finite.fold((first, first), |(low, high), position| {
            let each = |f: fn(f32, f32) -> f32, a: [f32; 3]| std::array::from_fn(|i| f(a[i], position[i]));
            (each(f32::min, low), each(f32::max, high))
        });
        Some(Self { low: Point3::from(low).cast(), high: Point3::from(high).cast() })
    }

    /// Whether Ogre draws what has these bounds. The clip coordinates have depths of 0 to w.
    pub(super) fn may_be_seen(&self, clip_from_fixed: &Matrix4<f64>, fixed_from_object: &Matrix4<f64>) -> bool {
        let center = fixed_from_object.transform_point(&nalgebra::center(&self.low, &self.high));
        let linear = fixed_from_object.fixed_view::<3, 3>(0, 0).abs();
        let half: Vector3<f64> = linear * ((self.high - self.low) / 2.0);
        let row = |i: usize| clip_from_fixed.row(i).transpose();
        let (x, y, z, w) = (row(0), row(1), row(2), row(3));
        let is_outside = |plane: Vector4<f64>| {
            let reach = plane.xyz().abs().dot(&half);
            plane.dot(&center.to_homogeneous()) < -reach
        };
        ![w + x, w - x, w + y, w - y, z, w - z].into_iter().any(is_outside)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_is_left_out_when_it_lies_beyond_one_side_of_the_view() {
        let bounds = Bounds::around(&[[-1.0, 0.0, 0.0], [f32::NAN; 3], [1.0, 0.0, 0.0]]).unwrap();
        // The view is the cube from (−1, −1, 0) to (1, 1, 1).
        let clip_from_fixed = Matrix4::identity();
        let seen = |x: f64, y: f64, z: f64| {
            bounds.may_be_seen(&clip_from_fixed, &Matrix4::new_translation(&Vector3::new(x, y, z)))
        };
        assert!(seen(0.0, 0.0, 0.5) && seen(1.9, 0.9, 0.1) && seen(-1.9, -0.9, 0.9));
        assert!(![(2.1, 0.0, 0.5), (-2.1, 0.0, 0.5), (0.0, 1.1, 0.5), (0.0, 0.0, -0.1), (0.0, 0.0, 1.1)]
            .into_iter()
            .any(|(x, y, z)| seen(x, y, z)));
        assert_eq!(Bounds::around(&[[f32::INFINITY; 3]]), None);
    }
}
