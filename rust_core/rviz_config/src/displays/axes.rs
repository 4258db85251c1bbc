//! `rviz/Axes`: three cylinders along the axes of a frame.

use crate::section::{at_least, Section};

/// The properties of an Axes display.
#[derive(Debug, Clone, PartialEq)]
pub struct AxesSettings {
    /// The frame whose axes are shown; `None` is the fixed frame.
    pub reference_frame: Option<String>,
    /// Length of each axis in metres; at least 0.0001.
    pub length_m: f32,
    /// Radius of each axis in metres; at least 0.0001.
    pub radius_m: f32,
    /// Whether a two metre ribbon follows the frame.
    pub show_trail: bool,
    /// Opacity, 0 to 1.
    pub alpha: f32,
}

impl Default for AxesSettings {
    fn default() -> Self {
        AxesSettings { reference_frame: None, length_m: 1.0, radius_m: 0.1, show_trail: false, alpha: 1.0 }
    }
}

impl AxesSettings {
    pub(crate) fn read(section: &mut Section<'_>) -> Self {
        let mut settings = AxesSettings::default();
        section.frame_or_fixed("Reference Frame", &mut settings.reference_frame);
        section.float("Length", at_least(0.0001), &mut settings.length_m);
        section.float("Radius", at_least(0.0001), &mut settings.radius_m);
        section.bool("Show Trail", &mut settings.show_trail);
        section.float("Alpha", 0.0..=1.0, &mut settings.alpha);
        settings
    }
}
