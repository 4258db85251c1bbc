//! Bags, one or several: their topics, and their messages in the order of time.
//!
//! A bag is a sequence of chunks with messages, and an index. Chunks may overlap in time, most of all those of several
//! files, so a chunk is unpacked when the iteration reaches its first message, and only chunks that overlap are in
//! memory. Two formats are read: ROS 1's own (`rosbag_file`), and MCAP with messages of ROS 1 (`mcap_file`).
//!
//! Announced lengths are checked against the file's before memory is allocated. Tests write bags with
//! `rcs_test_support`.

#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod bag;
mod bounded_file;
mod chunked;
mod compression;
mod connection;
mod error;
mod mcap_file;
mod mcap_index;
mod mcap_records;
mod messages;
mod rosbag_file;

pub use bag::Bag;
pub use connection::Connection;
pub use error::BagError;
pub use messages::{BagMessage, Messages};
