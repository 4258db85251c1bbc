//! `rviz/Illuminance`: one point where the sensor is, coloured by its measurement in lux.

use std::sync::Arc;

use rcs_messages::sensor_msgs::Illuminance;
use rcs_rviz_config::CloudSettings;
use rcs_scene::DisplayId;

use crate::framework::display::Display;
use crate::parts::cloud::{CloudDisplay, CloudSource, NonFinite, PlacedCloud};
use crate::parts::single_value::cloud_of_one;
use crate::World;

/// `sensor_msgs/Illuminance` as a cloud of one point.
#[derive(Debug)]
struct IlluminanceSource;

/// Makes a Illuminance display.
pub(crate) fn create(display: DisplayId, settings: &CloudSettings) -> Box<dyn Display> {
    Box::new(CloudDisplay::<IlluminanceSource>::new(display, settings.clone()))
}

impl CloudSource for IlluminanceSource {
    type Message = Illuminance;
    const NON_FINITE: NonFinite = NonFinite::FarAway;

    fn place(message: &Arc<Illuminance>, world: &World<'_>) -> Result<PlacedCloud, String> {
        let cloud = cloud_of_one(&message.header, "illuminance", message.illuminance);
        PlacedCloud::at_stamp(Arc::new(cloud), world)
    }
}
