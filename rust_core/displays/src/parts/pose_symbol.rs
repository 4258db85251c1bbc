//! The symbol of a pose: an arrow along its x, or its axes.

use nalgebra::{Isometry3, Matrix4};
use rcs_rviz_config::{PoseShape, PoseSymbolSettings};
use rcs_scene::{DisplayId, Drawable, Rgba};

use crate::parts::gathering::Gathering;
use crate::parts::solids::{arrow_from_upright, axes_colors, axes_from_cylinders, pose_from_arrow, ArrowSize};
use crate::SolidShape;

#[derive(Clone, Debug)]
pub(crate) enum PoseSymbol {
    Arrow { size: ArrowSize, color: Rgba },
    Axes { length_m: f64, diameter_m: f64 },
}

impl PoseSymbol {
    pub(crate) fn arrow(size: ArrowSize, color: [u8; 3], alpha: f32) -> Self {
        Self::Arrow { size, color: Rgba::from_rgb8(color, alpha) }
    }

    /// Opaque axes.
    pub(crate) fn axes(length_m: f32, diameter_m: f32) -> Self {
        Self::Axes { length_m: length_m.into(), diameter_m: diameter_m.into() }
    }

    pub(crate) fn drawables(&self, display: DisplayId, fixed_from_pose: &Isometry3<f64>) -> Vec<Drawable> {
        self.at_all(display, std::iter::once(*fixed_from_pose))
    }

    pub(crate) fn at_all(
        &self,
        display: DisplayId,
        fixed_from_poses: impl Iterator<Item = Isometry3<f64>>,
    ) -> Vec<Drawable> {
        match self {
            Self::Arrow { size, color } => {
                arrows(display, size, *color, fixed_from_poses.map(|pose| pose.to_homogeneous() * pose_from_arrow()))
            }
            Self::Axes { length_m, diameter_m } => all_axes(display, *length_m, *diameter_m, fixed_from_poses),
        }
    }
}

pub(crate) fn arrows(
    display: DisplayId,
    size: &ArrowSize,
    color: Rgba,
    fixed_from_arrows: impl Iterator<Item = Matrix4<f64>>,
) -> Vec<Drawable> {
    let parts = size.upright_from_parts().map(|(shape, upright_from_part)| (shape.mesh(), upright_from_part));
    let arrow_from_upright = arrow_from_upright();
    let mut gathering = Gathering::new(display);
    for fixed_from_arrow in fixed_from_arrows {
        let fixed_from_upright = fixed_from_arrow * arrow_from_upright;
        for (mesh, upright_from_part) in &parts {
            gathering.solid(mesh, &(fixed_from_upright * upright_from_part), color);
        }
    }
    gathering.finish()
}

/// Opaque axes of one size at many poses.
pub(crate) fn all_axes(
    display: DisplayId,
    length_m: f64,
    diameter_m: f64,
    fixed_from_axes: impl Iterator<Item = Isometry3<f64>>,
) -> Vec<Drawable> {
    let (mesh, colors) = (SolidShape::Cylinder.mesh(), axes_colors(1.0));
    let axes_from_cylinders = axes_from_cylinders(length_m, diameter_m);
    let mut gathering = Gathering::new(display);
    for fixed_from_axes in fixed_from_axes {
        let fixed_from_axes = fixed_from_axes.to_homogeneous();
        for (axes_from_cylinder, color) in axes_from_cylinders.iter().zip(colors) {
            gathering.solid(&mesh, &(fixed_from_axes * axes_from_cylinder), color);
        }
    }
    gathering.finish()
}

impl From<&PoseSymbolSettings> for PoseSymbol {
    fn from(settings: &PoseSymbolSettings) -> Self {
        match settings.shape {
            PoseShape::Arrow => {
                // rviz passes its "radii" to something that takes diameters.
                let size = ArrowSize {
                    shaft_length_m: settings.shaft_length_m.into(),
                    shaft_diameter_m: settings.shaft_radius_m.into(),
                    head_length_m: settings.head_length_m.into(),
                    head_diameter_m: settings.head_radius_m.into(),
                };
                Self::arrow(size, settings.color, settings.alpha)
            }
            PoseShape::Axes => Self::axes(settings.axes_length_m, settings.axes_radius_m),
        }
    }
}
