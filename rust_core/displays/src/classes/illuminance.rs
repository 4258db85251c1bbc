//! `rviz/Illuminance`: one point where the sensor is, coloured by its measurement in lux.

use rcs_messages::sensor_msgs::Illuminance;
use rcs_rviz_config::CloudSettings;
use rcs_scene::DisplayId;

use crate::framework::display::Display;
use crate::parts::single_value::{SingleValue, SingleValueDisplay};

impl SingleValue for Illuminance {
    const CHANNEL: &'static str = "illuminance";

    fn value(&self) -> f64 {
        self.illuminance
    }
}

/// Makes an Illuminance display.
pub(crate) fn create(display: DisplayId, settings: &CloudSettings) -> Box<dyn Display> {
    Box::new(SingleValueDisplay::<Illuminance>::new(display, settings.clone()))
}
