//! `rviz/TwistStamped`: a linear and an angular velocity as arrows.

use rcs_messages::MessageKind;
use rcs_rviz_config::ScrewSettings;
use rcs_scene::DisplayId;

use crate::framework::display::Display;
use crate::parts::screw::ScrewDisplay;

/// Makes a TwistStamped display.
pub(crate) fn create(display: DisplayId, settings: &ScrewSettings) -> Box<dyn Display> {
    Box::new(ScrewDisplay::new(display, settings.clone(), MessageKind::TwistStamped))
}
