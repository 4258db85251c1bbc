//! `rviz/Axes`: three cylinders along the axes of a frame.

use crate::section::at_least;

properties! {
    /// The properties of an Axes display.
    pub struct AxesSettings {
        /// The frame whose axes are drawn; `None` is the fixed frame.
        reference_frame: Option<String> = None => frame_or_fixed("Reference Frame");
        /// Length of each axis in metres; at least 0.0001.
        length_m: f32 = 1.0 => float("Length", at_least(0.0001));
        /// Radius of each axis in metres; at least 0.0001.
        radius_m: f32 = 0.1 => float("Radius", at_least(0.0001));
        /// `true` if a two metre ribbon follows the frame.
        show_trail: bool = false => bool("Show Trail");
        /// Opacity, 0 to 1.
        alpha: f32 = 1.0 => float("Alpha", 0.0..=1.0);
    }
}
