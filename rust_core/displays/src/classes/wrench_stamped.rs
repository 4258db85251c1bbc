//! `rviz/WrenchStamped`: a force and a torque as arrows.

use rcs_messages::geometry_msgs::{Vector3, WrenchStamped};
use rcs_rviz_config::ScrewSettings;
use rcs_scene::DisplayId;

use crate::framework::message_display::MessageDisplay;
use crate::parts::screw::{self, ScrewMessage, ScrewVisual};

impl ScrewMessage for WrenchStamped {
    fn parts(&self) -> (&Vector3, &Vector3) {
        (&self.wrench.force, &self.wrench.torque)
    }
}

pub(crate) fn create(display: DisplayId, settings: &ScrewSettings) -> MessageDisplay<ScrewVisual<WrenchStamped>> {
    screw::create(display, settings)
}
