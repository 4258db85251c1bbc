//! `rviz/AccelStamped`: a linear and an angular acceleration as arrows.

use rcs_messages::geometry_msgs::{AccelStamped, Vector3};
use rcs_rviz_config::ScrewSettings;
use rcs_scene::DisplayId;

use crate::framework::message_display::MessageDisplay;
use crate::parts::screw::{self, ScrewMessage, ScrewVisual};

impl ScrewMessage for AccelStamped {
    fn parts(&self) -> (&Vector3, &Vector3) {
        (&self.accel.linear, &self.accel.angular)
    }
}

pub(crate) fn create(display: DisplayId, settings: &ScrewSettings) -> MessageDisplay<ScrewVisual<AccelStamped>> {
    screw::create(display, settings)
}
