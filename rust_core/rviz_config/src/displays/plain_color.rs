//! `rviz/GridCells` and `rviz/Polygon`: messages that are drawn in one colour.

use crate::section::Section;

/// The properties of a GridCells or Polygon display.
#[derive(Debug, Clone, PartialEq)]
pub struct PlainColorSettings {
    /// Topic of the class's messages; empty when none is chosen.
    pub topic: String,
    /// How many messages may wait for their transform.
    pub queue_size: u32,
    /// Red, green and blue.
    pub color: [u8; 3],
    /// Opacity, 0 to 1. A Polygon is opaque in rviz whatever it is.
    pub alpha: f32,
}

impl Default for PlainColorSettings {
    fn default() -> Self {
        PlainColorSettings { topic: String::new(), queue_size: 10, color: [25, 255, 0], alpha: 1.0 }
    }
}

impl PlainColorSettings {
    pub(crate) fn read(section: &mut Section<'_>) -> Self {
        let mut settings = PlainColorSettings::default();
        section.subscription(&mut settings.topic, 0, &mut settings.queue_size);
        section.color("Color", &mut settings.color);
        section.float("Alpha", 0.0..=1.0, &mut settings.alpha);
        settings
    }
}
