//! The programs as a user has them, against a real ROS: roscore, rosbag play, rostopic, rosservice, a projector's window.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod camera_info;
mod check;
mod check_live;
mod diagnostics;
mod frame_rate;
mod latency;
mod life;
mod live_is_offline;
mod names;
mod render;
mod settings;
mod simulated_time;
mod transforms;
mod viewers;
mod wrong_messages;
