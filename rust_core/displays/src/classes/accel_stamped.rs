//! `rviz/AccelStamped`: a linear and an angular acceleration as arrows.

use rcs_messages::geometry_msgs::{AccelStamped, Vector3};
use rcs_rviz_config::ScrewSettings;
use rcs_scene::DisplayId;

use crate::framework::display::Display;
use crate::parts::screw::{ScrewDisplay, ScrewMessage};

impl ScrewMessage for AccelStamped {
    fn parts(&self) -> (&Vector3, &Vector3) {
        (&self.accel.linear, &self.accel.angular)
    }
}

/// Makes an AccelStamped display.
pub(crate) fn create(display: DisplayId, settings: &ScrewSettings) -> Box<dyn Display> {
    Box::new(ScrewDisplay::<AccelStamped>::of(display, settings))
}
