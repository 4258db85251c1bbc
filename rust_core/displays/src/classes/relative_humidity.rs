//! `rviz/RelativeHumidity`: one point where the sensor is, coloured by its measurement 0 to 1.

use rcs_messages::sensor_msgs::RelativeHumidity;
use rcs_rviz_config::CloudSettings;
use rcs_scene::DisplayId;

use crate::parts::single_value::{SingleValue, SingleValueDisplay};

impl SingleValue for RelativeHumidity {
    const CHANNEL: &'static str = "relative_humidity";

    fn value(&self) -> f64 {
        self.relative_humidity
    }
}

pub(crate) fn create(display: DisplayId, settings: &CloudSettings) -> SingleValueDisplay<RelativeHumidity> {
    SingleValueDisplay::new(display, settings.clone())
}
