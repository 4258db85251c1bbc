//! `rviz/FluidPressure`, `rviz/Illuminance`, `rviz/RelativeHumidity` and `rviz/Temperature`: one point where the sensor
//! is, coloured by what it measured.

use std::sync::Arc;

use rcs_messages::sensor_msgs::{FluidPressure, Illuminance, PointField, RelativeHumidity, Temperature};
use rcs_messages::std_msgs::Header;
use rcs_messages::{AnyMessage, MessageKind, PointCloud2};

use crate::parts::cloud::{one_row, CloudSource, Nowhere, PlacedCloud};
use crate::World;

/// A cloud of one point at the origin, with its value in a field of a name.
fn cloud_of_one(header: &Header, name: &str, value: f64) -> PointCloud2 {
    let fields = [
        ("x", 0, PointField::FLOAT32),
        ("y", 4, PointField::FLOAT32),
        ("z", 8, PointField::FLOAT32),
        (name, 12, PointField::FLOAT64),
    ];
    let mut data = vec![0; 12];
    data.extend(value.to_le_bytes());
    one_row(header, &fields, 20, data)
}

macro_rules! scalar_source {
    ($(#[$doc:meta])* $source:ident, $message:ident, $value:ident) => {
        $(#[$doc])*
        #[derive(Debug)]
        pub(crate) struct $source;

        impl CloudSource for $source {
            type Message = $message;
            const KIND: MessageKind = MessageKind::$message;
            const NOWHERE: Nowhere = Nowhere::FarAway;

            fn message(any: &AnyMessage) -> Option<&Arc<$message>> {
                match any {
                    AnyMessage::$message(message) => Some(message),
                    _ => None,
                }
            }

            fn header(message: &$message) -> &Header {
                &message.header
            }

            fn place(message: &Arc<$message>, world: &World<'_>) -> Result<PlacedCloud, String> {
                let cloud = cloud_of_one(&message.header, stringify!($value), message.$value);
                PlacedCloud::at_stamp(Arc::new(cloud), world)
            }
        }
    };
}

scalar_source! {
    /// `sensor_msgs/FluidPressure`, in pascals.
    FluidPressureSource, FluidPressure, fluid_pressure
}
scalar_source! {
    /// `sensor_msgs/Illuminance`, in lux.
    IlluminanceSource, Illuminance, illuminance
}
scalar_source! {
    /// `sensor_msgs/RelativeHumidity`, 0 to 1.
    RelativeHumiditySource, RelativeHumidity, relative_humidity
}
scalar_source! {
    /// `sensor_msgs/Temperature`, in degrees Celsius.
    TemperatureSource, Temperature, temperature
}
