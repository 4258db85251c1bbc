//! `rviz/Camera`: an image with the scene over it in a panel of rviz's window, and nothing in the scene.

use rcs_rviz_config::ImageSettings;
use rcs_scene::DisplayId;

use crate::framework::display::Display;
use crate::framework::not_drawn::NotDrawnDisplay;

/// Makes a Camera display.
pub(crate) fn create(_display: DisplayId, _settings: &ImageSettings) -> Box<dyn Display> {
    Box::new(NotDrawnDisplay::window_only())
}
