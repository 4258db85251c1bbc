//! The ROS 1 messages that the project takes and sends.
//!
//! Every message is a plain Rust struct whose fields have the names of the ROS message's (`type` is `type_`), in a
//! module named after its package: [`geometry_msgs::Pose`], [`visualization_msgs::Marker`] and so on. The two big
//! ones, [`PointCloud2`] and [`Image`], keep the bytes that were received and give views of them.
//!
//! [`Wire`] is ROS 1's serialisation. Its decoding never reads past the bytes given, never allocates for a length
//! that those bytes cannot hold, and reports each such length as a [`DecodeError`].
//! [`MessageKind`] names the types that the displays draw and [`AnyMessage`] holds one message of any of them.
//!
//! No ROS installation is needed, neither to build nor to run: the definitions are written in Rust, and each message's
//! checksum (`MD5SUM`) is the one that a ROS node compares when it connects.

mod any;
mod convert;
mod image;
mod message;
mod point_cloud2;
mod time;
mod wire;

pub mod geometry_msgs;
pub mod nav_msgs;
pub mod rosgraph_msgs;
pub mod sensor_msgs;
pub mod std_msgs;
pub mod std_srvs;
pub mod tf2_msgs;
pub mod visualization_msgs;

pub use any::{header, AnyMessage, MessageKind};
pub use convert::{point_xyz, quaternion_xyzw, stamp_nanos, translation_xyz, PlainTransform};
pub use image::{Image, ImageFrame};
pub use message::{decode, encode, Message, Service};
pub use point_cloud2::PointCloud2;
pub use time::{Duration, Time};
pub use wire::{DecodeError, Reader, Wire};
