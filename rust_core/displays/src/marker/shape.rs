//! CUBE, SPHERE and CYLINDER: one solid, scaled.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Matrix4, Rotation3, Vector3};
use rcs_messages::visualization_msgs::Marker;
use rcs_scene::Material;

use super::numbers::{rgba, scale};
use super::part::Part;
use crate::Shape;

/// The solid, stood up so that a cylinder's axis is z. rviz turns the scale with the rotation and so mirrors the solid
/// in its y direction, which shows in how a cylinder's sides are cut into triangles.
pub(super) fn parts(marker: &Marker, shape: Shape) -> Vec<Part> {
    let [x, y, z] = scale(marker);
    let upright = Rotation3::from_axis_angle(&Vector3::x_axis(), FRAC_PI_2).to_homogeneous();
    let marker_from_solid = upright * Matrix4::new_nonuniform_scaling(&Vector3::new(x, -z, y));
    vec![Part::mesh(marker_from_solid, shape.mesh(), Material::lit(rgba(&marker.color)))]
}
