//! `rviz/FluidPressure`: one point where the sensor is, coloured by its measurement in pascals.

use std::sync::Arc;

use rcs_messages::sensor_msgs::FluidPressure;
use rcs_rviz_config::CloudSettings;
use rcs_scene::DisplayId;

use crate::framework::display::Display;
use crate::parts::cloud::{CloudDisplay, CloudSource, NonFinite, PlacedCloud};
use crate::parts::single_value::cloud_of_one;
use crate::World;

/// `sensor_msgs/FluidPressure` as a cloud of one point.
#[derive(Debug)]
struct FluidPressureSource;

/// Makes a FluidPressure display.
pub(crate) fn create(display: DisplayId, settings: &CloudSettings) -> Box<dyn Display> {
    Box::new(CloudDisplay::<FluidPressureSource>::new(display, settings.clone()))
}

impl CloudSource for FluidPressureSource {
    type Message = FluidPressure;
    const NON_FINITE: NonFinite = NonFinite::FarAway;

    fn place(message: &Arc<FluidPressure>, world: &World<'_>) -> Result<PlacedCloud, String> {
        let cloud = cloud_of_one(&message.header, "fluid_pressure", message.fluid_pressure);
        PlacedCloud::at_stamp(Arc::new(cloud), world)
    }
}
