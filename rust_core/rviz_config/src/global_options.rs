//! The section `Global Options`: settings of the whole scene.

properties! {
    /// The section `Global Options` of a config.
    pub struct GlobalOptions {
        /// The frame in which the scene is assembled, without a leading `/`.
        fixed_frame: String = "map".to_owned() => frame("Fixed Frame");
        /// Images a second that rviz draws. rviz takes any integer; below 1 it has no rate.
        frame_rate_hz: i32 = 30 => int("Frame Rate");
        /// Background of rviz's own window, as red, green and blue; cameras have their own.
        background_color: [u8; 3] = [48, 48, 48] => color("Background Color");
        /// `true` for a light in the direction of the main view.
        default_light: bool = true => bool("Default Light");
    }
}
