//! The programs, one folder each, and what they share: logging, and the life cycle of a ROS node.
#![forbid(unsafe_code)]

pub mod all_programs;
pub mod camera_stream;
mod frames;
mod key_value;
pub mod line_of_sight;
pub mod logging;
pub mod monitor_arguments;
pub mod nav_path_markers;
mod node_options;
mod node_status;
mod poses;
pub mod projector;
pub mod projector_blend;
pub mod projector_calibrate;
pub mod projector_window;
pub mod publish_cloud;
pub mod small_node;
mod target;
pub mod turret_aim;
mod window_watch;
