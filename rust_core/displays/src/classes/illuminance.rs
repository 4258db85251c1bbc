//! `rviz/Illuminance`: one point where the sensor is, coloured by its measurement in lux.

use rcs_messages::sensor_msgs::Illuminance;
use rcs_rviz_config::CloudSettings;
use rcs_scene::DisplayId;

use crate::parts::single_value::{SingleValue, SingleValueDisplay};

impl SingleValue for Illuminance {
    const CHANNEL: &'static str = "illuminance";

    fn value(&self) -> f64 {
        self.illuminance
    }
}

pub(crate) fn create(display: DisplayId, settings: &CloudSettings) -> SingleValueDisplay<Illuminance> {
    SingleValueDisplay::new(display, settings.clone())
}
