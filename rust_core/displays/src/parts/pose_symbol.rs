//! The symbol of a pose: an arrow along its x, or its axes.

use std::sync::Arc;

use nalgebra::Isometry3;
use rcs_rviz_config::{PoseShape, PoseSymbolSettings};
use rcs_scene::{DisplayId, Drawable, Material, Rgba};

use crate::parts::solids::{arrow, axes, axes_materials, pose_from_arrow, ArrowSize};

/// A symbol, made ready to be drawn at many poses.
#[derive(Clone, Debug)]
pub(crate) enum PoseSymbol {
    /// An arrow of one colour.
    Arrow {
        /// Its sizes.
        size: ArrowSize,
        /// Its colour.
        material: Arc<Material>,
    },
    /// Red, green and blue axes.
    Axes {
        /// Length in metres.
        length_m: f64,
        /// Diameter in metres.
        diameter_m: f64,
        /// The colours.
        materials: [Arc<Material>; 3],
    },
}

impl PoseSymbol {
    /// An arrow of a colour.
    pub(crate) fn arrow(size: ArrowSize, color: [u8; 3], alpha: f32) -> Self {
        Self::Arrow { size, material: Arc::new(Material::lit(Rgba::from_rgb8(color, alpha))) }
    }

    /// Opaque axes.
    pub(crate) fn axes(length_m: f32, diameter_m: f32) -> Self {
        let (length_m, diameter_m) = (length_m.into(), diameter_m.into());
        Self::Axes { length_m, diameter_m, materials: axes_materials(1.0) }
    }

    /// At a pose in the fixed frame.
    pub(crate) fn drawables(&self, display: DisplayId, fixed_from_pose: &Isometry3<f64>) -> Vec<Drawable> {
        let fixed_from_pose = fixed_from_pose.to_homogeneous();
        match self {
            Self::Arrow { size, material } => {
                arrow(display, &(fixed_from_pose * pose_from_arrow()), size, material, material).into()
            }
            Self::Axes { length_m, diameter_m, materials } => {
                axes(display, &fixed_from_pose, *length_m, *diameter_m, materials).into()
            }
        }
    }
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
