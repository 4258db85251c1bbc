//! The covariance of a pose: an ellipsoid for its position, discs or a cone for its orientation.
//!
//! Reproduces `rviz::CovarianceVisual`. The ellipsoid has the axes of the message's frame. Of a pose in space, roll,
//! pitch and yaw are a flat elliptic disc each: it is placed on its axis and shows how far the tip of that axis sways
//! under rotations about the other two (yaw's has these two swapped, in rviz and here). Of a pose in the plane, the yaw
//! is a flat cone from the pose along its x.

mod principal_axes;
mod shape;

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use nalgebra::{Isometry3, Matrix4, Rotation3, Translation3, Vector3};
use rcs_rviz_config::{
    CovarianceColorStyle, CovarianceFrame, CovarianceSettings, OrientationCovarianceSettings,
    PositionCovarianceSettings,
};
use rcs_scene::{DisplayId, Drawable, Material, Rgba};

use crate::parts::solids::solid;
use crate::SolidShape;

pub(crate) use shape::{uncertain_pose, Covariance, CovarianceScales};
use shape::{OrientationShape, FLAT_M};

/// Largest drawn angle: angles are drawn as the lengths of their tangents.
const MAX_ANGLE_RAD: f64 = 89.0 * std::f64::consts::PI / 180.0;

/// Distance along x of the middle of a cone of 1 m whose tip is at the pose; measured in rviz, the tip misses a little.
const CONE_MIDDLE_M: f64 = 0.49115;

/// Materials and settings of covariances.
#[derive(Debug)]
pub(crate) struct CovarianceSymbol {
    display: DisplayId,
    position: Option<(PositionCovarianceSettings, Arc<Material>)>,
    /// Settings with the materials of roll, pitch and yaw.
    orientation: Option<(OrientationCovarianceSettings, [Arc<Material>; 3])>,
}

impl CovarianceSymbol {
    pub(crate) fn new(display: DisplayId, settings: &CovarianceSettings) -> Self {
        let position = settings.position.clone().map(|settings| {
            let material = Arc::new(Material::lit(Rgba::from_rgb8(settings.color, settings.alpha)));
            (settings, material)
        });
        let orientation = settings.orientation.clone().map(|settings| {
            let colors = match settings.color_style {
                CovarianceColorStyle::Unique => [settings.color; 3],
                CovarianceColorStyle::Rgb => [[255, 0, 0], [0, 255, 0], [0, 0, 255]],
            };
            let materials = colors.map(|color| Arc::new(Material::lit(Rgba::from_rgb8(color, settings.alpha))));
            (settings, materials)
        });
        Self { display, position, orientation }
    }

    /// Drawables of a covariance whose pose is `frame_from_pose` in the message's frame; `scales` are those of the
    /// covariances before it.
    pub(crate) fn drawables(
        &self,
        fixed_from_frame: &Isometry3<f64>,
        frame_from_pose: &Isometry3<f64>,
        covariance: &Covariance,
        scales: &mut CovarianceScales,
    ) -> Vec<Drawable> {
        let fixed_from_pose = fixed_from_frame * frame_from_pose;
        let fixed_from_center = Isometry3::from_parts(fixed_from_pose.translation, fixed_from_frame.rotation);
        let shape = scales.update(covariance);
        let mut drawables = Vec::new();
        if let Some((settings, material)) = &self.position {
            let center_from_sphere = shape.ellipsoid_axes.to_homogeneous()
                * Matrix4::new_nonuniform_scaling(&(shape.ellipsoid_m * f64::from(settings.scale)));
            let fixed_from_sphere = fixed_from_center.to_homogeneous() * center_from_sphere;
            drawables.push(solid(self.display, SolidShape::Sphere, fixed_from_sphere, material));
        }
        if let Some((settings, [red, green, blue])) = &self.orientation {
            let fixed_from_root = match settings.frame {
                CovarianceFrame::Local => fixed_from_pose,
                CovarianceFrame::Fixed => fixed_from_center,
            };
            let fixed_from_root = fixed_from_root.to_homogeneous();
            match &shape.orientation {
                OrientationShape::Discs { axes, diameters_rad } => {
                    let offset_m = f64::from(settings.offset_m);
                    let discs = axes.iter().zip(diameters_rad).zip(disc_poses(offset_m)).zip([red, green, blue]);
                    for (((axes, diameters_rad), root_from_upright), material) in discs {
                        let Some([x, z]) = diameters_rad.map(|angles| angles.map(|angle| width(angle, settings.scale)))
                        else {
                            continue;
                        };
                        let upright_from_disc = axes.to_homogeneous()
                            * Matrix4::new_nonuniform_scaling(&Vector3::new(offset_m * x, FLAT_M, offset_m * z));
                        let fixed_from_disc = fixed_from_root * root_from_upright * upright_from_disc;
                        drawables.push(solid(self.display, SolidShape::Cylinder, fixed_from_disc, material));
                    }
                }
                OrientationShape::Cone(Some(width_rad)) => {
                    let length_m = f64::from(settings.offset_m);
                    let size = Vector3::new(length_m * width(*width_rad, settings.scale), length_m, FLAT_M);
                    let root_from_cone = Translation3::new(CONE_MIDDLE_M * length_m, 0.0, 0.0).to_homogeneous()
                        * Rotation3::from_axis_angle(&Vector3::z_axis(), FRAC_PI_2).to_homogeneous()
                        * Matrix4::new_nonuniform_scaling(&size);
                    drawables.push(solid(self.display, SolidShape::Cone, fixed_from_root * root_from_cone, blue));
                }
                OrientationShape::Cone(None) => {}
            }
        }
        // Shapes too large for single precision are not drawn.
        drawables.retain(|drawable| drawable.fixed_from_object.iter().all(|value| (*value as f32).is_finite()));
        drawables
    }
}

/// Poses of the discs of roll, pitch and yaw: on their axes, their cylinders' y along it.
fn disc_poses(offset_m: f64) -> [Matrix4<f64>; 3] {
    let [about_x, about_y, about_z] = [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()]
        .map(|axis| Rotation3::from_axis_angle(&axis, FRAC_PI_2));
    [(Vector3::x(), about_x * about_z), (Vector3::y(), about_y), (Vector3::z(), about_x)]
        .map(|(axis, turn)| Translation3::from(axis * offset_m).to_homogeneous() * turn.to_homogeneous())
}

/// Width of a scaled angle at a distance of 1 m.
fn width(full_rad: f64, scale: f32) -> f64 {
    2.0 * (full_rad * f64::from(scale) / 2.0).min(MAX_ANGLE_RAD).tan()
}

#[cfg(test)]
mod tests;
