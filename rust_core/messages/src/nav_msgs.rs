//! `nav_msgs`, with our own type for the big message.

pub use crate::OccupancyGrid;
pub use rosrust_msg::nav_msgs::{GridCells, MapMetaData, Odometry, Path};
