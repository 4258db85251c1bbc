//! `rviz/PointStamped`: the last points of a `geometry_msgs/PointStamped` topic as spheres.

use crate::section::{ANY, MAX_HISTORY};

properties! {
    /// The properties of a PointStamped display. Opacity and radius have no bounds in rviz.
    pub struct PointStampedSettings {
        /// Topic of `geometry_msgs/PointStamped`; empty when none is chosen.
        topic: String = String::new() => topic("Topic");
        /// Most messages that wait for their transform.
        queue_size: u32 = 10 => count("Queue Size", 0);
        /// Red, green and blue.
        color: [u8; 3] = [204, 41, 204] => color("Color");
        /// Opacity; 1 is opaque.
        alpha: f32 = 1.0 => float("Alpha", ANY);
        /// Radius of the spheres in metres.
        radius_m: f32 = 0.2 => float("Radius", ANY);
        /// Number of the latest points that are drawn, 1 to 100,000.
        history_length: u32 = 1 => count_in("History Length", 1..=MAX_HISTORY);
    }
}
