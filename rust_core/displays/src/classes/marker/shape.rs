//! CUBE, SPHERE and CYLINDER: one solid, scaled.

use std::f32::consts::FRAC_1_SQRT_2;

use nalgebra::{Matrix3, Matrix4, Vector3};
use rcs_messages::visualization_msgs::Marker;
use rcs_scene::Rgba;

use super::message_fields::{rgba, scale};
use super::primitive::Parts;
use crate::SolidShape;

/// State of a solid marker between messages.
#[derive(Clone, Debug)]
pub(super) struct SolidMarker {
    shape: SolidShape,
    shown: Option<([f64; 3], Rgba)>,
}

impl SolidMarker {
    pub(super) fn new(shape: SolidShape) -> Self {
        Self { shape, shown: None }
    }

    /// `true` if a message repeats the current solid.
    pub(super) fn is_unchanged(&self, marker: &Marker) -> bool {
        self.shown == Some((scale(marker), rgba(&marker.color)))
    }

    /// The solid, stood up so that a cylinder's axis is z.
    pub(super) fn parts(&mut self, marker: &Marker) -> Parts {
        #[rustfmt::skip]
        let upright = Matrix3::new(
            1.0, 0.0, 0.0,
            0.0, 0.0, -1.0,
            0.0, 1.0, 0.0,
        );
        let (scale, color) = (scale(marker), rgba(&marker.color));
        self.shown = Some((scale, color));
        let turned = turned(scale.map(|length| length as f32)).map(f64::from);
        let marker_from_solid = upright.to_homogeneous() * Matrix4::new_nonuniform_scaling(&turned.into());
        Parts::solids(color, [(self.shape, marker_from_solid)])
    }
}

/// The scale in the solid's own axes. rviz rotates it like a vector, by 90° about x, and so mirrors the solid: y
/// becomes −z, which shows in how a cylinder's sides are cut into triangles. It does so in single precision with a
/// quaternion; the rounding error of a scale of zero decides the lighting of the flat solid.
fn turned(scale: [f32; 3]) -> [f32; 3] {
    let scale = Vector3::from(scale);
    let axis = Vector3::new(FRAC_1_SQRT_2, 0.0, 0.0);
    let across = axis.cross(&scale);
    let twice_across = axis.cross(&across);
    (scale + across * (2.0 * FRAC_1_SQRT_2) + twice_across * 2.0).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_of_zero_leaves_what_rviz_leaves_of_it() {
        // Both found in rviz's images: the first is lit as a thin solid, the second as one without thickness.
        assert_eq!(turned([0.6, 0.5, 0.0])[1], 2.980_232_2e-8);
        assert_eq!(turned([1.0, 0.8, 0.0])[1], 0.0);
        assert_eq!(turned([1.0, 0.4, 0.4])[1], -0.4);
    }
}
