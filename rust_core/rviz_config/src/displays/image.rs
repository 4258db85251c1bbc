//! `rviz/Image` and `rviz/Camera`: an image in a panel of rviz's window, a Camera's with the scene over it.
//!
//! Neither puts anything into the scene, so a virtual camera does not see them. Their properties are known and have no
//! effect, but for the topic, which is listed.

use crate::section::Section;

/// The properties that both have.
const OF_BOTH: [&str; 4] = ["Transport Hint", "Queue Size", "Unreliable", "Timeout"];

/// The properties of an Image display alone.
const OF_IMAGE: [&str; 4] = ["Normalize Range", "Min Value", "Max Value", "Median window"];

/// The properties of a Camera display alone.
const OF_CAMERA: [&str; 4] = ["Image Rendering", "Overlay Alpha", "Zoom Factor", "Visibility"];

/// What is kept of an Image or a Camera display.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ImageSettings {
    /// Topic of `sensor_msgs/Image`; empty when none is chosen.
    pub topic: String,
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

    fn read(section: &mut Section<'_>) -> Self {
        let mut settings = ImageSettings::default();
        section.text("Image Topic", &mut settings.topic);
        section.skip(&OF_BOTH);
        settings
    }
}
