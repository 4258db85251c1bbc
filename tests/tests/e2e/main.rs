//! The programs as a user has them, against a real ROS: roscore, rosbag play, rostopic, rosservice, roslaunch.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod camera_info;
mod frame_rate;
