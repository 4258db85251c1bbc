//! The symbol of a pose, which Pose, PoseWithCovariance and Odometry share: an arrow or axes, and their sizes.

use crate::section::{Section, ANY};

/// What stands at a pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PoseShape {
    /// An arrow along the pose's X.
    Arrow,
    /// The pose's axes.
    Axes,
}

const POSE_SHAPES: [(&str, PoseShape); 2] = [("Arrow", PoseShape::Arrow), ("Axes", PoseShape::Axes)];

/// How a pose is drawn. Lengths and radii have no bounds in rviz, and what rviz calls a radius it draws as a diameter.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseSymbolSettings {
    /// Which symbol it is.
    pub shape: PoseShape,
    /// Colour of the arrow, as red, green and blue.
    pub color: [u8; 3],
    /// Opacity of the arrow, 0 to 1. Axes are opaque.
    pub alpha: f32,
    /// Length of the arrow's shaft in metres.
    pub shaft_length_m: f32,
    /// "Radius" of the arrow's shaft in metres.
    pub shaft_radius_m: f32,
    /// Length of the arrow's head in metres.
    pub head_length_m: f32,
    /// "Radius" of the arrow's head in metres.
    pub head_radius_m: f32,
    /// Length of each of the axes in metres.
    pub axes_length_m: f32,
    /// "Radius" of the axes in metres.
    pub axes_radius_m: f32,
}

impl Default for PoseSymbolSettings {
    fn default() -> Self {
        PoseSymbolSettings {
            shape: PoseShape::Arrow,
            color: [255, 25, 0],
            alpha: 1.0,
            shaft_length_m: 1.0,
            shaft_radius_m: 0.05,
            head_length_m: 0.3,
            head_radius_m: 0.1,
            axes_length_m: 1.0,
            axes_radius_m: 0.1,
        }
    }
}

impl PoseSymbolSettings {
    /// Reads the keys beside `Shape`, as Pose and PoseWithCovariance have them.
    pub(crate) fn read(section: &mut Section<'_>) -> Self {
        let mut settings = PoseSymbolSettings::default();
        section.choice("Shape", &POSE_SHAPES, &mut settings.shape);
        settings.read_sizes(section);
        settings
    }

    /// Reads the keys inside `Shape`, as Odometry has them.
    pub(crate) fn read_inside_shape(section: &mut Section<'_>) -> Self {
        let mut settings = PoseSymbolSettings::default();
        let mut inside = section.child("Shape");
        inside.choice("Value", &POSE_SHAPES, &mut settings.shape);
        settings.read_sizes(&mut inside);
        inside.finish();
        settings
    }

    fn read_sizes(&mut self, section: &mut Section<'_>) {
        section.color("Color", &mut self.color);
        section.float("Alpha", 0.0..=1.0, &mut self.alpha);
        section.float("Shaft Length", ANY, &mut self.shaft_length_m);
        section.float("Shaft Radius", ANY, &mut self.shaft_radius_m);
        section.float("Head Length", ANY, &mut self.head_length_m);
        section.float("Head Radius", ANY, &mut self.head_radius_m);
        section.float("Axes Length", ANY, &mut self.axes_length_m);
        section.float("Axes Radius", ANY, &mut self.axes_radius_m);
    }
}
