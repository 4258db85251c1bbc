//! `rviz/PoseArray`: a `geometry_msgs/PoseArray` as arrows of lines, arrows of solids, or axes.

use crate::section::{Section, ANY};

/// What stands at each pose of an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PoseArrayShape {
    /// An arrow of three lines, one pixel wide, in the pose's XY plane.
    ArrowFlat,
    /// An arrow of shaft and head along the pose's X.
    Arrow3d,
    /// The pose's axes.
    Axes,
}

const SHAPES: [(&str, PoseArrayShape); 3] = [
    ("Arrow (Flat)", PoseArrayShape::ArrowFlat),
    ("Arrow (3D)", PoseArrayShape::Arrow3d),
    ("Axes", PoseArrayShape::Axes),
];

/// The properties of a PoseArray display. Lengths and radii have no bounds in rviz, and what rviz calls a radius it
/// draws as a diameter.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseArraySettings {
    /// Topic of `geometry_msgs/PoseArray`; empty when none is chosen.
    pub topic: String,
    /// How many messages may wait for their transform.
    pub queue_size: u32,
    /// What stands at each pose.
    pub shape: PoseArrayShape,
    /// Colour of arrows, as red, green and blue.
    pub color: [u8; 3],
    /// Opacity of arrows, 0 to 1. Axes and flat arrows are opaque.
    pub alpha: f32,
    /// Length of a flat arrow in metres.
    pub flat_arrow_length_m: f32,
    /// Length of an arrow's shaft in metres.
    pub shaft_length_m: f32,
    /// "Radius" of an arrow's shaft in metres.
    pub shaft_radius_m: f32,
    /// Length of an arrow's head in metres.
    pub head_length_m: f32,
    /// "Radius" of an arrow's head in metres.
    pub head_radius_m: f32,
    /// Length of each of the axes in metres.
    pub axes_length_m: f32,
    /// "Radius" of the axes in metres.
    pub axes_radius_m: f32,
}

impl Default for PoseArraySettings {
    fn default() -> Self {
        PoseArraySettings {
            topic: String::new(),
            queue_size: 10,
            shape: PoseArrayShape::ArrowFlat,
            color: [255, 25, 0],
            alpha: 1.0,
            flat_arrow_length_m: 0.3,
            shaft_length_m: 0.23,
            shaft_radius_m: 0.01,
            head_length_m: 0.07,
            head_radius_m: 0.03,
            axes_length_m: 0.3,
            axes_radius_m: 0.01,
        }
    }
}

impl PoseArraySettings {
    pub(crate) fn read(section: &mut Section<'_>) -> Self {
        let mut settings = PoseArraySettings::default();
        section.subscription(&mut settings.topic, 0, &mut settings.queue_size);
        section.choice("Shape", &SHAPES, &mut settings.shape);
        section.color("Color", &mut settings.color);
        section.float("Alpha", 0.0..=1.0, &mut settings.alpha);
        section.float("Arrow Length", ANY, &mut settings.flat_arrow_length_m);
        section.float("Shaft Length", ANY, &mut settings.shaft_length_m);
        section.float("Shaft Radius", ANY, &mut settings.shaft_radius_m);
        section.float("Head Length", ANY, &mut settings.head_length_m);
        section.float("Head Radius", ANY, &mut settings.head_radius_m);
        section.float("Axes Length", ANY, &mut settings.axes_length_m);
        section.float("Axes Radius", ANY, &mut settings.axes_radius_m);
        settings
    }
}
