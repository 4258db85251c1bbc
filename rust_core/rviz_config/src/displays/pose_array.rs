//! `rviz/PoseArray`: a `geometry_msgs/PoseArray` as arrows of lines, arrows of solids, or axes.

use crate::section::ANY;

/// Symbol of each pose of an array.
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

properties! {
    /// The properties of a PoseArray display. Lengths and radii have no bounds in rviz, and a "radius" is drawn as a
    /// diameter.
    pub struct PoseArraySettings {
        /// Topic of `geometry_msgs/PoseArray`; empty when none is chosen.
        topic: String = String::new() => topic("Topic");
        /// Most messages that wait for their transform.
        queue_size: u32 = 10 => count("Queue Size", 0);
        /// Symbol of each pose.
        shape: PoseArrayShape = PoseArrayShape::ArrowFlat => choice("Shape", &SHAPES);
        /// Colour of arrows, as red, green and blue.
        color: [u8; 3] = [255, 25, 0] => color("Color");
        /// Opacity of arrows, 0 to 1. Axes and flat arrows are opaque.
        alpha: f32 = 1.0 => float("Alpha", 0.0..=1.0);
        /// Length of a flat arrow in metres.
        flat_arrow_length_m: f32 = 0.3 => float("Arrow Length", ANY);
        /// Length of an arrow's shaft in metres.
        shaft_length_m: f32 = 0.23 => float("Shaft Length", ANY);
        /// "Radius" of an arrow's shaft in metres.
        shaft_radius_m: f32 = 0.01 => float("Shaft Radius", ANY);
        /// Length of an arrow's head in metres.
        head_length_m: f32 = 0.07 => float("Head Length", ANY);
        /// "Radius" of an arrow's head in metres.
        head_radius_m: f32 = 0.03 => float("Head Radius", ANY);
        /// Length of each of the axes in metres.
        axes_length_m: f32 = 0.3 => float("Axes Length", ANY);
        /// "Radius" of the axes in metres.
        axes_radius_m: f32 = 0.01 => float("Axes Radius", ANY);
    }
}
