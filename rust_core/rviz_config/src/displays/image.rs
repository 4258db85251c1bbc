//! `rviz/Image` and `rviz/Camera`: an image in a panel of rviz's window, a Camera's with the scene over it.
//!
//! Neither is part of the scene, so a virtual camera does not see them: of their properties, only the topic is kept.

use crate::section::{Properties, Section};

/// The keys of an Image display alone.
const OF_IMAGE: [&str; 4] = ["Normalize Range", "Min Value", "Max Value", "Median window"];

/// The keys of a Camera display alone.
const OF_CAMERA: [&str; 4] = ["Image Rendering", "Overlay Alpha", "Zoom Factor", "Visibility"];

properties! {
    /// The properties of an Image or a Camera display.
    pub struct ImageSettings {
        /// Topic of `sensor_msgs/Image`; empty when none is chosen.
        topic: String = String::new() => topic("Image Topic");
    }
    skip ["Transport Hint", "Queue Size", "Timeout"];
}

impl ImageSettings {
    pub(crate) fn read_image(section: &mut Section<'_>) -> Self {
        section.skip(&OF_IMAGE);
        Self::read(section)
    }

    pub(crate) fn read_camera(section: &mut Section<'_>) -> Self {
        section.skip(&OF_CAMERA);
        Self::read(section)
    }
}
