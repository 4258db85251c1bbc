//! The ROS 1 messages that the project takes and sends.
//!
//! The small messages are those that `rosrust_msg` generates from the installed definitions, under the names of their
//! packages: [`geometry_msgs::Pose`], [`visualization_msgs::Marker`] and so on. The big ones, [`PointCloud2`],
//! [`Image`] and [`OccupancyGrid`], are types of our own, because the generated ones decode their data number by
//! number: they keep the bytes that were received and give views of them. [`Serialized`] is a message of any type that
//! is not decoded yet.
//!
//! Decoding never reads past the bytes given, never allocates for a length that those bytes cannot hold, and reports
//! bytes left over as an error.
//! [`MessageKind`] names the types that the displays draw and [`AnyMessage`] holds one message of any of them.
//!
//! Of rosrust only the traits of messages and services and the types of time are used. Whatever has a connection is in
//! the crate `rcs_ros`, which runs code for a type that is known at run time through [`MessageKind::visit`].

#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod any;
mod bayer;
mod buffer_pool;
mod bytes;
mod cloud_points;
mod convert;
mod fields;
mod image;
mod layout;
mod occupancy_grid;
mod point_cloud2;
mod serialized;
mod wire;

pub mod dynamic_reconfigure;
pub mod moveit_msgs;
pub mod nav_msgs;
pub mod roscpp;
pub mod sensor_msgs;
pub mod trajectory_msgs;

pub use any::{header, AnyMessage, MessageKind, MessageVisitor, TypedMessage};
pub use buffer_pool::BufferPool;
pub use bytes::{free_unused_bytes, pooled_bytes, SharedBytes};
pub use cloud_points::NoPositions;
pub use convert::{point_xyz, quaternion_xyzw, stamp_nanos, translation_xyz, PlainTransform};
pub use image::Image;
pub use occupancy_grid::OccupancyGrid;
pub use point_cloud2::PointCloud2;
pub use rosrust::{Duration, Message, RosMsg, ServicePair, Time};
pub use rosrust_msg::{
    diagnostic_msgs, geometry_msgs, map_msgs, rosgraph_msgs, std_msgs, std_srvs, tf2_msgs, visualization_msgs,
};
pub use serialized::Serialized;
pub use wire::{decode, encode, DecodeError};
