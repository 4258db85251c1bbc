//! `rviz/PointStamped`: the last points of a `geometry_msgs/PointStamped` topic as spheres.

use crate::section::{Section, ANY, MAX_HISTORY};

/// The properties of a PointStamped display. Opacity and radius have no bounds in rviz.
#[derive(Debug, Clone, PartialEq)]
pub struct PointStampedSettings {
    /// Topic of `geometry_msgs/PointStamped`; empty when none is chosen.
    pub topic: String,
    /// How many messages may wait for their transform.
    pub queue_size: u32,
    /// Red, green and blue.
    pub color: [u8; 3],
    /// Opacity; 1 is opaque.
    pub alpha: f32,
    /// Radius of the spheres in metres.
    pub radius_m: f32,
    /// How many of the latest points are shown, 1 to 100,000.
    pub history_length: u32,
}

impl Default for PointStampedSettings {
    fn default() -> Self {
        PointStampedSettings {
            topic: String::new(),
            queue_size: 10,
            color: [204, 41, 204],
            alpha: 1.0,
            radius_m: 0.2,
            history_length: 1,
        }
    }
}

impl PointStampedSettings {
    pub(crate) fn read(section: &mut Section<'_>) -> Self {
        let mut settings = PointStampedSettings::default();
        section.subscription(&mut settings.topic, 0, &mut settings.queue_size);
        section.color("Color", &mut settings.color);
        section.float("Alpha", ANY, &mut settings.alpha);
        section.float("Radius", ANY, &mut settings.radius_m);
        section.count_in("History Length", 1..=MAX_HISTORY, &mut settings.history_length);
        settings
    }
}
