//! The section `Global Options`: what holds for the whole scene.

use crate::section::Section;

/// The section `Global Options` of a config.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GlobalOptions {
    /// The frame in which the scene is assembled, without a leading `/`.
    pub fixed_frame: String,
    /// How often rviz redraws, in pictures a second. rviz takes any integer; one below 1 is no rate.
    pub frame_rate_hz: i32,
    /// Background of rviz's own window, as red, green and blue; cameras have their own.
    pub background_color: [u8; 3],
    /// Whether there is a light, which shines where the main view looks.
    pub default_light: bool,
}

impl Default for GlobalOptions {
    fn default() -> Self {
        GlobalOptions {
            fixed_frame: "map".to_owned(),
            frame_rate_hz: 30,
            background_color: [48, 48, 48],
            default_light: true,
        }
    }
}

impl GlobalOptions {
    pub(crate) fn read(mut section: Section<'_>) -> Self {
        let mut options = GlobalOptions::default();
        section.frame("Fixed Frame", &mut options.fixed_frame);
        section.int("Frame Rate", &mut options.frame_rate_hz);
        section.color("Background Color", &mut options.background_color);
        section.bool("Default Light", &mut options.default_light);
        section.finish();
        options
    }
}
