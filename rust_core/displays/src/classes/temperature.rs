//! `rviz/Temperature`: one point where the sensor is, coloured by its measurement in degrees Celsius.

use std::sync::Arc;

use rcs_messages::sensor_msgs::Temperature;
use rcs_rviz_config::CloudSettings;
use rcs_scene::DisplayId;

use crate::framework::display::Display;
use crate::parts::cloud::{CloudDisplay, CloudSource, NonFinite, PlacedCloud};
use crate::parts::single_value::cloud_of_one;
use crate::World;

/// `sensor_msgs/Temperature` as a cloud of one point.
#[derive(Debug)]
struct TemperatureSource;

/// Makes a Temperature display.
pub(crate) fn create(display: DisplayId, settings: &CloudSettings) -> Box<dyn Display> {
    Box::new(CloudDisplay::<TemperatureSource>::new(display, settings.clone()))
}

impl CloudSource for TemperatureSource {
    type Message = Temperature;
    const NON_FINITE: NonFinite = NonFinite::FarAway;

    fn place(message: &Arc<Temperature>, world: &World<'_>) -> Result<PlacedCloud, String> {
        let cloud = cloud_of_one(&message.header, "temperature", message.temperature);
        PlacedCloud::at_stamp(Arc::new(cloud), world)
    }
}
