//! `rviz/Temperature`: one point where the sensor is, coloured by its measurement in degrees Celsius.

use rcs_messages::sensor_msgs::Temperature;
use rcs_rviz_config::CloudSettings;
use rcs_scene::DisplayId;

use crate::parts::single_value::{SingleValue, SingleValueDisplay};

impl SingleValue for Temperature {
    const CHANNEL: &'static str = "temperature";

    fn value(&self) -> f64 {
        self.temperature
    }
}

pub(crate) fn create(display: DisplayId, settings: &CloudSettings) -> SingleValueDisplay<Temperature> {
    SingleValueDisplay::new(display, settings.clone())
}
