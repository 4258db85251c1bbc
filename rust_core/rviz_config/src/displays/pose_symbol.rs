//! The symbol of a pose, which Pose, PoseWithCovariance and Odometry share: an arrow or axes, and their sizes.

use crate::section::{Section, ANY};

/// Symbol of a pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PoseShape {
    /// An arrow along the pose's X.
    Arrow,
    /// The pose's axes.
    Axes,
}

const POSE_SHAPES: [(&str, PoseShape); 2] = [("Arrow", PoseShape::Arrow), ("Axes", PoseShape::Axes)];

properties! {
    /// How a pose is drawn. Lengths and radii have no bounds in rviz, and a "radius" is drawn as a diameter.
    pub struct PoseSymbolSettings {
        /// Arrow or axes.
        shape: PoseShape = PoseShape::Arrow;
        /// Colour of the arrow, as red, green and blue.
        color: [u8; 3] = [255, 25, 0] => color("Color");
        /// Opacity of the arrow, 0 to 1. Axes are opaque.
        alpha: f32 = 1.0 => float("Alpha", 0.0..=1.0);
        /// Length of the arrow's shaft in metres.
        shaft_length_m: f32 = 1.0 => float("Shaft Length", ANY);
        /// "Radius" of the arrow's shaft in metres.
        shaft_radius_m: f32 = 0.05 => float("Shaft Radius", ANY);
        /// Length of the arrow's head in metres.
        head_length_m: f32 = 0.3 => float("Head Length", ANY);
        /// "Radius" of the arrow's head in metres.
        head_radius_m: f32 = 0.1 => float("Head Radius", ANY);
        /// Length of each of the axes in metres.
        axes_length_m: f32 = 1.0 => float("Axes Length", ANY);
        /// "Radius" of the axes in metres.
        axes_radius_m: f32 = 0.1 => float("Axes Radius", ANY);
    }
}

impl Section<'_> {
    /// Reads a symbol from the keys beside `Shape`, as Pose and PoseWithCovariance have them.
    pub(crate) fn pose_symbol(&mut self, symbol: &mut PoseSymbolSettings) {
        self.choice("Shape", &POSE_SHAPES, &mut symbol.shape);
        self.properties(symbol);
    }

    /// Reads a symbol from the keys inside `Shape`, as Odometry has them.
    pub(crate) fn pose_symbol_inside_shape(&mut self, symbol: &mut PoseSymbolSettings) {
        let mut inside = self.child("Shape");
        inside.choice("Value", &POSE_SHAPES, &mut symbol.shape);
        inside.properties(symbol);
        inside.finish();
    }
}
