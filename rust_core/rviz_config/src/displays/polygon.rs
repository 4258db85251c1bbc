//! `rviz/Polygon`: a `geometry_msgs/PolygonStamped` as a closed line.

use crate::section::Section;

/// The properties of a Polygon display.
#[derive(Debug, Clone, PartialEq)]
pub struct PolygonSettings {
    /// Topic of `geometry_msgs/PolygonStamped`; empty when none is chosen.
    pub topic: String,
    /// Whether UDP is preferred.
    pub unreliable: bool,
    /// How many messages may wait for their transform.
    pub queue_size: u32,
    /// Red, green and blue.
    pub color: [u8; 3],
    /// Opacity, 0 to 1. It has no effect in rviz.
    pub alpha: f32,
}

impl Default for PolygonSettings {
    fn default() -> Self {
        PolygonSettings { topic: String::new(), unreliable: false, queue_size: 10, color: [25, 255, 0], alpha: 1.0 }
    }
}

impl PolygonSettings {
    pub(crate) fn read(section: &mut Section<'_>) -> Self {
        let mut settings = PolygonSettings::default();
        section.text("Topic", &mut settings.topic);
        section.bool("Unreliable", &mut settings.unreliable);
        section.count("Queue Size", 0, &mut settings.queue_size);
        section.color("Color", &mut settings.color);
        section.float("Alpha", 0.0..=1.0, &mut settings.alpha);
        settings
    }
}
