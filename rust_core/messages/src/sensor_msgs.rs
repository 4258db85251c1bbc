//! `sensor_msgs`, with our own types for the two big messages.

pub use crate::{Image, PointCloud2};
pub use rosrust_msg::sensor_msgs::{CameraInfo, PointField, RegionOfInterest};
