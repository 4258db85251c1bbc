//! `rviz/FluidPressure`: one point where the sensor is, coloured by its measurement in pascals.

use rcs_messages::sensor_msgs::FluidPressure;
use rcs_rviz_config::CloudSettings;
use rcs_scene::DisplayId;

use crate::parts::single_value::{SingleValue, SingleValueDisplay};

impl SingleValue for FluidPressure {
    const CHANNEL: &'static str = "fluid_pressure";

    fn value(&self) -> f64 {
        self.fluid_pressure
    }
}

pub(crate) fn create(display: DisplayId, settings: &CloudSettings) -> SingleValueDisplay<FluidPressure> {
    SingleValueDisplay::new(display, settings.clone())
}
