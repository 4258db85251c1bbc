//! `rviz/MarkerArray`: the [`marker`](crate::classes::marker) display that takes arrays only.

use rcs_rviz_config::MarkerSettings;
use rcs_scene::DisplayId;

use crate::classes::marker::MarkerDisplay;

pub(crate) fn create(display: DisplayId, settings: &MarkerSettings) -> MarkerDisplay {
    MarkerDisplay::new(display, settings.clone(), false)
}
