//! `rviz/Path`: a `nav_msgs/Path` as a line, with axes or arrows at its poses.

use crate::displays::{LineStyle, LINE_STYLES};
use crate::section::{at_least, Section, ANY};

/// What is drawn at each pose of a path.
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

/// The properties of a Path display. Lengths, radii, diameters and opacity have no bounds in rviz.
#[derive(Debug, Clone, PartialEq)]
pub struct PathSettings {
    /// Topic of `nav_msgs/Path`; empty when none is chosen.
    pub topic: String,
    /// How many messages may wait for their transform.
    pub queue_size: u32,
    /// How the line is drawn.
    pub line_style: LineStyle,
    /// Width of a line of style [`LineStyle::Billboards`] in metres; at least 0.001.
    pub line_width_m: f32,
    /// Colour of the line, as red, green and blue.
    pub color: [u8; 3],
    /// Opacity of the line; 1 is opaque.
    pub alpha: f32,
    /// How many of the latest paths are shown; at least 1.
    pub buffer_length: u32,
    /// Shift of the whole path in the fixed frame, in metres.
    pub offset_m: [f32; 3],
    /// What is drawn at each pose.
    pub pose_style: PoseStyle,
    /// Length of the axes in metres.
    pub axes_length_m: f32,
    /// Radius of the axes in metres.
    pub axes_radius_m: f32,
    /// Colour of the arrows, as red, green and blue.
    pub arrow_color: [u8; 3],
    /// Length of an arrow's shaft in metres.
    pub shaft_length_m: f32,
    /// Length of an arrow's head in metres.
    pub head_length_m: f32,
    /// Diameter of an arrow's shaft in metres.
    pub shaft_diameter_m: f32,
    /// Diameter of an arrow's head in metres.
    pub head_diameter_m: f32,
}

impl Default for PathSettings {
    fn default() -> Self {
        PathSettings {
            topic: String::new(),
            queue_size: 10,
            line_style: LineStyle::Lines,
            line_width_m: 0.03,
            color: [25, 255, 0],
            alpha: 1.0,
            buffer_length: 1,
            offset_m: [0.0; 3],
            pose_style: PoseStyle::None,
            axes_length_m: 0.3,
            axes_radius_m: 0.03,
            arrow_color: [255, 85, 255],
            shaft_length_m: 0.1,
            head_length_m: 0.2,
            shaft_diameter_m: 0.1,
            head_diameter_m: 0.3,
        }
    }
}

impl PathSettings {
    pub(crate) fn read(section: &mut Section<'_>) -> Self {
        let mut settings = PathSettings::default();
        section.subscription(&mut settings.topic, 0, &mut settings.queue_size);
        section.choice("Line Style", &LINE_STYLES, &mut settings.line_style);
        section.float("Line Width", at_least(0.001), &mut settings.line_width_m);
        section.color("Color", &mut settings.color);
        section.float("Alpha", ANY, &mut settings.alpha);
        section.count("Buffer Length", 1, &mut settings.buffer_length);
        section.vector("Offset", &mut settings.offset_m);
        section.choice("Pose Style", &POSE_STYLES, &mut settings.pose_style);
        section.float("Length", ANY, &mut settings.axes_length_m);
        section.float("Radius", ANY, &mut settings.axes_radius_m);
        section.color("Pose Color", &mut settings.arrow_color);
        section.float("Shaft Length", ANY, &mut settings.shaft_length_m);
        section.float("Head Length", ANY, &mut settings.head_length_m);
        section.float("Shaft Diameter", ANY, &mut settings.shaft_diameter_m);
        section.float("Head Diameter", ANY, &mut settings.head_diameter_m);
        settings
    }
}
