//! `rviz/Image`: an image in a panel of rviz's window, and nothing in the scene.

use rcs_rviz_config::ImageSettings;
use rcs_scene::DisplayId;

use crate::framework::not_drawn::NotDrawnDisplay;

pub(crate) fn create(_display: DisplayId, _settings: &ImageSettings) -> NotDrawnDisplay {
    NotDrawnDisplay::window_only()
}
