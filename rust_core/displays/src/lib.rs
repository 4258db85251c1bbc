//! rviz's displays: settings, messages and transforms into scene primitives.
//!
//! One file for each display class. [`DisplaySet`] holds all displays of a config; it is told of messages, asks the
//! displays what changed, and hands out the [`rcs_scene::Scene`] that every camera looks at. Nothing here connects to
//! ROS, reads a clock or draws: the picture is a function of the config, the messages and a time.
#![forbid(unsafe_code)]

mod arrivals;
mod axes;
mod bounds;
mod cloud;
mod covariance;
mod depth_cloud;
mod display;
mod effort;
mod frame;
mod grid;
mod grid_cells;
mod interactive_markers;
mod laser_scan;
mod map;
mod marker;
mod message_display;
mod not_drawn;
mod odometry;
mod path;
mod placed;
mod point_cloud;
mod point_cloud2;
mod point_stamped;
mod polygon;
mod pose;
mod pose_array;
mod pose_symbol;
mod pose_with_covariance;
mod range;
mod recall;
mod report;
mod robot_description;
mod robot_model;
mod scalar;
mod screw;
mod set;
mod shapes;
mod solids;
mod status;
mod tf;
mod trail;
mod urdf;
mod world;

pub use arrivals::ShownMessage;
pub use display::TopicRequest;
pub use report::DisplayReport;
pub use set::{CameraView, DisplaySet, ListedDisplay, Reconfigured};
pub use shapes::Shape;
pub use status::{Level, Status, Statuses};
pub use world::World;
