//! `sensor_msgs`, with our own types for the two big messages.

pub use crate::{Image, PointCloud2};
pub use rosrust_msg::sensor_msgs::{
    CameraInfo, ChannelFloat32, CompressedImage, FluidPressure, Illuminance, JointState, LaserScan, PointCloud,
    PointField, Range, RegionOfInterest, RelativeHumidity, Temperature, TimeReference,
};
