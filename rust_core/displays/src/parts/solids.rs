//! Symbols that rviz puts together from its solids: axes and arrows.
//!
//! Reproduces `rviz::Axes` and `rviz::Arrow`: rotations and scales of cylinder and cone, and the origins by which
//! translucent ones are sorted (each solid's own middle).

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use nalgebra::{Isometry3, Matrix3, Matrix4, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use rcs_scene::{DisplayId, Drawable, Geometry, Material, RenderGroup, Rgba};

use crate::SolidShape;

/// A drawable that is sorted by its origin.
pub(crate) fn drawable(display: DisplayId, fixed_from_object: Matrix4<f64>, geometry: Geometry) -> Drawable {
    let origin = fixed_from_object.fixed_view::<3, 1>(0, 3).into_owned();
    Drawable { display, fixed_from_object, sort_point: Point3::from(origin), group: RenderGroup::Main, geometry }
}

pub(crate) fn solid(
    display: DisplayId,
    shape: SolidShape,
    fixed_from_object: Matrix4<f64>,
    material: &Arc<Material>,
) -> Drawable {
    drawable(display, fixed_from_object, Geometry::Mesh { mesh: shape.mesh(), material: material.clone() })
}

pub(crate) fn axes_colors(alpha: f32) -> [Rgba; 3] {
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|[r, g, b]| Rgba::new(r, g, b, alpha))
}

pub(crate) fn axes_materials(alpha: f32) -> [Arc<Material>; 3] {
    axes_colors(alpha).map(|color| Arc::new(Material::lit(color)))
}

/// Three cylinders along the axes of a frame, of a length and a diameter in metres (rviz calls the latter "Radius").
pub(crate) fn axes(
    display: DisplayId,
    fixed_from_axes: &Matrix4<f64>,
    length_m: f64,
    diameter_m: f64,
    materials: &[Arc<Material>; 3],
) -> [Drawable; 3] {
    let axes_from_cylinders = axes_from_cylinders(length_m, diameter_m);
    [0, 1, 2].map(|i| solid(display, SolidShape::Cylinder, fixed_from_axes * axes_from_cylinders[i], &materials[i]))
}

pub(crate) fn axes_from_cylinders(length_m: f64, diameter_m: f64) -> [Matrix4<f64>; 3] {
    let turns = [
        Rotation3::from_axis_angle(&Vector3::z_axis(), -FRAC_PI_2),
        Rotation3::identity(),
        Rotation3::from_axis_angle(&Vector3::x_axis(), FRAC_PI_2),
    ];
    [0, 1, 2].map(|axis| {
        let mut middle = Vector3::zeros();
        middle[axis] = length_m / 2.0;
        Translation3::from(middle).to_homogeneous()
            * turns[axis].to_homogeneous()
            * Matrix4::new_nonuniform_scaling(&Vector3::new(diameter_m, length_m, diameter_m))
    })
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ArrowSize {
    pub(crate) shaft_length_m: f64,
    pub(crate) shaft_diameter_m: f64,
    pub(crate) head_length_m: f64,
    pub(crate) head_diameter_m: f64,
}

impl ArrowSize {
    /// Cylinder and cone in a frame whose y points along the arrow.
    pub(crate) fn upright_from_parts(&self) -> [(SolidShape, Matrix4<f64>); 2] {
        let part = |bottom_m: f64, length_m: f64, diameter_m: f64| {
            Matrix4::new_translation(&Vector3::new(0.0, bottom_m + length_m / 2.0, 0.0))
                * Matrix4::new_nonuniform_scaling(&Vector3::new(diameter_m, length_m, diameter_m))
        };
        [
            (SolidShape::Cylinder, part(0.0, self.shaft_length_m, self.shaft_diameter_m)),
            (SolidShape::Cone, part(self.shaft_length_m, self.head_length_m, self.head_diameter_m)),
        ]
    }
}

/// Rotation of an arrow's upright parts into its −z. In whole numbers, so that parts scaled to zero are exactly flat.
#[rustfmt::skip]
pub(crate) fn arrow_from_upright() -> Matrix4<f64> {
    Matrix3::new(
        1.0, 0.0, 0.0,
        0.0, 0.0, 1.0,
        0.0, -1.0, 0.0,
    ).to_homogeneous()
}

/// An arrow from the origin of its own frame along −z, the direction of rviz's arrows without rotation.
pub(crate) fn arrow(
    display: DisplayId,
    fixed_from_arrow: &Matrix4<f64>,
    size: &ArrowSize,
    shaft: &Arc<Material>,
    head: &Arc<Material>,
) -> [Drawable; 2] {
    let fixed_from_upright = fixed_from_arrow * arrow_from_upright();
    let [(cylinder, upright_from_cylinder), (cone, upright_from_cone)] = size.upright_from_parts();
    [
        solid(display, cylinder, fixed_from_upright * upright_from_cylinder, shaft),
        solid(display, cone, fixed_from_upright * upright_from_cone, head),
    ]
}

/// Rotation of an arrow into the x of a pose.
#[rustfmt::skip]
pub(crate) fn pose_from_arrow() -> Matrix4<f64> {
    Matrix3::new(
        0.0, 0.0, -1.0,
        0.0, 1.0, 0.0,
        1.0, 0.0, 0.0,
    ).to_homogeneous()
}

/// Shortest rotation of an arrow's −z into a direction of any length above zero; the identity for zero.
pub(crate) fn arrow_turn(direction: &Vector3<f64>) -> UnitQuaternion<f64> {
    let backwards = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::PI);
    if direction.norm_squared() == 0.0 {
        return UnitQuaternion::identity();
    }
    UnitQuaternion::rotation_between(&-Vector3::z(), direction).unwrap_or(backwards)
}

/// Pose of an arrow at a point, pointing in a direction.
pub(crate) fn arrow_pose(position: Vector3<f64>, direction: &Vector3<f64>) -> Matrix4<f64> {
    Isometry3::from_parts(Translation3::from(position), arrow_turn(direction)).to_homogeneous()
}
