//! `rviz/Path`: a `nav_msgs/Path` as a line, with axes or arrows at its poses.

use crate::displays::line_style::{LineStyle, LINE_STYLES};
use crate::section::{at_least, ANY};

/// Symbol of each pose of a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PoseStyle {
    /// Nothing.
    None,
    /// The pose's axes.
    Axes,
    /// An arrow along the pose's X.
    Arrows,
}

const POSE_STYLES: [(&str, PoseStyle); 3] =
    [("None", PoseStyle::None), ("Axes", PoseStyle::Axes), ("Arrows", PoseStyle::Arrows)];

properties! {
    /// The properties of a Path display. Lengths, radii and opacity have no bounds in rviz.
    pub struct PathSettings {
        /// Topic of `nav_msgs/Path`; empty when none is chosen.
        topic: String = String::new() => topic("Topic");
        /// Most messages that wait for their transform.
        queue_size: u32 = 10 => count("Queue Size", 0);
        /// How the line is drawn.
        line_style: LineStyle = LineStyle::Lines => choice("Line Style", &LINE_STYLES);
        /// Width of a line of style [`LineStyle::Billboards`] in metres; at least 0.001.
        line_width_m: f32 = 0.03 => float("Line Width", at_least(0.001));
        /// Colour of the line, as red, green and blue.
        color: [u8; 3] = [25, 255, 0] => color("Color");
        /// Opacity of the line; 1 is opaque.
        alpha: f32 = 1.0 => float("Alpha", ANY);
        /// Number of the latest paths that are drawn; at least 1.
        buffer_length: u32 = 1 => count("Buffer Length", 1);
        /// Shift of the whole path in the fixed frame, in metres.
        offset_m: [f32; 3] = [0.0; 3] => vector("Offset");
        /// Symbol of each pose.
        pose_style: PoseStyle = PoseStyle::None => choice("Pose Style", &POSE_STYLES);
        /// Length of the axes in metres.
        axes_length_m: f32 = 0.3 => float("Length", ANY);
        /// Radius of the axes in metres.
        axes_radius_m: f32 = 0.03 => float("Radius", ANY);
        /// The arrows.
        arrow: PathArrowSettings = PathArrowSettings::default() => properties();
    }
}

properties! {
    /// The arrows at the poses of a Path display. Lengths and diameters have no bounds in rviz.
    pub struct PathArrowSettings {
        /// Red, green and blue.
        color: [u8; 3] = [255, 85, 255] => color("Pose Color");
        /// Length of the shaft in metres.
        shaft_length_m: f32 = 0.1 => float("Shaft Length", ANY);
        /// Length of the head in metres.
        head_length_m: f32 = 0.2 => float("Head Length", ANY);
        /// Diameter of the shaft in metres.
        shaft_diameter_m: f32 = 0.1 => float("Shaft Diameter", ANY);
        /// Diameter of the head in metres.
        head_diameter_m: f32 = 0.3 => float("Head Diameter", ANY);
    }
}
