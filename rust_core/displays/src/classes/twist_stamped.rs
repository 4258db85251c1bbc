//! `rviz/TwistStamped`: a linear and an angular velocity as arrows.

use rcs_messages::geometry_msgs::{TwistStamped, Vector3};
use rcs_rviz_config::ScrewSettings;
use rcs_scene::DisplayId;

use crate::framework::message_display::MessageDisplay;
use crate::parts::screw::{self, ScrewMessage, ScrewVisual};

impl ScrewMessage for TwistStamped {
    fn parts(&self) -> (&Vector3, &Vector3) {
        (&self.twist.linear, &self.twist.angular)
    }
}

pub(crate) fn create(display: DisplayId, settings: &ScrewSettings) -> MessageDisplay<ScrewVisual<TwistStamped>> {
    screw::create(display, settings)
}
