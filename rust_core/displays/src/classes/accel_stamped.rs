//! `rviz/AccelStamped`: a linear and an angular acceleration as arrows.

use rcs_messages::MessageKind;
use rcs_rviz_config::ScrewSettings;
use rcs_scene::DisplayId;

use crate::framework::display::Display;
use crate::parts::screw::ScrewDisplay;

/// Makes an AccelStamped display.
pub(crate) fn create(display: DisplayId, settings: &ScrewSettings) -> Box<dyn Display> {
    Box::new(ScrewDisplay::new(display, settings.clone(), MessageKind::AccelStamped))
}
