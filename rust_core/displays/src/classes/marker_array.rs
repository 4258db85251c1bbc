//! `rviz/MarkerArray`: the [`marker`](crate::classes::marker) display that takes arrays only.

use rcs_rviz_config::MarkerSettings;
use rcs_scene::DisplayId;

use crate::classes::marker::MarkerDisplay;
use crate::framework::display::Display;

/// Makes a MarkerArray display.
pub(crate) fn create(display: DisplayId, settings: &MarkerSettings) -> Box<dyn Display> {
    Box::new(MarkerDisplay::array(display, settings.clone()))
}
