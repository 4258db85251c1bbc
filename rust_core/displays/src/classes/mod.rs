//! One file or folder for each rviz display class.

pub(crate) mod axes;
pub(crate) mod depth_cloud;
pub(crate) mod effort;
pub(crate) mod grid;
pub(crate) mod grid_cells;
pub(crate) mod interactive_markers;
pub(crate) mod laser_scan;
pub(crate) mod map;
pub(crate) mod marker;
pub(crate) mod not_drawn;
pub(crate) mod odometry;
pub(crate) mod path;
pub(crate) mod point_cloud;
pub(crate) mod point_cloud2;
pub(crate) mod point_stamped;
pub(crate) mod polygon;
pub(crate) mod pose;
pub(crate) mod pose_array;
pub(crate) mod pose_with_covariance;
pub(crate) mod range;
pub(crate) mod robot_model;
pub(crate) mod scalar;
pub(crate) mod screw;
pub(crate) mod tf;
