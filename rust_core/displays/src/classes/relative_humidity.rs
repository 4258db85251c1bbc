//! `rviz/RelativeHumidity`: one point where the sensor is, coloured by its measurement 0 to 1.

use std::sync::Arc;

use rcs_messages::sensor_msgs::RelativeHumidity;
use rcs_rviz_config::CloudSettings;
use rcs_scene::DisplayId;

use crate::framework::display::Display;
use crate::parts::cloud::{CloudDisplay, CloudSource, NonFinite, PlacedCloud};
use crate::parts::single_value::cloud_of_one;
use crate::World;

/// `sensor_msgs/RelativeHumidity` as a cloud of one point.
#[derive(Debug)]
struct RelativeHumiditySource;

/// Makes a RelativeHumidity display.
pub(crate) fn create(display: DisplayId, settings: &CloudSettings) -> Box<dyn Display> {
    Box::new(CloudDisplay::<RelativeHumiditySource>::new(display, settings.clone()))
}

impl CloudSource for RelativeHumiditySource {
    type Message = RelativeHumidity;
    const NON_FINITE: NonFinite = NonFinite::FarAway;

    fn place(message: &Arc<RelativeHumidity>, world: &World<'_>) -> Result<PlacedCloud, String> {
        let cloud = cloud_of_one(&message.header, "relative_humidity", message.relative_humidity);
        PlacedCloud::at_stamp(Arc::new(cloud), world)
    }
}
