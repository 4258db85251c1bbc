//! `rviz/GridCells` and `rviz/Polygon`: messages that are drawn in one colour.

properties! {
    /// The properties of a GridCells or Polygon display.
    pub struct PlainColorSettings {
        /// Topic of the class's messages; empty when none is chosen.
        topic: String = String::new() => topic("Topic");
        /// Most messages that wait for their transform.
        queue_size: u32 = 10 => count("Queue Size", 0);
        /// Red, green and blue.
        color: [u8; 3] = [25, 255, 0] => color("Color");
        /// Opacity, 0 to 1. rviz draws a Polygon opaque at any value.
        alpha: f32 = 1.0 => float("Alpha", 0.0..=1.0);
    }
}
