//! `rviz/WrenchStamped`: a force and a torque as arrows.

use rcs_messages::geometry_msgs::{Vector3, WrenchStamped};
use rcs_rviz_config::ScrewSettings;
use rcs_scene::DisplayId;

use crate::framework::display::Display;
use crate::parts::screw::{ScrewDisplay, ScrewMessage};

impl ScrewMessage for WrenchStamped {
    fn parts(&self) -> (&Vector3, &Vector3) {
        (&self.wrench.force, &self.wrench.torque)
    }
}

/// Makes a WrenchStamped display.
pub(crate) fn create(display: DisplayId, settings: &ScrewSettings) -> Box<dyn Display> {
    Box::new(ScrewDisplay::<WrenchStamped>::of(display, settings))
}
