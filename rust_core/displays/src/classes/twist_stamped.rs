//! `rviz/TwistStamped`: a linear and an angular velocity as arrows.

use rcs_messages::geometry_msgs::{TwistStamped, Vector3};
use rcs_rviz_config::ScrewSettings;
use rcs_scene::DisplayId;

use crate::framework::display::Display;
use crate::parts::screw::{ScrewDisplay, ScrewMessage};

impl ScrewMessage for TwistStamped {
    fn parts(&self) -> (&Vector3, &Vector3) {
        (&self.twist.linear, &self.twist.angular)
    }
}

/// Makes a TwistStamped display.
pub(crate) fn create(display: DisplayId, settings: &ScrewSettings) -> Box<dyn Display> {
    Box::new(ScrewDisplay::<TwistStamped>::of(display, settings))
}
