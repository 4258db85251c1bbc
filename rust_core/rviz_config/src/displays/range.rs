//! `rviz/Range`: a `sensor_msgs/Range` as a cone as long as the measured distance.

use crate::section::ANY;

properties! {
    /// The properties of a Range display. The opacity has no bounds in rviz.
    pub struct RangeSettings {
        /// Topic of `sensor_msgs/Range`; empty when none is chosen.
        topic: String = String::new() => topic("Topic");
        /// Most messages that wait for their transform.
        queue_size: u32 = 10 => count("Queue Size", 0);
        /// Colour of the cone, as red, green and blue.
        color: [u8; 3] = [255, 255, 255] => color("Color");
        /// Opacity; 1 is opaque.
        alpha: f32 = 0.5 => float("Alpha", ANY);
        /// Number of the latest measurements that are drawn; at least 1.
        buffer_length: u32 = 1 => count("Buffer Length", 1);
    }
}
