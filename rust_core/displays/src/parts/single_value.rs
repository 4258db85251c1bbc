//! Messages of a single value: one point where the sensor is, coloured by what it measured.

use rcs_messages::sensor_msgs::PointField;
use rcs_messages::std_msgs::Header;
use rcs_messages::PointCloud2;

use crate::parts::cloud::one_row;

/// A cloud of one point at the origin, with its value in a field of a name.
pub(crate) fn cloud_of_one(header: &Header, name: &str, value: f64) -> PointCloud2 {
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
