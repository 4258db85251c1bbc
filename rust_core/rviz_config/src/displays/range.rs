//! `rviz/Range`: a `sensor_msgs/Range` as a cone as long as what was measured.

use crate::section::{Section, ANY};

/// The properties of a Range display. The opacity has no bounds in rviz.
#[derive(Debug, Clone, PartialEq)]
pub struct RangeSettings {
    /// Topic of `sensor_msgs/Range`; empty when none is chosen.
    pub topic: String,
    /// How many messages may wait for their transform.
    pub queue_size: u32,
    /// Colour of the cone, as red, green and blue.
    pub color: [u8; 3],
    /// Opacity; 1 is opaque.
    pub alpha: f32,
    /// How many of the latest measurements are shown; at least 1.
    pub buffer_length: u32,
}

impl Default for RangeSettings {
    fn default() -> Self {
        RangeSettings { topic: String::new(), queue_size: 10, color: [255, 255, 255], alpha: 0.5, buffer_length: 1 }
    }
}

impl RangeSettings {
    pub(crate) fn read(section: &mut Section<'_>) -> Self {
        let mut settings = RangeSettings::default();
        section.subscription(&mut settings.topic, 0, &mut settings.queue_size);
        section.color("Color", &mut settings.color);
        section.float("Alpha", ANY, &mut settings.alpha);
        section.count("Buffer Length", 1, &mut settings.buffer_length);
        settings
    }
}
